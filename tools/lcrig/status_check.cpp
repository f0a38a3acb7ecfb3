// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/status_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"

namespace lcrig::cli {

namespace {

constexpr std::size_t kLongest = 400;  // a reason that ends with the load left on a specimen
// During a run the meter answers several times a second; with the slowest setting, once in 3 s.
constexpr double kOldData_s = 10;

class Checker {
 public:
  explicit Checker(const DaemonStatus& status) : status_(status) {}

  StatusCheck check() {
    if (!status_.socket_trouble.empty()) {
      find(Verdict::critical,
           "no new client finds the daemon: " + printable(status_.socket_trouble, kLongest));
    }
    for (const auto& i : status_.instruments) look_at(i);
    look_at_run();
    look_at_queue();
    if (!out_.words.empty()) return out_;
    out_.words =
        status_.run ? fmt::format("run {} in progress", status_.run->run) : "no run in progress";
    return out_;
  }

 private:
  void find(Verdict verdict, const std::string& words) {
    out_.verdict = std::max(out_.verdict, verdict);
    add_remark(out_.words, words);
  }

  // What is said of the last run may be what its instrument says: it is stated once.
  bool states_already(const InstrumentState& i) const {
    if (status_.run || !status_.last_run || !is_trouble(*status_.last_run)) return false;
    const bool may_move = i.which == Instrument::frame && !status_.last_run->stands;
    return may_move || status_.last_run->reason == i.why;
  }
  static bool is_trouble(const RunOutcome& last) {
    return !last.stands || last.exit_status == ExitStatus::fail;
  }

  void look_at(const InstrumentState& i) {
    if (states_already(i)) return;
    const auto* const name = i.which == Instrument::lcr ? "meter" : "frame";
    const bool in_run = status_.run.has_value();
    if (i.condition == InstrumentCondition::absent || i.condition == InstrumentCondition::fault) {
      find(in_run ? Verdict::critical : Verdict::warning,
           fmt::format("{}: {}", name, printable(i.why, kLongest)));
    } else if (i.condition == InstrumentCondition::in_use && i.age_s && *i.age_s > kOldData_s) {
      find(Verdict::critical, fmt::format("{}: nothing heard for {:.0f} s", name, *i.age_s));
    }
  }

  void look_at_run() {
    if (status_.run) {
      const auto& run = *status_.run;
      if (const auto alarm = alarm_words(run.standstill); !alarm.empty()) {
        find(Verdict::critical, fmt::format("frame: {} (run {})", alarm, run.run));
      }
      if (!run.prompt.empty()) {
        find(Verdict::warning, fmt::format("run {} waits for a person: {}", run.run,
                                           printable(run.prompt, kLongest)));
      } else if (run.state == RunState::paused) {
        find(Verdict::warning, fmt::format("run {} is paused", run.run));
      }
    } else if (status_.last_run) {
      look_at_last(*status_.last_run);
    }
  }

  void look_at_last(const RunOutcome& last) {
    if (!is_trouble(last)) return;
    if (!last.stands) find(Verdict::critical, alarm_words_after(last.run));
    find(Verdict::warning, fmt::format("run {} {}: {}", last.run, to_string(last.exit_status),
                                       printable(last.reason, kLongest)));
    if (last.stood_after_s) find(Verdict::warning, stood_words(*last.stood_after_s));
  }

  // A queue that a person held, or that is finished, is no reason to warn.
  void look_at_queue() {
    if (!status_.queue || status_.queue->count == 0) return;
    const auto& q = *status_.queue;
    if (q.going && !q.prompt.empty() && q.gate != QueueGate::time) {
      find(Verdict::warning, "the queue waits: " + printable(q.prompt, kLongest));
    } else if (!q.going && q.cause != HoldCause::person && q.cause != HoldCause::not_started) {
      find(Verdict::warning, "the queue is held: " + printable(q.why, kLongest));
    }
  }

  const DaemonStatus& status_;
  StatusCheck out_;
};

}  // namespace

const char* to_string(Verdict verdict) {
  constexpr const char* kWords[] = {"OK", "WARNING", "CRITICAL", "UNKNOWN"};
  return kWords[static_cast<std::size_t>(verdict)];
}

StatusCheck check_status(const DaemonStatus& status) {
  return Checker(status).check();
}

}  // namespace lcrig::cli
