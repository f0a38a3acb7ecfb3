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
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/library_path.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

// Proposes a run if the daemon owns the database, because a rehearsal does not read that one.
std::string pressing(const Context& context, const ChosenDatabase& db,
                     const std::string& specimen) {
  if (db.daemon_writes) {
    return next_command(context.global,
                        {"run", "static-frame", "--specimen", specimen, "--dry-run"});
  }
  return next_command(for_rehearsal(context, db.path),
                      {"rehearse", "static-frame", "--specimen", specimen});
}

Outcome<std::string> through_daemon(Context& context, const std::string& text) {
  auto answer = call_daemon(context, "specimen.add", json{{"text", text}});
  if (!answer) return answer.error();
  return answer->is_object() ? answer->value("name", "") : std::string();
}

Outcome<std::string> into(const std::string& db_path, const std::string& specimen,
                          const std::string& text, const Clock& clock) {
  const std::filesystem::path path(db_path);
  std::error_code ignored;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
  auto db = open_read_write(db_path);
  if (!db) return Failure(db.error(), "give another --db");
  auto stored = lcrig::add_specimen(*db, specimen, text, clock.unix_ns());
  if (!stored) return Failure(stored.error());
  return stored->name;
}

Outcome<ExitCode> specimen_add(Context& context, const std::string& file) {
  auto text = read_text_file(file);
  if (!text) return Failure(text.error(), "check the path");
  auto specimen = parse_specimen(*text, file);
  if (!specimen) {
    return Failure(specimen.error(),
                   "correct the file; `lcrig specimen show paper-1` prints a good one");
  }
  auto db = context.database_to_write({"specimen", "add", file});
  if (!db) return db.error();
  auto added = db->daemon_writes ? through_daemon(context, *text)
                                 : into(db->path, specimen->name, *text, context.clock);
  if (!added) return added.error();
  return show(context, json{{"name", *added}}, [&](std::ostream& out) {
    fmt::print(out, "stored specimen {}\n", printable(*added, kLongestName));
    context.console.next(pressing(context, *db, *added));
  });
}

constexpr OneWord kSpecimenAdd{"specimen add",
                               "Store a specimen file under its name",
                               "lcrig specimen add my-stack.json",
                               specimen_add,
                               kJsonFileWord,
                               "specimen/1 file"};

Outcome<ExitCode> specimen_list(Context& context, const std::string&) {
  std::map<std::string, std::string> from;  // from a specimen's name to its source
  for (const auto& s : shipped_specimens()) from[std::string(s.name)] = "shipped";
  for (const auto& f : LibraryPath(context.env).list(LibraryKind::specimen)) {
    from[f.name] = f.path.string();
  }
  auto path = context.db_path();
  if (!path) return path.error();
  std::error_code ignored;
  if (std::filesystem::exists(*path, ignored)) {
    auto db = open_read_only(*path);
    if (!db) return Failure(db.error(), "give another --db");
    auto stored = list_specimens(*db);
    if (!stored) return Failure(stored.error());
    for (const auto& s : *stored) from[s.name] = fmt::format("database, version {}", s.version);
  }
  json rows = json::array();
  for (const auto& [specimen, source] : from) {
    rows.push_back(json{{"name", specimen}, {"source", source}});
    if (context.global.json) continue;
    fmt::print(context.console.out, "{:20} {}\n", printable(specimen, kLongestName),
               printable(source, kLongestWords));
  }
  if (context.global.json) print_json(context.console.out, json{{"specimens", rows}});
  return kOk;
}

constexpr OneWord kSpecimenList{"specimen list", "The specimens that are known",
                                "lcrig specimen list", specimen_list};

class SpecimenShowCommand final : public Command {
 public:
  SpecimenShowCommand()
      : Command("specimen show", "The file of a specimen", "lcrig specimen show paper-2") {}
  void declare(ArgumentList& list) override {
    list.positional(kSpecimenWord, specimen_, "Name or file");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto db = context.db_path();
    if (!db) return db.error();
    auto found = find_specimen_text(context, *db, specimen_);
    if (!found) return found.error();
    return show(context, json{{"name", found->name}, {"text", found->text}},
                [&](std::ostream&) { context.console.print_file(found->text); });
  }

 private:
  std::string specimen_;
};

}  // namespace

const CommandFactory kSpecimenAddCommand = make_command<OneWordCommand, kSpecimenAdd>;
const CommandFactory kSpecimenListCommand = make_command<OneWordCommand, kSpecimenList>;
const CommandFactory kSpecimenShowCommand = make_command<SpecimenShowCommand>;

}  // namespace lcrig::cli
