// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/when.hpp"

#include <gtest/gtest.h>

#include <ctime>
#include <string>

#include "base/day_time.hpp"

namespace lcrig::cli {
namespace {

constexpr std::int64_t kNow = 1'790'000'000;

std::string shown(std::int64_t unix_s, const char* format) {
  const auto t = static_cast<std::time_t>(unix_s);
  std::tm local{};
  ::localtime_r(&t, &local);
  char out[64];
  std::strftime(out, sizeof out, format, &local);
  return out;
}

TEST(UnixTimeOf, ATimeOfTheDayIsTheNextOne) {
  for (const char* text : {"00:00", "06:30", "22:00", "23:59"}) {
    const auto found = unix_time_of(text, kNow);
    ASSERT_TRUE(found) << text;
    EXPECT_EQ(shown(*found, "%H:%M:%S"), std::string(text) + ":00");
    EXPECT_GE(*found, kNow);
    EXPECT_LE(*found, kNow + 25 * 3600);
  }
}

TEST(UnixTimeOf, ADayMayHaveATime) {
  for (const char* text : {"2026-11-24 06:30", "2026-11-24T06:30"}) {
    const auto found = unix_time_of(text, kNow);
    ASSERT_TRUE(found) << text;
    EXPECT_EQ(shown(*found, "%Y-%m-%d %H:%M:%S"), "2026-11-24 06:30:00");
  }
  EXPECT_EQ(shown(unix_time_of("2026-11-24", kNow).value(), "%Y-%m-%d %H:%M"), "2026-11-24 00:00");
}

TEST(UnixTimeOf, TakesWhatRunsPrints) {
  EXPECT_EQ(unix_time_of("2026-01-01T00:00:03Z", kNow), 1'767'225'603);
  EXPECT_EQ(unix_time_of("2026-01-01 00:00Z", kNow), 1'767'225'600);
  EXPECT_EQ(shown(unix_time_of("2026-11-24 06:30:07", kNow).value(), "%Y-%m-%d %H:%M:%S"),
            "2026-11-24 06:30:07");
  for (const char* text : {"2026-01-01Z", "2026-01-01T00:00:60Z", "2026-01-01T00:00:3Z", "00:00Z",
                           "2026-01-01T00:00:03+01:00", "2026-01-01T00:00:", "Z"}) {
    EXPECT_FALSE(unix_time_of(text, kNow)) << text;
  }
}

TEST(IsoDayOf, ReadsADayWithPoints) {
  EXPECT_EQ(iso_day_of("24.11.2026"), "2026-11-24");
  EXPECT_EQ(iso_day_of("1.2.2026"), "2026-02-01");
  for (const char* text :
       {"", "24.11.", "31.2.2026", "2026-11-24", "24.11.26", "a.b.c", "0.1.2026"}) {
    EXPECT_FALSE(iso_day_of(text)) << text;
  }
}

TEST(UnixTimeOf, WhatIsNoTimeIsNone) {
  for (const char* text : {"", "6:30", "24:00", "22:60", "tomorrow", "2026-02-30", "2026-13-01",
                           "2026-11-24 ", "2026-11-24 6:30", "2026-11-24x06:30", "2026/11/24"}) {
    EXPECT_FALSE(unix_time_of(text, kNow)) << text;
  }
}

TEST(When, AWindowOfTheDayIsTwoTimesThatDiffer) {
  EXPECT_TRUE(parse_day_window("18:00-06:00"));
  EXPECT_TRUE(parse_day_window("06:00-06:01"));
  for (const char* text :
       {"", "18-6", "18:00", "18:00-18:00", "25:00-06:00", "18:00 06:00", "18:00-06:00-"}) {
    EXPECT_FALSE(parse_day_window(text)) << text;
  }
}

}  // namespace
}  // namespace lcrig::cli
