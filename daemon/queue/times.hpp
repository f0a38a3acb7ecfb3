// SPDX-License-Identifier: Apache-2.0
// Reads and compares times of day, in the local time of the computer, for the terms that say when
// an entry may begin.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lcrig {

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
