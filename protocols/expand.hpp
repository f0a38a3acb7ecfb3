// SPDX-License-Identifier: Apache-2.0
// The one interpreter of loops: yields the leaf steps of a protocol one at a time, in the order of
// execution. Plan and run both use it, so the run executes what was planned.
#pragma once

#include <cstdint>
#include <vector>

#include "protocols/protocol.hpp"

namespace lcrig {

// More leaf steps than anybody would wait for. A plan refuses more.
inline constexpr std::int64_t kStepsMax = 2'000'000;

// Both references must outlive the cursor. While a sweep runs, its variable is set in the
// environment; afterwards it is removed.
class StepCursor {
 public:
  struct Pass {
    Pass(const Step& s, const Loop& l, std::int64_t n) : step(&s), loop(&l), count(n) {}
    const Step* step;  // a repeat or a sweep
    const Loop* loop;
    std::int64_t index = 1;  // counts from 1
    std::int64_t count;
    std::size_t at = 0;  // next step inside
  };

  StepCursor(const Steps& steps, Environment& environment);
  // Continues from the position of `at`, with the values of another environment.
  StepCursor(const StepCursor& at, Environment& environment);

  // The next leaf step (never a repeat or sweep); nullptr at the end, also when called again.
  const Step* next();
  // The pass and the count of the outermost `repeat` around the step last returned; 0 when there is
  // none.
  std::int64_t repeat() const;
  std::int64_t repeats() const;
  const Environment& environment() const { return environment_; }
  // The loops around the step last returned, outermost first.
  const std::vector<Pass>& loops() const { return loops_; }

 private:
  void enter(const Step& step, const Loop& loop);
  bool again();
  const Steps& inner() const { return loops_.back().loop->steps; }

  const Steps& steps_;
  Environment& environment_;
  std::size_t at_ = 0;
  std::vector<Pass> loops_;
};

// Whether any step is a place_weight. Then the rig must be a rod with dead weights.
bool places_weights(const Steps& steps);
// Whether any step is marked as a safe point.
bool has_safe_point(const Steps& steps);
// Whether any step asks a person.
bool asks_person(const Steps& steps);
// Whether any step of the protocol is a motion.
bool moves_frame(const Protocol& protocol);
// Whether the protocol asks the frame for anything: a motion, a held force, a zero. A protocol that
// does not only records, and leaves the frame to its users.
bool commands_frame(const Protocol& protocol);
// Whether any step aims at a pressure, which needs the area of the probe tip.
bool aims_at_pressure(const Steps& steps);

}  // namespace lcrig
