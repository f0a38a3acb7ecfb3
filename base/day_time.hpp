// SPDX-License-Identifier: Apache-2.0
// Reads and compares times of day, in the local time of the computer. The terms of the queue use
// it, and the command line, which reads them from people.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

// "18:00", in minutes after midnight.
std::optional<int> parse_minute_of_day(std::string_view text);

// Minutes after midnight. Where `from` is later than `to` it passes midnight.
struct DayWindow {
  int from_min = 0, to_min = 0;
  bool operator==(const DayWindow&) const = default;
};
std::optional<DayWindow> parse_day_window(std::string_view text);  // "18:00-06:30"
std::string to_string(const DayWindow& window);

// The first second from `now` on that is inside.
std::int64_t next_inside(std::int64_t now_unix_s, const DayWindow& window);
std::string local_time(std::int64_t unix_s);  // "2026-11-23 22:00"

}  // namespace lcrig
