// SPDX-License-Identifier: Apache-2.0
#include "base/day_time.hpp"

#include <fmt/chrono.h>

#include <ctime>

#include "base/number.hpp"

namespace lcrig {

namespace {

constexpr int kMinutes = 24 * 60;

int minute_of(std::int64_t unix_s) {
  const std::tm local = fmt::localtime(static_cast<std::time_t>(unix_s));
  return local.tm_hour * 60 + local.tm_min;
}

bool is_inside(int minute, const DayWindow& window) {
  if (window.from_min <= window.to_min) {
    return window.from_min <= minute && minute < window.to_min;
  }
  return minute >= window.from_min || minute < window.to_min;
}

}  // namespace

std::optional<int> parse_minute_of_day(std::string_view text) {
  if (text.size() != 5 || text[2] != ':') return std::nullopt;
  const auto hour = number_from<int>(text.substr(0, 2));
  const auto minute = number_from<int>(text.substr(3));
  if (!hour || !minute || *hour < 0 || *hour > 23 || *minute < 0 || *minute > 59) return {};
  return *hour * 60 + *minute;
}

std::optional<DayWindow> parse_day_window(std::string_view text) {
  const auto dash = text.find('-');
  if (dash == text.npos) return std::nullopt;
  const auto from = parse_minute_of_day(text.substr(0, dash));
  const auto to = parse_minute_of_day(text.substr(dash + 1));
  if (!from || !to || *from == *to) return std::nullopt;
  return DayWindow{.from_min = *from, .to_min = *to};
}

std::string to_string(const DayWindow& w) {
  return fmt::format("{:02}:{:02}-{:02}:{:02}", w.from_min / 60, w.from_min % 60, w.to_min / 60,
                     w.to_min % 60);
}

// Steps minute by minute, because when clocks change an hour of the night is missing or occurs
// twice.
std::int64_t next_inside(std::int64_t now_unix_s, const DayWindow& window) {
  if (is_inside(minute_of(now_unix_s), window)) return now_unix_s;
  std::int64_t at = now_unix_s - now_unix_s % 60;
  for (int i = 0; i <= kMinutes + 120; ++i) {
    at += 60;
    if (is_inside(minute_of(at), window)) return at;
  }
  return at;
}

std::string local_time(std::int64_t unix_s) {
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(static_cast<std::time_t>(unix_s)));
}

}  // namespace lcrig
