// SPDX-License-Identifier: Apache-2.0
// Reads the last `state` event of an interrupted run (events/payloads.hpp) and finds the step to
// continue at. Used by daemon/continuation and TakeOver.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "events/payloads.hpp"
#include "protocols/protocol.hpp"
#include "protocols/rig/last_seen.hpp"

namespace lcrig {

// Errors: garbled.
Result<RunPoint> parse_run_point(std::string_view text);

struct StoredAnswer {
  std::string step_id;
  AnswerEvent answer;
};

// An interrupted run that another run continues.
struct Continuation {
  std::int64_t run = 0;  // its number
  std::string step_id;  // the step that was interrupted
  RunPoint point;
  LastSeen frame;  // at its last sample
  std::vector<StoredAnswer> answers;  // answers to its questions, in the order of asking
  bool confirmed = false;  // a person said that nobody touched the specimen
};

// The leaf step after `steps_done` others, within `protocol`; nullptr: there are not so many.
const Step* step_at(const Protocol& protocol, Environment environment, std::int64_t steps_done);

// Refuses a frame whose zero (LoadFrame::origin) differs from that of the interrupted run, because
// its samples would mean something else. Also refuses a run that died before it could store its
// zero: somebody else may have set one since. Errors: frame_fault.
Result<> compare_with_now(const Continuation& from, const Protocol& protocol,
                          const Environment& environment, const std::optional<std::string>& origin);

// The step to continue at: the interrupted one, or the `place_weight` before it, because a rod does
// not know which weights lie on it.
std::int64_t first_step_of(const Protocol& protocol, Environment environment,
                           std::int64_t steps_done);

}  // namespace lcrig
