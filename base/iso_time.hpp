// SPDX-License-Identifier: Apache-2.0
// Times of day as text, for people and other programs. Used by exports and reports.
#pragma once

#include <cstdint>
#include <string>

namespace lcrig {

// ISO 8601 with milliseconds and offset: "2026-01-31T12:00:00.250+00:00". Always UTC, because a run
// does not record its time zone.
std::string iso_time(std::int64_t unix_ns);

}  // namespace lcrig
