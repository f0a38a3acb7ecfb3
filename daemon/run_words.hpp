// SPDX-License-Identifier: Apache-2.0
// Words about a run for the journal and the service manager, one line each. Used by App.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/run_request.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

inline constexpr std::size_t kLongestReason = 500;  // characters in the journal

// "run 3", "simulated run 3"
std::string run_words(bool simulated, std::int64_t run);
// " (anchor 57:9c4f…)". The journal keeps the anchor apart from the database, so both cannot be
// changed together. Empty without an anchor.
std::string anchor_words(const std::string& anchor);
// The words for a run that was found without an end. `had_ended`: its end was deleted, and the
// anchor belongs to that end.
std::string orphan_line(std::int64_t run, const std::string& anchor, bool had_ended);
// "run 3 static-frame on paper-1: running, level, 34 %, 8 min left"
std::string service_line(const RunStatus& status);
// "simulated run 3 ended: abort SIGTERM (anchor 57:9c4f…)"
std::string ended_line(const RunOutcome& ended);

}  // namespace lcrig
