// SPDX-License-Identifier: Apache-2.0
// specimen add, list, show.
#include <fmt/ostream.h>

#include <map>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "storage/specimens.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/specimen_lookup.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class AddCommand final : public Command {
 public:
  const char* name() const override { return "specimen add"; }
  const char* summary() const override { return "Store a specimen file under its name"; }
  const char* example() const override { return "lcrig specimen add my-stack.json"; }
  void declare(ArgumentList& list) override { list.positional("FILE", file_, "specimen/1 file"); }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<std::string> through_daemon(Context& context, const std::string& text) const;
  Outcome<std::string> into(const std::string& db_path, const std::string& name,
                            const std::string& text, const Clock& clock) const;
  std::string file_;
};

// The daemon's database has one writer: the daemon.
Outcome<std::string> AddCommand::through_daemon(Context& context, const std::string& text) const {
  auto socket = context.socket_path();
  if (!socket) return tl::unexpected(socket.error());
  auto client = ControlClient::connect(*socket, context.clock);
  if (!client) return tl::unexpected(client.error());
  json params = json::object();
  params["text"] = text;
  auto answer = client->call("specimen.add", params);
  if (!answer) return tl::unexpected(answer.error());
  return answer->is_object() ? answer->value("name", "") : std::string();
}

Outcome<std::string> AddCommand::into(const std::string& db_path, const std::string& name,
                                      const std::string& text, const Clock& clock) const {
  const std::filesystem::path path(db_path);
  std::error_code ignored;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
  auto db = open_read_write(db_path);
  if (!db) return tl::unexpected(Failure(db.error(), "lcrig specimen add FILE --db FILE"));
  auto stored = lcrig::add_specimen(*db, name, text, clock.unix_ns());
  if (!stored) return tl::unexpected(Failure(stored.error()));
  return stored->name;
}

Outcome<ExitCode> AddCommand::run(Context& context) {
  auto text = read_text_file(file_);
  if (!text) return tl::unexpected(Failure(text.error(), "check the path"));
  auto specimen = parse_specimen(*text, file_);
  if (!specimen) {
    return tl::unexpected(Failure(
        specimen.error(), "correct the file; `lcrig specimen show paper-1` prints a good one"));
  }
  Outcome<std::string> name = std::string();
  if (context.prefers_daemon_db()) {
    name = through_daemon(context, *text);
  } else {
    auto db = context.db_path();
    if (!db) return tl::unexpected(db.error());
    name = into(*db, specimen->name, *text, context.clock);
  }
  if (!name) return tl::unexpected(name.error());
  if (context.global.json) {
    print_json(context.console.out, json{{"name", *name}});
  } else {
    fmt::print(context.console.out, "stored specimen {}\n", printable(*name, kLongestName));
    fmt::print(context.console.err, "  next: lcrig rehearse static-frame --specimen {}\n",
               printable(*name, kLongestName));
  }
  return kOk;
}

class SpecimenListCommand final : public Command {
 public:
  const char* name() const override { return "specimen list"; }
  const char* summary() const override { return "The specimens that are known"; }
  const char* example() const override { return "lcrig specimen list"; }
  Outcome<ExitCode> run(Context& context) override;
};

Outcome<ExitCode> SpecimenListCommand::run(Context& context) {
  std::map<std::string, std::string> from;  // name -> where it comes from
  for (const auto& s : shipped_specimens()) from[std::string(s.name)] = "shipped";
  for (const auto& f : LibraryPath(context.env).list(LibraryKind::specimen)) {
    from[f.name] = f.path.string();
  }
  auto path = context.db_path();
  if (!path) return tl::unexpected(path.error());
  std::error_code ignored;
  if (std::filesystem::exists(*path, ignored)) {
    auto db = open_read_only(*path);
    if (!db) return tl::unexpected(Failure(db.error(), "give another --db"));
    auto stored = list_specimens(*db);
    if (!stored) return tl::unexpected(Failure(stored.error()));
    for (const auto& s : *stored) from[s.name] = fmt::format("database, version {}", s.version);
  }
  json rows = json::array();
  for (const auto& [name, source] : from) {
    rows.push_back(json{{"name", name}, {"source", source}});
    if (!context.global.json)
      fmt::print(context.console.out, "{:20} {}\n", printable(name, kLongestName),
                 printable(source, kLongestWords));
  }
  json all = json::object();
  all["specimens"] = std::move(rows);
  if (context.global.json) print_json(context.console.out, all);
  return kOk;
}

class SpecimenShowCommand final : public Command {
 public:
  const char* name() const override { return "specimen show"; }
  const char* summary() const override { return "The file of a specimen"; }
  const char* example() const override { return "lcrig specimen show paper-2"; }
  void declare(ArgumentList& list) override { list.positional("S", specimen_, "Name or file"); }
  Outcome<ExitCode> run(Context& context) override {
    auto db = context.db_path();
    if (!db) return tl::unexpected(db.error());
    auto found = find_specimen_text(context, *db, specimen_);
    if (!found) return tl::unexpected(found.error());
    if (context.global.json) {
      print_json(context.console.out, json{{"name", found->name}, {"text", found->text}});
      return kOk;
    }
    context.console.print_file(found->text);
    return kOk;
  }

 private:
  std::string specimen_;
};

}  // namespace

std::unique_ptr<Command> make_specimen_add_command() {
  return std::make_unique<AddCommand>();
}
std::unique_ptr<Command> make_specimen_list_command() {
  return std::make_unique<SpecimenListCommand>();
}
std::unique_ptr<Command> make_specimen_show_command() {
  return std::make_unique<SpecimenShowCommand>();
}

}  // namespace lcrig::cli
