// SPDX-License-Identifier: Apache-2.0
// All kinds of steps. A kind is a struct with its data and with
//   kWord     the word after "do" in a file,
//   parse()   reads its keys,
//   facts()   what it requires of the rig (facts.hpp),
//   Progress  what it remembers while it runs (progress.hpp),
//   plan()    its duration, its worst effect on the specimen, and whether that is allowed,
//   execute() its actions in a run. It ends by itself or with an error. An interrupt cancels it; to
//             continue, it is called again with the same progress.
// Code that depends on the kind visits `action`, so a kind that lacks a member does not compile.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "protocols/steps/ask.hpp"
#include "protocols/steps/find_contact.hpp"
#include "protocols/steps/hold.hpp"
#include "protocols/steps/mark.hpp"
#include "protocols/steps/measure.hpp"
#include "protocols/steps/move_until.hpp"
#include "protocols/steps/place_weight.hpp"
#include "protocols/steps/ramp.hpp"
#include "protocols/steps/record.hpp"
#include "protocols/steps/repeat.hpp"
#include "protocols/steps/set_gap.hpp"
#include "protocols/steps/set_lcr.hpp"
#include "protocols/steps/sweep.hpp"
#include "protocols/steps/zero.hpp"

namespace lcrig {

// In the order in which messages list the words.
using Action = std::variant<ZeroStep, FindContactStep, RampStep, MoveUntilStep, HoldStep,
                            MeasureStep, PlaceWeightStep, RecordStep, SetLcrStep, RepeatStep,
                            SweepStep, MarkStep, SetGapStep, AskStep>;

struct Step {
  std::string id;  // unique in the file
  std::string pointer;  // JSON pointer, for messages
  bool safe_point = false;  // the run may be stopped after it (stop_places.hpp)
  Action action;
};

// The word after "do": "find_contact".
std::string_view kind_of(const Step& step);
StepFacts facts_of(const Step& step);
// An object of the kind's `Progress`.
std::unique_ptr<StepProgress> new_progress(const Step& step);

}  // namespace lcrig
