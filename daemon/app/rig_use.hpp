// SPDX-License-Identifier: Apache-2.0
// Tells who uses the instruments, and keeps the session that uses them. Only one user at a time:
// each has to claim them. Parts of App wait here for a change of use.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "base/condition.hpp"
#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "daemon/run_request.hpp"
#include "protocols/run/interrupts.hpp"

namespace lcrig {

class Run;
class Session;

class RigUse {
 public:
  // A new use begins only from `idle`.
  enum class State {
    idle,
    asking,  // the daemon asks their identity, or what a plan needs
    correcting,  // the meter is being corrected
    starting,  // a run is being prepared; nothing moves until its row exists
    running,  // until the row of the run and the ports are closed
    stopping,  // a run has ended, and the frame has not confirmed that it stands: STOP is repeated
  };
  // Calls to the owner; each may be empty.
  struct Listener {
    std::function<void()> idle;  // the rig became idle; called before the waiting parts continue
    std::function<void()> entered;  // the state changed; called after the waiting parts were
                                    // notified
  };

  explicit RigUse(Clock& clock);
  ~RigUse();
  void set_listener(Listener listener) { listener_ = std::move(listener); }

  // Claims the instruments once it is known whether they are free. The caller must give them back,
  // or enter `running`. Errors: busy.
  Task<Result<>> claim(State state);
  void enter(State state);
  void give_back();

  State state() const { return state_; }
  bool is_idle() const { return state_ == State::idle; }
  // Nothing else may begin, and no person is asked to touch the rig.
  bool is_for_run() const {
    return state_ == State::starting || state_ == State::running || state_ == State::stopping;
  }

  // Takes the session of the part that claimed the instruments.
  void take(std::unique_ptr<Session> session);
  Session* session() const { return session_.get(); }  // nullptr: there is none yet
  Run* live_run() const;
  // Errors: invalid_request when there is no run; not_standing when the last one left the frame
  // moving.
  Result<Run*> running() const;
  // Destroys the finished session and gives the instruments back.
  void end_run(RunOutcome outcome);
  // The same for a run whose frame may move: the session stays until `end_stopping`.
  void end_run_stopping(RunOutcome outcome);
  // `stood_after_s`: when the frame confirmed standstill, after the end of the run; nullopt: it did
  // not.
  void end_stopping(std::optional<double> stood_after_s);
  const std::optional<RunOutcome>& last_run() const { return last_run_; }

  // Prevents the run that is being prepared.
  void stop_start(InterruptRequest why) { stop_of_start_ = std::move(why); }
  const std::optional<InterruptRequest>& stop_of_start() const { return stop_of_start_; }
  // Errors: aborted when a preparation must not continue, because somebody stopped it or the daemon
  // ends.
  Result<> may_go_on() const;

  // Call when the daemon ends: nothing new begins.
  void end();
  bool is_ending() const { return ending_; }

  // Waits until `holds()`; false when the deadline came first.
  template <class Holds>
  Task<bool> wait(Holds holds, MonoTime deadline = MonoTime::max()) {
    return changed_.wait(std::move(holds), deadline);
  }
  // Call after any other change that a part may wait for here.
  void tell() { changed_.notify_all(); }

 private:
  Clock& clock_;
  Condition changed_;
  Listener listener_;
  State state_ = State::idle;
  std::unique_ptr<Session> session_;
  std::optional<InterruptRequest> stop_of_start_;
  std::optional<RunOutcome> last_run_;
  bool ending_ = false;
};

}  // namespace lcrig
