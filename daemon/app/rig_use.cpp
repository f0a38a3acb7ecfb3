// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/rig_use.hpp"

#include "daemon/session.hpp"
#include "protocols/run/run.hpp"

namespace lcrig {

using namespace std::chrono_literals;

RigUse::RigUse(Clock& clock) : clock_(clock), changed_(clock) {}

RigUse::~RigUse() = default;

Task<Result<>> RigUse::claim(State state) {
  const MonoTime patience = clock_.now() + 30s;
  const auto is_known = [this] {
    return is_idle() || state_ == State::correcting || session_ != nullptr || ending_;
  };
  co_await changed_.wait(is_known, patience);
  if (ending_) co_return fail(Errc::busy, "the daemon is shutting down");
  if (const Run* run = live_run()) {
    co_return fail(Errc::busy,
                   "run {} is going on: one run at a time; `lcrig watch` shows it, "
                   "`lcrig abort` ends it",
                   run->progress().run);
  }
  if (state_ == State::stopping) {
    co_return fail(Errc::busy, "{}", alarm_words_after(last_run_->run));
  }
  if (state_ == State::correcting) {
    co_return fail(
        Errc::busy,
        "the open or the short correction of the meter is being made, which takes up to two "
        "minutes: try again then");
  }
  if (!is_idle()) {
    co_return fail(Errc::busy,
                   "a run is being prepared, or the instruments are being asked who they are: try "
                   "again in a minute");
  }
  enter(state);
  co_return Result<>();
}

void RigUse::enter(State state) {
  stop_of_start_.reset();
  state_ = state;
  if (is_idle() && listener_.idle) listener_.idle();
  changed_.notify_all();
  if (listener_.entered) listener_.entered();
}

void RigUse::give_back() {
  session_.reset();
  enter(State::idle);
}

void RigUse::take(std::unique_ptr<Session> session) {
  session_ = std::move(session);
  changed_.notify_all();
}

Run* RigUse::live_run() const {
  return session_ && state_ != State::stopping ? session_->run() : nullptr;
}

Result<Run*> RigUse::running() const {
  if (Run* run = live_run()) return run;
  if (state_ == State::stopping) {
    return fail(Errc::not_standing, "{}", alarm_words_after(last_run_->run));
  }
  return fail(Errc::invalid_request, "no run is going on");
}

void RigUse::end_run(RunOutcome outcome) {
  last_run_ = std::move(outcome);
  give_back();
}

void RigUse::end_run_stopping(RunOutcome outcome) {
  last_run_ = std::move(outcome);
  enter(State::stopping);
}

void RigUse::end_stopping(std::optional<double> stood_after_s) {
  last_run_->stands = stood_after_s.has_value();
  last_run_->stood_after_s = stood_after_s;
  give_back();
}

Result<> RigUse::may_go_on() const {
  if (ending_) return fail(Errc::aborted, "the daemon is stopping");
  if (!stop_of_start_) return {};
  return fail(Errc::aborted, "stopped while it was being prepared ({}): nothing has moved",
              stop_of_start_->why);
}

void RigUse::end() {
  ending_ = true;
  changed_.notify_all();
}

}  // namespace lcrig
