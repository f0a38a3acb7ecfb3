// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/when.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <ctime>

#include "base/day_time.hpp"
#include "base/number.hpp"

namespace lcrig::cli {

namespace {

// "18:00", "18:00:03"
std::optional<std::tm> time_of(std::string_view text) {
  const auto minute = parse_minute_of_day(text.substr(0, 5));
  if (!minute) return std::nullopt;
  std::tm out{};
  out.tm_hour = *minute / 60;
  out.tm_min = *minute % 60;
  if (text.size() == 5) return out;
  const auto second =
      text[5] == ':' && text.size() == 8 ? number_from<int>(text.substr(6)) : std::optional<int>();
  if (!second || *second < 0 || *second > 59) return std::nullopt;
  out.tm_sec = *second;
  return out;
}

std::tm local(std::int64_t unix_s) {
  return fmt::localtime(static_cast<std::time_t>(unix_s));
}

// nullopt: mktime had to change the day, so this day does not exist.
std::optional<std::int64_t> unix_of(std::tm wanted, bool utc = false) {
  const std::tm asked = wanted;
  wanted.tm_isdst = -1;
  const std::time_t found = utc ? ::timegm(&wanted) : std::mktime(&wanted);
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
  if (const auto minute = parse_minute_of_day(text)) {
    for (const int days : {0, 1}) {
      std::tm at = local(now_unix_s + days * 86'400LL);
      at.tm_hour = *minute / 60;
      at.tm_min = *minute % 60;
      at.tm_sec = 0;
      const auto found = unix_of(at);
      if (found && *found >= now_unix_s) return found;
    }
    return std::nullopt;
  }
  auto day = day_of(text.substr(0, 10));
  if (!day) return std::nullopt;
  if (text.size() == 10) return unix_of(*day);
  const bool utc = text.ends_with('Z');
  if (utc) text.remove_suffix(1);
  const auto time = time_of(text.substr(std::min<std::size_t>(11, text.size())));
  if (!time || (text[10] != 'T' && text[10] != ' ')) return std::nullopt;
  day->tm_hour = time->tm_hour;
  day->tm_min = time->tm_min;
  day->tm_sec = time->tm_sec;
  return unix_of(*day, utc);
}

std::optional<std::string> iso_day_of(std::string_view text) {
  const auto first = text.find('.');
  const auto second = first == text.npos ? first : text.find('.', first + 1);
  if (second == text.npos) return std::nullopt;
  const auto day = number_from<int>(text.substr(0, first));
  const auto month = number_from<int>(text.substr(first + 1, second - first - 1));
  const auto year = number_from<int>(text.substr(second + 1));
  if (!day || !month || !year || *day < 1 || *month < 1 || *year < 1970) return std::nullopt;
  auto iso = fmt::format("{:04}-{:02}-{:02}", *year, *month, *day);
  const auto found = day_of(iso);
  return found && unix_of(*found) ? std::optional(std::move(iso)) : std::nullopt;
}

}  // namespace lcrig::cli
