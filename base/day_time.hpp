// SPDX-License-Identifier: Apache-2.0
// Reads and compares times of day in the computer's local time. Used for the terms of the queue and
// by the command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

// "18:00", in minutes after midnight.
std::optional<int> parse_minute_of_day(std::string_view text);

// Minutes after midnight. A window whose `from` is later than its `to` passes midnight.
struct DayWindow {
  int from_min = 0, to_min = 0;
  bool operator==(const DayWindow&) const = default;
};
std::optional<DayWindow> parse_day_window(std::string_view text);  // "18:00-06:30"
std::string to_string(const DayWindow& window);

// The first second, from `now` on, that lies in the window.
std::int64_t next_inside(std::int64_t now_unix_s, const DayWindow& window);
std::string local_time(std::int64_t unix_s);  // "2026-11-23 22:00"

}  // namespace lcrig
