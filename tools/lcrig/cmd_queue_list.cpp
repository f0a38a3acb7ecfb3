// SPDX-License-Identifier: Apache-2.0
// queue list, show, history.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/queue_request.hpp"
#include "tools/lcrig/queue_source.hpp"
#include "tools/lcrig/queue_words.hpp"
#include "tools/lcrig/run_database.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

std::string utc_or_dash(const json& unix_ns) {
  return unix_ns.is_number() ? format_utc(unix_ns.get<std::int64_t>()) : "-";
}

std::string text_of(const json& object, const char* key) {
  return printable(object.value(key, std::string()), kLongestName);
}

void print_entries(std::ostream& out, const json& entries) {
  if (entries.empty()) return;
  fmt::print(out, "{:>5} {:11} {:20} {:14} {:20} {:20} {}\n", "entry", "state", "protocol",
             "specimen", "planned begin", "planned end", "run");
  for (const json& e : entries) {
    const json& run = e.at("run");
    fmt::print(out, "{:>5} {:11} {:20} {:14} {:20} {:20} {}\n", e.value("entry", std::int64_t{0}),
               text_of(e, "state"), text_of(e, "protocol"), text_of(e, "specimen"),
               utc_or_dash(e.at("planned_begin_unix_ns")), utc_or_dash(e.at("planned_end_unix_ns")),
               run.is_number() ? std::to_string(run.get<std::int64_t>()) : "");
  }
}

Outcome<ExitCode> queue_list(Context& context, const std::string&) {
  auto source = QueueSource::open(context);
  if (!source) return source.error();
  auto view = source->list();
  if (!view) return view.error();
  const json& queue = view->at("queue");
  const json& entries = view->at("entries");
  return show(context, *view, [&](std::ostream& out) {
    const auto status = parse_queue_status(queue);
    if (status) print_queue(out, *status);
    print_entries(out, entries);
    if (source->is_at_rest()) context.console.note(source->rest_words());
    if (!status || source->is_at_rest()) return;
    std::optional<EntryState> head;
    if (!entries.empty()) {
      head = parse_word<EntryState>(text_of(entries.front(), "state"));
    }
    if (const auto next = next_for_queue(context.global, *status, head); !next.empty()) {
      context.console.next(next);
    }
  });
}

constexpr OneWord kQueueList{"queue list", "What waits, and for what", "lcrig queue list",
                             queue_list};

void print_batch(std::ostream& out, const json& b) {
  const auto number = [&b](const char* key) { return b.value(key, std::int64_t{0}); };
  const json& seed = b.at("seed");
  fmt::print(out, "batch       {}, run {} of {}, repeat {} of line {} of {}; order {}{}\n",
             text_of(b, "name"), number("position"), number("of"), number("repeat"), number("line"),
             text_of(b, "file"), text_of(b, "order"),
             seed.is_number() ? fmt::format(", seed {}", seed.get<std::int64_t>()) : "");
}

// Prints when the entry may begin and what must be on the rig, as far as this was asked for.
void print_conditions(std::ostream& out, const json& terms) {
  if (const double rest_s = terms.value("rest_s", 0.0); rest_s > 0) {
    fmt::print(out, "rest        {} since the run before\n", format_time(rest_s));
  }
  for (const auto& [key, words] :
       {std::pair("not_before_unix_s", "not before"), std::pair("not_after_unix_s", "not after")}) {
    if (!terms.contains(key) || !terms.at(key).is_number()) continue;
    const auto at_ns = terms.at(key).get<std::int64_t>() * kSecond_ns;
    fmt::print(out, "{:11} {}\n", words, format_utc(at_ns));
  }
  if (terms.contains("between") && terms.at("between").is_string()) {
    fmt::print(out, "between     {}\n", text_of(terms, "between"));
  }
  for (const char* key : {"probe", "fixture"}) {
    const auto name = text_of(terms, key);
    if (!name.empty()) fmt::print(out, "{:11} {}\n", key, name);
  }
}

void print_entry(std::ostream& out, const json& e) {
  const json& plan = e.at("plan");
  const json& terms = e.at("terms");
  fmt::print(out, "entry {}  {} on {}  {}\n", e.value("entry", std::int64_t{0}),
             text_of(e, "protocol"), text_of(e, "specimen"), text_of(e, "state"));
  if (e.contains("batch")) print_batch(out, e.at("batch"));
  fmt::print(out, "parameters  {}\n", printable(e.at("parameters").dump(), kLongestWords));
  fmt::print(out, "added       {} by {}, for {}\n",
             format_utc(e.value("added_unix_ns", std::int64_t{0})), text_of(e, "added_by"),
             text_of(e, "operator"));
  if (const json& s = plan.at("duration_s"); s.is_number()) {
    fmt::print(out, "plan        {}, {} readings, at most {} N\n", format_time(s.get<double>()),
               plan.value("measure_readings", std::int64_t{0}),
               format_fixed(plan.value("peak_force_N", 0.0), 3));
  } else {
    fmt::print(out, "plan        not yet: {}\n",
               printable(plan.value("why_not", std::string()), kLongestWords));
  }
  fmt::print(out, "planned     {} to {}\n", utc_or_dash(e.at("planned_begin_unix_ns")),
             utc_or_dash(e.at("planned_end_unix_ns")));
  fmt::print(out, "terms       on failure {}, at most {} failures in a row{}\n",
             text_of(terms, "on_failure"), terms.value("failures_max", std::int64_t{0}),
             terms.value("unattended", false) ? ", unattended" : "");
  print_conditions(out, terms);
  if (const json& run = e.at("run"); run.is_number()) {
    fmt::print(out, "runs        {}, the last one is {}\n", e.value("attempts", std::int64_t{0}),
               run.get<std::int64_t>());
  }
  const std::string note = e.value("note", std::string());
  if (!note.empty()) fmt::print(out, "note        {}\n", printable(note, kLongestWords));
}

Outcome<ExitCode> queue_show(Context& context, const std::string& word) {
  auto entry = entry_number(word, context.global);
  if (!entry) return entry.error();
  auto source = QueueSource::open(context);
  if (!source) return source.error();
  auto found = source->show(*entry);
  if (!found) return found.error();
  return show(context, *found, [&](std::ostream& out) { print_entry(out, *found); });
}

constexpr OneWord kQueueShow{"queue show",         "Everything known about an entry",
                             "lcrig queue show 7", queue_show,
                             kEntryWord,           "Its number in `lcrig queue list`"};

class QueueHistoryCommand final : public Command {
 public:
  QueueHistoryCommand()
      : Command("queue history", "What was done with the queue, and by whom; newest first",
                "lcrig queue history") {}
  void declare(ArgumentList& list) override {
    list.option("--entry", entry_, kEntryWord, "Only of this one");
    list.option("--most", most_, "N", "So many lines (default: 50, at most 500)");
  }
  Outcome<ExitCode> run(Context& context) override {
    std::int64_t most = 50;
    if (!most_.empty()) {
      const auto wanted = number_from<std::int64_t>(most_);
      if (!wanted || *wanted < 1 || *wanted > 500) {
        return Failure(
            kUsage, fmt::format("--most '{}' is not a number from 1 to 500", printable(most_, 60)),
            "lcrig queue history --help");
      }
      most = *wanted;
    }
    std::optional<std::int64_t> of_entry;
    if (!entry_.empty()) {
      auto entry = entry_number(entry_, context.global);
      if (!entry) return entry.error();
      of_entry = *entry;
    }
    auto source = QueueSource::open(context);
    if (!source) return source.error();
    auto answer = source->history(of_entry, most);
    if (!answer) return answer.error();
    return show(context, *answer, [&](std::ostream& out) {
      for (const json& act : answer->at("acts")) {
        const json& entry = act.at("entry");
        const auto number = entry.is_number() ? fmt::format(" {}", entry.get<std::int64_t>()) : "";
        fmt::print(out, "{}  {:10} {:10} {}\n",
                   format_utc(act.value("at_unix_ns", std::int64_t{0})), text_of(act, "user"),
                   act.value("act", std::string()) + number,
                   printable(act.value("detail", std::string()), kLongestWords));
      }
    });
  }

 private:
  std::string entry_, most_;
};

}  // namespace

const CommandFactory kQueueListCommand = make_command<OneWordCommand, kQueueList>;
const CommandFactory kQueueShowCommand = make_command<OneWordCommand, kQueueShow>;
const CommandFactory kQueueHistoryCommand = make_command<QueueHistoryCommand>;

}  // namespace lcrig::cli
