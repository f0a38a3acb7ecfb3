// SPDX-License-Identifier: Apache-2.0
// status, metrics.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/queue_words.hpp"
#include "tools/lcrig/status_check.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

std::string age_words(double s) {
  if (s < 60) return fmt::format("{:.0f} s", s);
  return s < 3600 ? fmt::format("{:.0f} min", s / 60) : fmt::format("{:.1f} h", s / 3600);
}

// "asked 12 s ago", "seen 3 min ago in run 12"; empty: never.
std::string source_words(const InstrumentState& i) {
  if (!i.age_s) return "";
  const auto ago = age_words(*i.age_s) + " ago";
  switch (i.learned_by) {
    case LearnedBy::nothing:
    case LearnedBy::port:
    case LearnedBy::look: return "asked " + ago;
    case LearnedBy::plan: return "asked " + ago + " for a plan";
    case LearnedBy::start: return "asked " + ago + " for a run that did not begin";
    case LearnedBy::run:
      return i.run ? fmt::format("seen {} in run {}", ago, *i.run) : "seen " + ago + " in a run";
    case LearnedBy::rescue: return "stopped " + ago + " after a crash";
  }
  return "";
}

std::string condition_words(const InstrumentState& i) {
  switch (i.condition) {
    case InstrumentCondition::unasked: return "not asked";
    case InstrumentCondition::ready: return "ready";
    case InstrumentCondition::in_use:
      return i.run ? fmt::format("in use by run {}", *i.run) : "in use";
    case InstrumentCondition::absent: return "absent";
    case InstrumentCondition::fault: return "fault";
  }
  return "";
}

// "absent for 28 s: its port is not there; asked 2 s ago"
std::string instrument_words(const InstrumentState& i) {
  const bool troubled =
      i.condition == InstrumentCondition::absent || i.condition == InstrumentCondition::fault;
  std::string out = condition_words(i);
  if (i.simulated) out += " (simulated)";
  if (troubled && i.since_s) out += " for " + age_words(*i.since_s);
  if (!i.why.empty()) out += ": " + printable(i.why, kLongestWords);
  const auto source = source_words(i);
  if (!source.empty()) out += (i.why.empty() ? ", " : "; ") + source;
  return out;
}

void print_last(std::ostream& out, const RunOutcome& last) {
  fmt::print(out, "last: run {} {}{}{}\n", last.run, to_string(last.exit_status),
             last.reason.empty() ? "" : " (" + printable(last.reason, kLongestWords) + ")",
             last.simulated ? " (simulated)" : "");
  if (!last.stands) fmt::print(out, "{}\n", alarm_words_after(last.run));
  if (last.stood_after_s) fmt::print(out, "{}\n", stood_words(*last.stood_after_s));
}

void print_status(Context& context, std::ostream& out, const DaemonStatus& s) {
  GlobalOptions daemon = context.global;
  daemon.db.clear();
  fmt::print(out, "lcrigd {}  database {}\n", printable(s.version, kLongestName),
             printable(s.database, kLongestWords));
  for (const auto& i : s.instruments) {
    const auto identity = printable(i.identity, kLongestWords);
    fmt::print(out, "{:6} {}  {}{}{}\n", to_string(i.which), instrument_words(i),
               printable(i.port, kLongestWords), identity.empty() ? "" : "  ", identity);
  }
  // A queue that is not in use is not shown.
  if (s.queue && is_in_use(*s.queue)) print_queue(out, *s.queue);
  if (s.run) {
    fmt::print(out, "run {}  {} on {}  {}{}\n", s.run->run,
               printable(s.run->protocol, kLongestName), printable(s.run->specimen, kLongestName),
               to_string(s.run->state), s.run->simulated ? " (simulated)" : "");
    fmt::print(out, "{}\n", format_plain_line(*s.run));
    if (!s.run->prompt.empty()) {
      fmt::print(out, "waits for: {}\n", printable(s.run->prompt, kLongestWords));
    }
    return;
  }
  fmt::print(out, "{}\n", idle_words(s.queue, s.correcting));
  for (const auto& r : s.resumable) {
    fmt::print(out, "interrupted: {}; {} continues it\n", words_of(r),
               next_command(daemon, {"resume", std::to_string(r.run)}));
  }
  if (s.last_run) print_last(out, *s.last_run);
  if (!s.queue || !is_in_use(*s.queue)) return;
  if (const auto next = next_for_queue(daemon, *s.queue); !next.empty()) context.console.next(next);
}

class StatusCommand final : public Command {
 public:
  StatusCommand() : Command("status", "What the rig is doing", "lcrig status --ask") {}
  void declare(ArgumentList& list) override {
    list.flag("--ask", ask_, "Ask both instruments who they are; nothing at the frame changes");
    list.flag("--check", check_, "One line for a monitoring program; exit status 0, 1, 2 or 3");
  }
  Outcome<ExitCode> run(Context& context) override {
    if (check_) return check(context);
    const Duration soon = context.env.status_patience;
    auto client = ControlClient::connect_for_any_database(context, soon);
    if (!client) return client.error();
    auto answer = ask_ ? client->call("instruments.ask", json::object(), std::chrono::minutes(1))
                       : client->call("status", json::object(), soon);
    if (!answer) return answer.error();
    client->tell_other_database(context);
    auto status = parse_daemon_status(*answer);
    if (!status && !context.global.json) return Failure(status.error());
    return show(context, *answer, [&](std::ostream& out) { print_status(context, out, *status); });
  }

 private:
  // Every outcome becomes one of the four words of a monitoring program.
  ExitCode check(Context& context) const {
    auto found = look(context);
    const json all{{"check", to_string(found.verdict)}, {"words", found.words}};
    show(context, all, [&](std::ostream& out) {
      fmt::print(out, "LCRIG {}: {}\n", to_string(found.verdict),
                 printable(found.words, kLongestWords));
    });
    return static_cast<ExitCode>(found.verdict);
  }

  StatusCheck look(Context& context) const {
    // Less than the 10 s that monitoring programs wait by default; asking instruments takes longer.
    const auto patience = std::chrono::seconds(ask_ ? 60 : 8);
    StatusCheck out;
    auto client = ControlClient::connect_for_any_database(context);
    if (!client) {
      out.verdict = Verdict::critical;
      out.words = client.error().what;
      return out;
    }
    auto answer = client->call(ask_ ? "instruments.ask" : "status", json::object(), patience);
    if (!answer && ask_) answer = client->call("status", json::object(), patience);  // during a run
    if (!answer) {
      const bool silent = answer.error().no_daemon && !answer.error().not_lcrigd;
      out.verdict = silent ? Verdict::critical : Verdict::unknown;
      out.words = answer.error().what;
      return out;
    }
    auto status = parse_daemon_status(*answer);
    if (status) return check_status(*status);
    out.verdict = Verdict::unknown;
    out.words = status.error().what;
    return out;
  }

  bool ask_ = false, check_ = false;
};

Outcome<ExitCode> metrics(Context& context, const std::string&) {
  auto client = ControlClient::connect_for_any_database(context);
  if (!client) return client.error();
  auto answer = client->call("metrics", json::object());
  if (!answer) return answer.error();
  return show(context, *answer,
              [&](std::ostream& out) { out << answer->value("text", std::string()); });
}

constexpr OneWord kMetrics{"metrics", "The daemon's health, for Prometheus", "lcrig metrics",
                           metrics};

}  // namespace

const CommandFactory kStatusCommand = make_command<StatusCommand>;
const CommandFactory kMetricsCommand = make_command<OneWordCommand, kMetrics>;

}  // namespace lcrig::cli
