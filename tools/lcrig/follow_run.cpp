// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/follow_run.hpp"

#include <fmt/ostream.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.hpp"
#include "events/event_words.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/queue_words.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

sigset_t stop_set(bool hangup) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  if (hangup) sigaddset(&set, SIGHUP);
  return set;
}

// "contact (search): travel 3.2005 mm, force 0.0234 N"
std::string line_of(const RunEvent& event) {
  std::string out = event.kind.word();
  if (!event.step_id.empty()) out += fmt::format(" ({})", event.step_id);
  const bool stands = event.kind == EventKind::stopped && event.detail.empty();
  const auto words = stands ? "the frame confirmed standstill" : event_words(event.detail);
  return words.empty() ? out : out + ": " + words;
}

class Follower {
 public:
  Follower(Context& context, ControlClient& client, StopSignals& signals, FollowOptions options)
      : context_(context),
        client_(client),
        signals_(signals),
        options_(options),
        line_(context.console, context.clock) {}

  Outcome<FollowEnd> run() {
    auto end = loop();
    line_.finish();
    return end;
  }

 private:
  Outcome<FollowEnd> loop() {
    while (!ended_) {
      if (auto ok = drain(); !ok) return lost(ok.error());
      if (ended_) break;
      std::array<pollfd, 3> wanted{pollfd{client_.fd(), POLLIN, 0},
                                   pollfd{signals_.fd(), POLLIN, 0},
                                   pollfd{typing_ ? STDIN_FILENO : -1, POLLIN, 0}};
      if (::poll(wanted.data(), wanted.size(), stop_ms()) < 0 && errno != EINTR) {
        return Failure(kFailed, std::strerror(errno), "");
      }
      if (wanted[0].revents != 0) hint_at_.reset();
      say_hint();
      if (wanted[1].revents != 0) {
        if (auto ok = on_signal(); !ok) return ok.error();
      }
      if (wanted[2].revents != 0) {
        if (auto ok = on_key(); !ok) return ok.error();
      }
    }
    return FollowEnd{.run = std::move(*ended_), .interrupted = stops_ > 0};
  }

  // Milliseconds until a stop counts as not answered. -1: no stop is waiting.
  int stop_ms() const {
    if (!hint_at_) return -1;
    const auto left = *hint_at_ - context_.clock.now();
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    return static_cast<int>(std::max<std::int64_t>(ms, 0));
  }
  void say_hint() {
    if (!hint_at_ || context_.clock.now() < *hint_at_) return;
    hint_at_.reset();
    line_.say(kStopByHand);
  }

  Failure lost(Failure failure) const {
    if (run_ > 0) failure.what += fmt::format(" (run {} was going on)", run_);
    return failure;
  }

  Outcome<std::int64_t> drain() {
    for (;;) {
      auto news = client_.take();
      if (!news) return news.error();
      if (!*news) return 0;
      std::visit([this](auto& what) { on(what); }, **news);
      if (ended_) return 0;
    }
  }

  bool ours(std::int64_t run) const { return options_.run == 0 || run == options_.run; }

  void on(const RunStatus& status) {
    if (!ours(status.run)) return;
    run_ = status.run;
    prompted_ = !status.prompt.empty();
    question_ = status.question;
    line_.show(status);
  }
  void on(const RunEventNote& note) {
    if (!ours(note.run)) return;
    // These events are not printed: steps are in the live line, requests end in a state, and
    // figures are for those who study the run afterwards.
    constexpr std::array<EventKind, 11> kQuiet{
        EventKind::step_begin, EventKind::step_end, EventKind::state,    EventKind::request,
        EventKind::plan,       EventKind::watch,    EventKind::rest,     EventKind::motion,
        EventKind::stiffness,  EventKind::settings, EventKind::overshoot};
    if (std::ranges::find(kQuiet, note.event.kind.kind()) != kQuiet.end()) return;
    if (note.event.kind == EventKind::read_back) {
      const auto back = from_json<ReadBackEvent>(note.event.detail);
      if (back && back->equal) return;
    }
    line_.say_one_line(printable(line_of(note.event), kLongestWords));
  }
  // Before a run starts: what it waits for.
  void on(const QueueStatus& queue) {
    if (run_ > 0 || options_.run > 0 || !is_in_use(queue)) return;
    const auto words = idle_words(queue, false);
    if (words != idle_words_) line_.say(words);
    idle_words_ = words;
  }
  void on(RunOutcome& ended) {
    if (ours(ended.run)) ended_ = std::move(ended);
  }
  void on(const ControlAnswer& answer) {
    if (!answer.failure) return;
    prompted_ = prompted_ || question_;  // an answer that was refused can be typed again
    line_.say("lcrig: " + printable(answer.failure->what, kLongestWords));
  }

  Outcome<std::int64_t> on_signal() {
    const int signal = signals_.take();
    ++stops_;
    if (!options_.owner || stops_ > 1) {
      return Failure(kInterrupted, "interrupted",
                     next_command(context_.global, {"status"}, left_behind()));
    }
    const bool key = signal == SIGINT;
    line_.say(fmt::format("stopping the run, then its `finally` part; {} leaves it alone",
                          key ? "Ctrl-C again" : "a second SIGTERM"));
    const json params{{"why", key ? "Ctrl-C in lcrig run" : "SIGTERM to lcrig run"}};
    hint_at_ = context_.clock.now() + context_.env.stop_hint_after;
    return client_.post("run.abort", params);
  }

  // What to tell a person who leaves while the run goes on.
  const char* left_behind() const {
    if (options_.owner) return "the run is still being stopped";
    return run_ > 0 || options_.run > 0 ? "the run goes on" : "no run was going on";
  }

  Outcome<std::int64_t> on_key() {
    std::array<char, 256> buffer{};
    const auto n = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (n <= 0) {  // the terminal is gone
      typing_ = false;
      return 0;
    }
    typed_.append(buffer.data(), static_cast<std::size_t>(n));
    const auto end = typed_.find('\n');
    if (end == typed_.npos && typed_.size() <= kAnswerMax) return 0;
    const std::string line = typed_.substr(0, end);
    typed_.clear();
    if (!std::exchange(prompted_, false)) return 0;  // one Enter gives one confirmation
    if (!question_) return client_.post("run.confirm", json::object());
    const AnswerRequest answer{.value = line, .question = question_->number};
    return client_.post("run.answer", to_json(answer));
  }

  Context& context_;
  ControlClient& client_;
  StopSignals& signals_;
  FollowOptions options_;
  LiveLine line_;
  std::optional<RunOutcome> ended_;
  std::int64_t run_ = 0;
  std::string idle_words_;  // the last that was said of the queue
  int stops_ = 0;
  std::optional<MonoTime> hint_at_;
  bool prompted_ = false;
  std::optional<OpenQuestion> question_;  // question of the prompt; none: the prompt is confirmed
  std::string typed_;  // since the last Enter
  bool typing_ = options_.owner && context_.console.in_tty;
};

// Options with which a command finds this run. $LCRIG_DB may name another file, in which another
// run has the same number.
GlobalOptions where_recorded(const Context& context, ControlClient& client) {
  const auto named = context.named_db();
  if (!named || !*named) return context.global;
  const auto theirs = client.database();
  if (!theirs || is_same_file(**named, *theirs)) return context.global;
  return at_database(*theirs);
}

}  // namespace

StopSignals::StopSignals(bool hangup) : hangup_(hangup) {
  const auto set = stop_set(hangup_);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  fd_ = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

StopSignals::~StopSignals() {
  if (fd_ >= 0) ::close(fd_);
  const auto set = stop_set(hangup_);
  ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

int StopSignals::take() {
  signalfd_siginfo info{};
  const auto n = ::read(fd_, &info, sizeof info);
  return n == static_cast<ssize_t>(sizeof info) ? static_cast<int>(info.ssi_signo) : 0;
}

Outcome<FollowEnd> follow_run(Context& context, ControlClient& client, StopSignals& signals,
                              FollowOptions options) {
  Follower follower(context, client, signals, options);
  return follower.run();
}

ExitCode print_run_end(Context& context, ControlClient& client, const RunOutcome& e) {
  auto& out = context.console.out;
  if (context.global.json) {
    print_json(out, to_json(e));
  } else {
    fmt::print(out, "run {}: {}{}{}\n", e.run, to_string(e.exit_status),
               e.reason.empty() ? "" : " (" + printable(e.reason, kLongestWords) + ")",
               e.simulated ? " (simulated)" : "");
    fmt::print(out, "{} LCR readings ({} of measure steps){}, {} frame samples in {}\n",
               e.lcr_readings, e.measure_readings, unproven_words(e.unproven_readings),
               e.frame_samples, format_time(e.duration_s));
    // Printed whole, because a person keeps it.
    if (!e.anchor.empty()) fmt::print(out, "anchor {}\n", printable(e.anchor));
    context.console.next(
        next_command(where_recorded(context, client), {"export", std::to_string(e.run)}));
  }
  return exit_code_of_run(e.exit_status, e.code);
}

}  // namespace lcrig::cli
