// SPDX-License-Identifier: Apache-2.0
// Reads the last `state` event of an interrupted run (events/payloads.hpp) and finds the step to
// begin at. daemon/continuation and TakeOver use it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "events/payloads.hpp"
#include "protocols/protocol.hpp"
#include "protocols/run/frame_memory.hpp"

namespace lcrig {

// Errors: garbled.
Result<RunPoint> parse_run_point(std::string_view text);

struct StoredAnswer {
  std::string step_id;
  AnswerEvent answer;
};

// A run that was interrupted, to be continued by another one.
struct Continuation {
  std::int64_t run = 0;  // the interrupted one
  std::string step_id;  // where it was
  RunPoint point;
  FrameMemory frame;  // at its last sample
  std::vector<StoredAnswer> answers;  // to its questions, in the order in which they were asked
  bool confirmed = false;  // a person has said that the specimen was not touched
};

// The leaf step after `steps_done` others; nullptr when there are not so many. It points into
// `protocol`.
const Step* step_at(const Protocol& protocol, Environment environment, std::int64_t steps_done);

// Refuses a frame whose zero is another one (LoadFrame::origin) than in the interrupted run: its
// samples mean nothing then. A run that died before it could store its zero is refused, too,
// because somebody else may have set one since. Errors: frame_fault.
Result<> compare_with_now(const Continuation& from, const Protocol& protocol,
                          const Environment& environment, const std::optional<std::string>& origin);

// The step to begin at: the interrupted one, or, because a rod does not know what lies on it, the
// `place_weight` before it.
std::int64_t first_step_of(const Protocol& protocol, Environment environment,
                           std::int64_t steps_done);

}  // namespace lcrig
