// SPDX-License-Identifier: Apache-2.0
// Where a run stands: enough to begin again, in a new run, at the step that was interrupted.
// Written as an event (`state`) when a step begins, so it is in the same transaction as the
// samples.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "protocols/protocol.hpp"
#include "protocols/run/frame_memory.hpp"

namespace lcrig {

struct RunPoint {
  RunPoint() = default;
  std::int64_t steps_done = 0;  // leaf steps before this one, in the order of execution
  std::int64_t levels = 0;  // `measure` levels begun before it
  std::int64_t level_in_repeat = 0, level_repeat = -1;
  std::optional<double> contact_travel_m;  // gap zero
  std::optional<double> travel_m;  // of the frame when the step began
  bool zeroed = false;
  std::optional<std::string> origin;  // LoadFrame::origin
};

std::string to_json_text(const RunPoint& point);
// Errors: garbled.
Result<RunPoint> parse_run_point(std::string_view text);

// A run that was interrupted, to be continued by another one.
struct Continuation {
  Continuation() = default;
  std::int64_t run = 0;  // the interrupted one
  std::string step_id;  // where it was
  RunPoint point;
  FrameMemory frame;  // at its last sample
  bool confirmed = false;  // a person has said that the specimen was not touched
};

// The leaf step after `steps_done` others; nullptr when there are not so many. It points into
// `protocol`.
const Step* step_at(const Protocol& protocol, Environment environment, std::int64_t steps_done);

// What the samples of an interrupted run said means nothing under another zero (LoadFrame::origin),
// not even under its own, when it died before it could store that: somebody else may have set one,
// too. Errors: frame_fault.
Result<> compare_with_now(const Continuation& from, const Protocol& protocol,
                          const Environment& environment, const std::optional<std::string>& origin);

// The step to begin at: the interrupted one, or, because a rod does not know what lies on it, the
// `place_weight` before it.
std::int64_t first_step_of(const Protocol& protocol, Environment environment,
                           std::int64_t steps_done);

}  // namespace lcrig
