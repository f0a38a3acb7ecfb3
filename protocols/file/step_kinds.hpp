// SPDX-License-Identifier: Apache-2.0
// All kinds of steps. Only the parser and tests include them.
#pragma once

#include <tuple>

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
using StepKinds = std::tuple<ZeroStep, FindContactStep, RampStep, MoveUntilStep, HoldStep,
                             MeasureStep, PlaceWeightStep, RecordStep, SetLcrStep, RepeatStep,
                             SweepStep, MarkStep, SetGapStep, AskStep>;

}  // namespace lcrig
