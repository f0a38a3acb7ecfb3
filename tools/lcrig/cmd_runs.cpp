// SPDX-License-Identifier: Apache-2.0
// runs list, show, note, tag.
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <tuple>

#include "base/near_word.hpp"
#include "base/text.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/tags.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/run_database.hpp"
#include "tools/lcrig/when.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

// A text from a database may contain invalid UTF-8, which is replaced.
std::string dump(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json listing_json(const RunListing& r) {
  return json::parse(run_listing_line(r));
}

std::string remarks(const RunListing& r) {
  std::string out;
  if (r.simulated) out = fmt::format("  {}", stand_in_word(r.bench_name));
  if (r.unproven_readings > 0) out += fmt::format("  {} not proven", r.unproven_readings);
  for (const auto& tag : r.tags) out += "  #" + printable(tag);
  return out;
}

void print_table(std::ostream& out, const std::vector<RunListing>& runs) {
  fmt::print(out, "{:>5} {:20} {:16} {:14} {:11} {:>8} {:>8}\n", "run", "made", "protocol",
             "specimen", "status", "readings", "samples");
  for (const auto& r : runs) {
    fmt::print(out, "{:>5} {:20} {:16} {:14} {:11} {:>8} {:>8}{}\n", r.run,
               format_utc(true_time_ns(r)), printable(r.protocol_name, kLongestName),
               printable(r.specimen_name, kLongestName), status_of(r), r.lcr_readings,
               r.frame_samples, remarks(r));
  }
}

void print_list(std::ostream& out, const std::vector<RunListing>& runs) {
  out << R"({"runs":[)";
  for (const auto& r : runs) {
    if (&r != runs.data()) out << ',';
    out << run_listing_line(r);
  }
  out << "]}\n";
}

class RunsListCommand final : public Command {
 public:
  RunsListCommand()
      : Command("runs list", "The runs of the database, newest first",
                "lcrig runs list --specimen paper-1 --status success --since 2026-01-31") {}
  void declare(ArgumentList& list) override {
    list.option("--specimen", specimen_, {"NAME", Proposes::run_specimen}, "Only of this specimen");
    list.option("--protocol", protocol_, {"NAME", Proposes::run_protocol}, "Only of this protocol");
    list.option("--operator", operator_, kOperatorWord, "Only of this person");
    auto statuses = all_words<ExitStatus>();
    statuses.insert(statuses.end(), {std::string(kRunGoesOn), kCutOffAsTyped});
    list.one_of("--status", status_, statuses, "Only those that ended so");
    list.option("--tag", tag_, kTagWord, "Only those that have it");
    list.option("--since", since_, "TIME", "Made then or later: 2026-01-31, \"2026-01-31 18:00\"");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto filter = wanted(context);
    if (!filter) return filter.error();
    auto db = open_runs(context);
    if (!db) return db.error();
    auto runs = list_runs(*db, *filter);
    if (!runs) return Failure(runs.error());
    if (runs->empty()) say_why_none(context, *db);
    if (context.global.json) {
      print_list(context.console.out, *runs);
    } else {
      print_table(context.console.out, *runs);
    }
    return kOk;
  }

 private:
  Outcome<RunFilter> wanted(const Context& context) const {
    RunFilter out;
    out.specimen = specimen_;
    out.protocol = protocol_;
    out.operator_name = operator_;
    out.tag = tag_;
    out.status = status_ == kCutOffAsTyped ? kRunCutOff : status_;
    if (since_.empty()) return out;
    const auto since_s = unix_time_of(since_, context.clock.unix_ns() / kSecond_ns);
    if (!since_s || since_.size() < kDay) {
      const auto day = iso_day_of(since_);
      return Failure(
          kUsage, fmt::format("--since {}: no such day", printable(since_)),
          next_command(context.global, {"runs", "list", "--since", day.value_or("2026-01-31")},
                       "or \"2026-01-31 18:00\""));
    }
    out.since_unix_ns = *since_s * kSecond_ns;
    return out;
  }

  // If no run has the given name, it was perhaps mistyped.
  void say_why_none(const Context& context, const Database& db) const {
    for (const auto& [option, wanted, column] :
         {std::tuple("--specimen", &specimen_, "specimen_name"),
          std::tuple("--protocol", &protocol_, "protocol_name"),
          std::tuple("--operator", &operator_, "operator")}) {
      if (wanted->empty()) continue;
      const auto known = db.rows(fmt::format("SELECT DISTINCT {} FROM run", column),
                                 [](const Statement& s) { return std::string(s.text(0)); });
      if (!known || std::ranges::find(*known, *wanted) != known->end()) continue;
      context.console.note(fmt::format("{} {}: no run has it{}", option,
                                       printable(*wanted, kLongestName),
                                       did_you_mean(*wanted, *known, kGuessAtPrompt)));
    }
  }

  static constexpr const char* kCutOffAsTyped = "cut-off";  // kRunCutOff without the blank
  static constexpr std::size_t kDay = 10;  // length of a date; a time alone means the next one
  std::string specimen_, protocol_, operator_, status_, tag_, since_;
};

json parsed(const std::string& text) {
  auto value = json::parse(text, nullptr, false);
  return value.is_discarded() ? json(text) : value;
}

json show_json(const RunListing& listing, const RunRow& row, const std::vector<RunNote>& notes) {
  json out = listing_json(listing);
  out["recorded_run"] = row.copied_from ? row.copied_from->run : listing.run;
  out["copied_from"] = row.copied_from ? json(row.copied_from->file) : json(nullptr);
  out["parameters"] = parsed(row.parameters_json);
  out["lcr_identity"] = row.lcr_identity;
  out["frame_identity"] = row.frame_identity;
  out["lcr_settings"] = parsed(row.lcr_settings_json);
  out["correction"] = parsed(row.correction_json);
  out["bench"] = row.bench_name;
  out["seed"] = row.seed ? json(*row.seed) : json(nullptr);
  out["model_level"] = row.model_level ? json(*row.model_level) : json(nullptr);
  out["software_version"] = row.software_version;
  out["note"] = row.note;
  out["notes"] = json::array();
  for (const auto& n : notes) {
    out["notes"].push_back(json{
        {"operator", n.operator_name}, {"added", format_utc(n.added_unix_ns)}, {"text", n.text}});
  }
  return out;
}

Outcome<ExitCode> runs_show(Context& context, const std::string& which) {
  auto run = open_run(context, which);
  if (!run) return run.error();
  const auto& [db, number] = *run;
  auto listing = get_run_listing(db, number);
  if (!listing) return Failure(listing.error());
  auto row = get_run(db, number);
  if (!row) return Failure(row.error());
  auto notes = get_run_notes(db, number);
  if (!notes) return Failure(notes.error());
  const auto all = show_json(*listing, *row, *notes);
  return show(context, all, [&](std::ostream& out) {
    for (const auto& [key, value] : all.items()) {
      const auto text = value.is_string() ? value.get<std::string>() : dump(value);
      fmt::print(out, "{:18} {}\n", key, printable(text, kLongestWords));
    }
  });
}

constexpr OneWord kRunsShow{
    "runs show", "Everything known about a run", "lcrig runs show last", runs_show, kRunWord,
    kWhichRun};

// A change to a run: its number, and what the daemon answered or `change` returned.
struct ChangedRun {
  std::int64_t run = 0;
  json answer;
};

// Makes a change in the database file. If the daemon alone may write into it, the daemon is asked.
// `typed`: the command, without the options that say where.
Outcome<ChangedRun> change_run(
    const Context& context, const Words& typed, const std::string& run, const char* method,
    json params, const std::function<Result<json>(Database& db, std::int64_t run)>& change) {
  const auto not_changed = [&](Failure why) {
    if (why.busy) why.next = next_command(context.global, typed, "when the other program is done");
    return why;
  };
  auto chosen = context.database_to_write(typed);
  if (!chosen) return chosen.error();
  const auto number = number_of_run(context, run);
  if (!number) return number.error();
  if (chosen->daemon_writes) {
    params["run"] = *number;
    auto answer = call_daemon(context, method, params);
    if (!answer) return not_changed(answer.error());
    return ChangedRun{*number, std::move(*answer)};
  }
  auto db = open_read_write(chosen->path);
  if (!db) return not_changed(Failure(db.error(), "give another --db"));
  auto changed = change(*db, *number);
  if (changed) return ChangedRun{*number, std::move(*changed)};
  const auto look = next_command(context.global, {"runs", "show", std::to_string(*number)});
  return not_changed(Failure(changed.error(), look));
}

class NoteCommand final : public Command {
 public:
  NoteCommand()
      : Command("runs note", "Add a note to a run that ended",
                "lcrig runs note last \"probe was dusty\"") {}
  void declare(ArgumentList& list) override {
    list.positional(kRunWord, run_, kWhichRun);
    list.positional("TEXT", text_, "The note");
  }
  Outcome<ExitCode> run(Context& context) override {
    const auto add = [&](Database& db, std::int64_t run) -> Result<json> {
      auto noted = add_run_note(db, run, login_name(), text_, context.clock.unix_ns());
      if (!noted) return fail(noted.error());
      return json();
    };
    auto noted = change_run(context, {"runs", "note", run_, text_}, run_, "run.note",
                            json{{"text", text_}}, add);
    if (!noted) return noted.error();
    return show(context, json{{"run", noted->run}},
                [&](std::ostream& out) { fmt::print(out, "noted with run {}\n", noted->run); });
  }

 private:
  std::string run_, text_;
};

class TagCommand final : public Command {
 public:
  TagCommand()
      : Command("runs tag", "Put tags on a run, by which `runs list --tag` finds it",
                "lcrig runs tag last thesis ageing") {}
  void declare(ArgumentList& list) override {
    list.positional(kRunWord, run_, kWhichRun);
    list.words(kTagWord, change_.tags, "A word without blanks and commas", true);
    list.flag("--remove", change_.remove, "Take them off");
  }
  Outcome<ExitCode> run(Context& context) override {
    Words typed{"runs", "tag", run_};
    typed.insert(typed.end(), change_.tags.begin(), change_.tags.end());
    add_flag(typed, "--remove", change_.remove);
    const auto put = [&](Database& db, std::int64_t run) -> Result<json> {
      change_.run = run;
      auto tags = change_tags(db, change_, login_name(), context.clock.unix_ns());
      if (!tags) return fail(tags.error());
      return json{{"tags", *tags}};
    };
    auto changed = change_run(context, typed, run_, "run.tag",
                              json{{"tags", change_.tags}, {"remove", change_.remove}}, put);
    if (!changed) return changed.error();
    const auto tags = changed->answer.value("tags", std::vector<std::string>());
    return show(context, json{{"run", changed->run}, {"tags", tags}}, [&](std::ostream& out) {
      fmt::print(out, "run {}: {}\n", changed->run,
                 tags.empty() ? "no tags" : fmt::format("{}", fmt::join(tags, " ")));
    });
  }

 private:
  std::string run_;
  TagChange change_;
};

}  // namespace

const CommandFactory kRunsListCommand = make_command<RunsListCommand>;
const CommandFactory kRunsShowCommand = make_command<OneWordCommand, kRunsShow>;
const CommandFactory kRunsNoteCommand = make_command<NoteCommand>;
const CommandFactory kRunsTagCommand = make_command<TagCommand>;

}  // namespace lcrig::cli
