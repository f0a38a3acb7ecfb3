// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/pace.hpp"

#include <algorithm>
#include <utility>

namespace lcrig {

namespace {

// People are shown whole seconds, rounded.
constexpr double kUnseen_s = 0.5;

// Whether the step makes no progress, for nobody knows how long.
bool is_waiting(RunState state) {
  switch (state) {
    case RunState::preparing:
    case RunState::running:
    case RunState::finishing:
    case RunState::ended: return false;
    case RunState::stopping:
    case RunState::holding_force:
    case RunState::paused:
    case RunState::waiting_for_operator:
    case RunState::waiting_for_instrument: break;
  }
  return true;
}

}  // namespace

double Pace::planned_of(const std::string& id) const {
  const auto it = planned_.step_s.find(id);
  return it == planned_.step_s.end() ? 0 : it->second;
}

void Pace::begin_step(const std::string& id) {
  passed_s_ += std::exchange(step_s_, planned_of(id));
  step_began_ = clock_.now();
}

void Pace::begin_finally() {
  passed_s_ = planned_.total_s - planned_.finally_s;
  step_s_ = 0;
}

void Pace::pass_over(const std::string& id) {
  passed_s_ += planned_of(id);
}

double Pace::left_of_step_s() const {
  return std::max(0.0, step_s_ - to_seconds(clock_.now() - step_began_));
}

void Pace::write_to(RunProgress& progress) const {
  if (start_ == MonoTime()) return;
  const MonoTime now = clock_.now();
  progress.elapsed_s = to_seconds(now - start_);
  const bool ended = progress.state == RunState::ended;
  const double in_step_s = to_seconds(now - step_began_);
  const double planned_left_s = planned_.total_s - passed_s_ - std::min(step_s_, in_step_s);
  progress.left_s = ended ? 0 : std::max(0.0, planned_left_s);
  const bool late = in_step_s > step_s_ + kUnseen_s;
  const bool waits = late || is_waiting(progress.state);
  progress.overdue = !ended && planned_.total_s > 0 && waits;
}

}  // namespace lcrig
