// SPDX-License-Identifier: Apache-2.0
// Who uses the instruments at present, and the session that has them. One use at a time: who wants
// them claims them. The parts of App that wait for a change of this wait here.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "base/condition.hpp"
#include "daemon/run_request.hpp"
#include "daemon/session.hpp"

namespace lcrig {

class RigUse {
 public:
  // Only an idle daemon begins something new.
  enum class State {
    idle,
    asking,  // who they are, or what a plan needs to know
    correcting,  // the meter
    starting,  // a run is prepared: until its row exists, nothing moves
    running,  // until its row and the ports are closed
  };
  // Calls to the owner; each may be empty.
  struct Listener {
    std::function<void()> idle;  // before those that wait for it learn of it
    std::function<void()> entered;  // a state; after they learned of it
  };

  explicit RigUse(Clock& clock) : clock_(clock), changed_(clock) {}
  void set_listener(Listener listener) { listener_ = std::move(listener); }

  // Waits until it is known whether the instruments are free. Who claimed them gives them back, or
  // enters `running`. Errors: busy.
  Task<Result<>> claim(State state);
  void enter(State state);
  void give_back();

  State state() const { return state_; }
  bool is_idle() const { return state_ == State::idle; }
  bool is_for_run() const { return state_ == State::starting || state_ == State::running; }

  // The session of the one that claimed them.
  void take(std::unique_ptr<Session> session);
  Session* session() const { return session_.get(); }  // nullptr: none was made yet
  Run* live_run() const { return session_ ? session_->run() : nullptr; }
  Result<Run*> running() const;  // Errors: invalid_request, no run is going on.
  // The session is over and gone: gives the instruments back.
  void end_run(RunOutcome outcome);
  const std::optional<RunOutcome>& last_run() const { return last_run_; }

  // The run that is being prepared does not begin.
  void stop_start(InterruptRequest why) { stop_of_start_ = std::move(why); }
  const std::optional<InterruptRequest>& stop_of_start() const { return stop_of_start_; }
  // Errors: aborted; a preparation does not go on, because somebody stopped it or the daemon ends.
  Result<> may_go_on() const;

  // The daemon ends: nothing new begins.
  void end();
  bool is_ending() const { return ending_; }

  // Waits until `holds()`; false when the deadline came first.
  template <class Holds>
  Task<bool> wait(Holds holds, MonoTime deadline = MonoTime::max()) {
    return changed_.wait(std::move(holds), deadline);
  }
  // Something else changed that a part may wait for here.
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
