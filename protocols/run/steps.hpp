// SPDX-License-Identifier: Apache-2.0
// What each step of a protocol does while it runs. A step ends by itself or with an error; it is
// cancelled when it is interrupted, and called again with the same progress when it goes on.
#pragma once

#include "protocols/protocol.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

Task<Result<>> run_step_action(const Step& step, RunParts& run, StepProgress& progress);

Task<Result<>> execute(const ZeroStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const FindContactStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const SetGapStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const RampStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const MoveUntilStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const HoldStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const MeasureStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const PlaceWeightStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const RecordStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const SetLcrStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const MarkStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const RepeatStep& step, RunParts& run, StepProgress& progress);
Task<Result<>> execute(const SweepStep& step, RunParts& run, StepProgress& progress);

// Only what the step names changes.
void apply_settings(const SetLcrStep& step, const Environment& env, LcrSettings& settings);

}  // namespace lcrig
