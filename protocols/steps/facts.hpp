// SPDX-License-Identifier: Apache-2.0
// The facts about a step, in terms that all kinds of steps share. Parser, planner, runner, resume,
// the choice of the aperture and the budget use these facts instead of the kind of step.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "protocols/target.hpp"

namespace lcrig {

// Classes that the functions of a step use.
struct StepReader;  // file/step_reader.hpp
class PlannedRig;  // plan/planned_rig.hpp
struct StepPlan;
struct RunParts;  // run/run_parts.hpp

struct AskStep;
struct MeasureStep;
struct SetLcrStep;
struct SweepStep;
struct Step;
using Steps = std::vector<Step>;

enum class HoldMode { force, travel };
template <>
inline constexpr EnumWords<2> kWordsOf<HoldMode>{"force", "travel"};

// What a step does with the frame. Each factory function takes everything that this use has to
// state. The pointers lead into the step; nullptr: the step states no such value.
struct FrameUse {
  // What a meter that reads continuously has to resolve on the way to a force.
  enum class OnTheWay { nothing, cycle_of_loading };

  static FrameUse none() { return {Kind::watch, nullptr, nullptr, std::nullopt}; }  // watched only
  static FrameUse zero() { return {Kind::zero, nullptr, nullptr, std::nullopt}; }
  // A person places a load on a rod.
  static FrameUse weight(const Target& load) {
    return {Kind::weight, &load, nullptr, std::nullopt};
  }
  // `at`: the force to hold; nullptr: the present one.
  static FrameUse hold(HoldMode mode, const Target* at) { return {Kind::hold, at, nullptr, mode}; }
  // `speed`: of the first motion; nullptr: the motion follows a force.
  static FrameUse motion(const Target* to, const Number* speed, HoldMode leaves, OnTheWay resolve) {
    FrameUse out(Kind::motion, to, speed, leaves);
    out.loads_a_cycle = resolve == OnTheWay::cycle_of_loading;
    return out;
  }

  bool moves;  // needs a frame with a drive
  bool zeroes;  // sets a new zero of force or travel
  bool places_weight;  // by a person; needs a rod with dead weights
  bool loads_a_cycle = false;
  const Target* aim;  // the target of the motion, or the force to hold or place
  const Number* speed;  // m/s
  std::optional<HoldMode> leaves;  // what the frame holds afterwards; absent: no change

 private:
  enum class Kind { watch, zero, weight, hold, motion };
  FrameUse(Kind kind, const Target* a, const Number* s, std::optional<HoldMode> l)
      : moves(kind == Kind::motion),
        zeroes(kind == Kind::zero),
        places_weight(kind == Kind::weight),
        aim(a),
        speed(s),
        leaves(l) {}
};

// The steps inside a loop, which run a number of times, or once for each value of a variable.
class Loop {
 public:
  Loop(const Steps& steps, const Number& count) : steps_(&steps), count_(&count) {}
  Loop(const Steps& steps, const SweepStep& sweep) : steps_(&steps), sweep_(&sweep) {}

  const Steps& steps() const { return *steps_; }
  const Number* count() const { return count_; }  // nullptr: a sweep
  const SweepStep* sweep() const { return sweep_; }  // nullptr: a repeat
  std::int64_t passes(const Environment& environment) const;

 private:
  const Steps* steps_;
  const Number* count_ = nullptr;
  const SweepStep* sweep_ = nullptr;  // exactly one of count_ and sweep_ is set
};

inline constexpr const MeasureStep* kNoReadings = nullptr;
inline constexpr const SetLcrStep* kNoSettings = nullptr;
inline constexpr const AskStep* kNoQuestion = nullptr;
inline constexpr std::nullopt_t kNoLoop = std::nullopt;

// No fact has a default, so a step that omits one does not compile.
struct StepFacts : FrameUse {
  StepFacts(const FrameUse& frame, const MeasureStep* readings, const SetLcrStep* settings,
            const AskStep* question, std::optional<Loop> l)
      : FrameUse(frame), measures(readings), sets_meter(settings), asks(question), loop(l) {}

  const MeasureStep* measures;
  const SetLcrStep* sets_meter;
  const AskStep* asks;  // the question to a person
  std::optional<Loop> loop;

  // True for a motion, a zero or a held force. Other steps only watch the frame.
  bool commands_frame() const { return moves || zeroes || leaves == HoldMode::force; }
  bool needs_meter() const { return measures != nullptr || sets_meter != nullptr; }
};

}  // namespace lcrig
