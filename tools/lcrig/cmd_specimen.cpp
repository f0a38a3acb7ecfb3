// SPDX-License-Identifier: Apache-2.0
// specimen add, check, list, show.
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/strict_json.hpp"
#include "base/text.hpp"
#include "model/plausible.hpp"
#include "model/specimen_figures.hpp"
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

// A file as a person brings it in.
struct Brought {
  std::string text;
  Specimen specimen;
  std::vector<std::string> odd;  // implausible values
};

Outcome<Brought> bring(const std::string& file) {
  Brought out;
  auto text = read_text_file(file);
  if (!text) return Failure(text.error(), "check the path");
  out.text = std::move(*text);
  auto specimen = accept_specimen(out.text, file);
  if (!specimen) {
    return Failure(specimen.error(),
                   "correct the file; `lcrig specimen show paper-1` prints a good one");
  }
  out.specimen = std::move(*specimen);
  out.odd = implausible_values(out.specimen);
  return out;
}

json to_json(const Brought& brought) {
  json out = lcrig::to_json(figures_of(brought.specimen));
  out["name"] = brought.specimen.name;
  out["implausible"] = brought.odd;
  return out;
}

void print_brought(std::ostream& out, const char* done, const Brought& brought) {
  fmt::print(out, "{} specimen {}\n{}", done, printable(brought.specimen.name, kLongestName),
             to_text(figures_of(brought.specimen)));
  for (const std::string& odd : brought.odd) {
    fmt::print(out, "  implausible   {}\n", printable(odd, kLongestWords));
  }
}

class SpecimenAddCommand final : public Command {
 public:
  SpecimenAddCommand()
      : Command("specimen add", "Store a specimen file under its name",
                "lcrig specimen add my-stack.json") {}
  void declare(ArgumentList& list) override {
    list.positional(kJsonFileWord, file_, "specimen/1 file");
    list.flag("--as-stated", as_stated_, "Store implausible values without a question");
  }

  Outcome<ExitCode> run(Context& context) override {
    auto brought = bring(file_);
    if (!brought) return brought.error();
    if (auto meant = is_meant(context, *brought); !meant) return meant.error();
    auto db = context.database_to_write({"specimen", "add", file_});
    if (!db) return db.error();
    auto added = db->daemon_writes ? through_daemon(context, brought->text)
                                   : into(db->path, *brought, context.clock);
    if (!added) return added.error();
    brought->specimen.name = *added;
    return show(context, to_json(*brought), [&](std::ostream& out) {
      print_brought(out, "stored", *brought);
      context.console.next(pressing(context, *db, brought->specimen.name));
    });
  }

 private:
  // A person at a terminal is asked; anybody else has to say it beforehand.
  Outcome<void> is_meant(Context& context, const Brought& brought) {
    if (as_stated_ || brought.odd.empty()) return {};
    const std::string all = fmt::format("{}", fmt::join(brought.odd, "; "));
    Console& console = context.console;
    if (console.in_tty && console.err_tty && !context.global.json) {
      for (const std::string& odd : brought.odd) console.note(odd);
      const auto answer = console.wait_for_line("store it all the same? [y/N] ");
      as_stated_ = answer == "y" || answer == "Y" || answer == "yes";
      if (as_stated_) return {};
    }
    return Failure(kFailed, fmt::format("{}: nothing is stored: {}", file_, all),
                   next_command(context.global, {"specimen", "add", "--as-stated", file_},
                                "if that is what was meant; else correct the file"));
  }

  // The name under which it is stored.
  Outcome<std::string> through_daemon(Context& context, const std::string& text) const {
    json params{{"text", text}};
    if (as_stated_) params["as_stated"] = true;  // an older daemon does not know it
    auto answer = call_daemon(context, "specimen.add", std::move(params));
    if (!answer) return answer.error();
    return answer->is_object() ? answer->value("name", "") : std::string();
  }

  static Outcome<std::string> into(const std::string& db_path, const Brought& brought,
                                   const Clock& clock) {
    const std::filesystem::path path(db_path);
    std::error_code ignored;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
    auto db = open_read_write(db_path);
    if (!db) return Failure(db.error(), "give another --db");
    auto stored = lcrig::add_specimen(*db, brought.specimen.name, brought.text, clock.unix_ns());
    if (!stored) return Failure(stored.error());
    return stored->name;
  }

  std::string file_;
  bool as_stated_ = false;
};

Outcome<ExitCode> specimen_check(Context& context, const std::string& file) {
  auto brought = bring(file);
  if (!brought) return brought.error();
  return show(context, to_json(*brought), [&](std::ostream& out) {
    print_brought(out, "checked", *brought);
    context.console.next(next_command(context.global, {"specimen", "add", file}));
  });
}

constexpr OneWord kSpecimenCheck{"specimen check",
                                 "What a specimen file comes to; nothing is stored",
                                 "lcrig specimen check my-stack.json",
                                 specimen_check,
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

const CommandFactory kSpecimenAddCommand = make_command<SpecimenAddCommand>;
const CommandFactory kSpecimenCheckCommand = make_command<OneWordCommand, kSpecimenCheck>;
const CommandFactory kSpecimenListCommand = make_command<OneWordCommand, kSpecimenList>;
const CommandFactory kSpecimenShowCommand = make_command<SpecimenShowCommand>;

}  // namespace lcrig::cli
