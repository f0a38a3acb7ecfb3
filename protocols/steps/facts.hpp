// SPDX-License-Identifier: Apache-2.0
// The facts about a step, in terms that all kinds of steps share. Parser, planner, runner, resume,
// the choice of the aperture and the budget use these facts instead of the kind of step.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
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
struct RepeatStep;
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
  // watch: the frame is only watched. weight: a person places a load on a rod. cycle: a motion to a
  // force whose way a meter that reads continuously has to resolve.
  enum class Kind { watch, zero, weight, hold, motion, cycle };

  static FrameUse none() { return {Kind::watch, nullptr, nullptr, std::nullopt}; }
  static FrameUse zero() { return {Kind::zero, nullptr, nullptr, std::nullopt}; }
  static FrameUse weight(const Target& load) {
    return {Kind::weight, &load, nullptr, std::nullopt};
  }
  // `at`: the force to hold; nullptr: the present one.
  static FrameUse hold(HoldMode mode, const Target* at) { return {Kind::hold, at, nullptr, mode}; }
  // `speed`: of the first motion; nullptr: the motion follows a force.
  static FrameUse motion(const Target* to, const Number* speed, HoldMode leaves) {
    return {Kind::motion, to, speed, leaves};
  }
  static FrameUse cycle(const Target& to, const Number& speed, HoldMode leaves) {
    return {Kind::cycle, &to, &speed, leaves};
  }

  Kind frame_use;
  bool moves;  // needs a frame with a drive
  bool zeroes;  // sets a new zero of force or travel
  bool places_weight;  // by a person; needs a rod with dead weights
  const Target* aim;  // the target of the motion, or the force to hold or place
  const Number* speed;  // m/s
  std::optional<HoldMode> leaves;  // what the frame holds afterwards; absent: no change

 private:
  FrameUse(Kind kind, const Target* a, const Number* s, std::optional<HoldMode> l)
      : frame_use(kind),
        moves(kind == Kind::motion || kind == Kind::cycle),
        zeroes(kind == Kind::zero),
        places_weight(kind == Kind::weight),
        aim(a),
        speed(s),
        leaves(l) {}
};

// What a step with inner steps does with them. Each kind of loop answers each question.
class Loop {
 public:
  explicit Loop(const RepeatStep& step) : step_(&step) {}
  explicit Loop(const SweepStep& step) : step_(&step) {}

  const Steps& steps() const;
  std::int64_t passes(const Environment& environment) const;
  const Number* repeats() const;  // nullptr: it does more than repeat
  const std::string* variable() const;  // that it sets; nullptr: none
  std::vector<const Number*> ends() const;  // the values of the variable lie between these
  void set_variable(std::int64_t pass, Environment& environment) const;  // `pass` counts from 1

 private:
  std::variant<const RepeatStep*, const SweepStep*> step_;
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
