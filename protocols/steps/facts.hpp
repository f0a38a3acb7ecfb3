// SPDX-License-Identifier: Apache-2.0
// The facts about a step, in terms that all kinds of steps share. Parser, planner, runner, resume,
// the choice of the aperture and the budget use these facts instead of the kind of step.
#pragma once

#include <optional>
#include <string>

#include "base/enum_words.hpp"
#include "protocols/target.hpp"

namespace lcrig {

class Loop;  // steps/step.hpp
struct LcrSettings;  // drivers/lcr_meter.hpp
struct Question;  // protocols/question.hpp

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

// The readings that a step takes.
struct Readings {
  Number count;  // fresh ones
  Number within;  // s
};

// A step that changes the settings of the meter.
class MeterChange {
 public:
  // The settings after this step.
  virtual LcrSettings change(LcrSettings settings, const Environment& env) const = 0;

 protected:
  ~MeterChange() = default;
};

// A step that asks a person.
class StepQuestion {
 public:
  // The question with the present values of its references.
  virtual Question question(const std::string& step_id, const Environment& environment) const = 0;
  // Whether `environment` has all of these values.
  virtual bool is_known(const Environment& environment) const = 0;

 protected:
  ~StepQuestion() = default;
};

inline constexpr const Readings* kNoReadings = nullptr;
inline constexpr const MeterChange* kNoSettings = nullptr;
inline constexpr const StepQuestion* kNoQuestion = nullptr;
inline constexpr const Loop* kNoLoop = nullptr;

// No fact has a default, so a step that omits one does not compile.
struct StepFacts : FrameUse {
  StepFacts(const FrameUse& frame, const Readings* readings, const MeterChange* settings,
            const StepQuestion* question, const Loop* l)
      : FrameUse(frame), measures(readings), sets_meter(settings), asks(question), loop(l) {}

  const Readings* measures;
  const MeterChange* sets_meter;
  const StepQuestion* asks;
  const Loop* loop;

  // True for a motion, a zero or a held force. Other steps only watch the frame.
  bool commands_frame() const { return moves || zeroes || leaves == HoldMode::force; }
  bool needs_meter() const { return measures != nullptr || sets_meter != nullptr; }
};

}  // namespace lcrig
