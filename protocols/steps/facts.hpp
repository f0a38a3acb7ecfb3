// SPDX-License-Identifier: Apache-2.0
// What a step asks for, in terms that all steps share. Parser, planner, runner, resume, the choice
// of the aperture and the budget ask for these facts instead of for the kind of a step.
#pragma once

#include <optional>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "protocols/target.hpp"

namespace lcrig {

// What the functions of a step work with.
struct StepReader;  // file/step_reader.hpp
class PlannedRig;  // plan/planned_rig.hpp
struct StepPlan;
struct RunParts;  // run/run_parts.hpp
struct StepProgress;

struct AskStep;
struct MeasureStep;
struct SetLcrStep;
struct SweepStep;
struct Step;
using Steps = std::vector<Step>;

enum class HoldMode { travel, force };

// The pointers lead into the step; nullptr: it has no such thing.
struct StepFacts {
  bool moves = false;  // needs a frame with a drive
  bool zeroes = false;  // sets a new zero of force or travel
  bool places_weight = false;  // a person does; needs a rod with dead weights
  bool loads_a_cycle = false;  // on its way to a force the meter has to resolve a cycle of loading
  const Target* aim = nullptr;  // where it goes, or the force that it holds or places
  const Number* speed = nullptr;  // of the motion that it begins with, m/s
  std::optional<HoldMode> leaves{};  // what the frame holds afterwards; absent: as before
  const MeasureStep* measures = nullptr;
  const SetLcrStep* sets_meter = nullptr;
  const AskStep* asks = nullptr;  // a person answers
  // A loop: its steps, how often they run (absent: once for each value), its variable.
  const Steps* inside = nullptr;
  const Number* passes = nullptr;
  const SweepStep* sweep = nullptr;

  // A motion, a zero or a held force; the frame of other steps is only watched.
  bool commands_frame() const { return moves || zeroes || leaves == HoldMode::force; }
  bool needs_meter() const { return measures != nullptr || sets_meter != nullptr; }
};

}  // namespace lcrig
