// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/when.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <ctime>

#include "base/number.hpp"

namespace lcrig::cli {

namespace {

struct HourMinute {
  int hour = 0, minute = 0;
};
std::optional<HourMinute> hour_minute(std::string_view text) {
  if (text.size() != 5 || text[2] != ':') return std::nullopt;
  const auto hour = number_from<int>(text.substr(0, 2));
  const auto minute = number_from<int>(text.substr(3));
  if (!hour || !minute || *hour < 0 || *hour > 23 || *minute < 0 || *minute > 59) return {};
  return HourMinute{*hour, *minute};
}

std::tm local(std::int64_t unix_s) {
  return fmt::localtime(static_cast<std::time_t>(unix_s));
}

// nullopt: mktime had to make another day of it.
std::optional<std::int64_t> unix_of(std::tm wanted) {
  const std::tm asked = wanted;
  wanted.tm_isdst = -1;
  const std::time_t found = std::mktime(&wanted);
  if (found == -1 || wanted.tm_mday != asked.tm_mday || wanted.tm_mon != asked.tm_mon) return {};
  return static_cast<std::int64_t>(found);
}

// Times are stored as nanoseconds in 64 bits, which end in April 2262.
constexpr int kLastYear = 2261;

std::optional<std::tm> day_of(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = number_from<int>(text.substr(0, 4));
  const auto month = number_from<int>(text.substr(5, 2)), day = number_from<int>(text.substr(8));
  if (!year || !month || !day || *year < 1970 || *year > kLastYear || *month < 1 || *day < 1) {
    return std::nullopt;
  }
  std::tm out{};
  out.tm_year = *year - 1900;
  out.tm_mon = *month - 1;
  out.tm_mday = *day;
  return out;
}

}  // namespace

std::optional<std::int64_t> unix_time_of(std::string_view text, std::int64_t now_unix_s) {
  if (const auto time = hour_minute(text)) {
    for (const int days : {0, 1}) {
      std::tm at = local(now_unix_s + days * 86'400LL);
      at.tm_hour = time->hour;
      at.tm_min = time->minute;
      at.tm_sec = 0;
      const auto found = unix_of(at);
      if (found && *found >= now_unix_s) return found;
    }
    return std::nullopt;
  }
  auto day = day_of(text.substr(0, 10));
  if (!day) return std::nullopt;
  if (text.size() == 10) return unix_of(*day);
  const auto time = hour_minute(text.substr(std::min<std::size_t>(11, text.size())));
  if (!time || (text[10] != 'T' && text[10] != ' ')) return std::nullopt;
  day->tm_hour = time->hour;
  day->tm_min = time->minute;
  return unix_of(*day);
}

bool is_day_window(std::string_view text) {
  constexpr std::size_t kTime = 5;
  if (text.size() != 2 * kTime + 1 || text[kTime] != '-') return false;
  const auto from = text.substr(0, kTime), to = text.substr(kTime + 1);
  return hour_minute(from) && hour_minute(to) && from != to;
}

}  // namespace lcrig::cli
