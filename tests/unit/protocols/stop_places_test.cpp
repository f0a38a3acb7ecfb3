// SPDX-License-Identifier: Apache-2.0
// Levels, cycles and repeats of a protocol, and where each of them ends next.
#include "protocols/stop_places.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocols/file/parse.hpp"

namespace lcrig {
namespace {

using testing::ElementsAre;

std::string file(const std::string& steps) {
  return R"({ "format": "load-protocol/1", "name": "t",
    "limits": { "force_N": [-1, 5], "gap_mm": [-1, 60] },
    "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,
                         "aperture": "fast" } },
    "steps": [)" +
         steps + R"(],
    "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 5 }, "speed_mm_s": 1, "timeout_s": 60 } ] })";
}
std::string load(const std::string& id, const std::string& force_N) {
  return R"({ "id": ")" + id + R"(", "do": "move_until", "until": { "force_N": )" + force_N +
         R"( }, "speed_mm_s": 0.1, "timeout_s": 60 })";
}
std::string unload(const std::string& id, const std::string& gap_mm = "1") {
  return R"({ "id": ")" + id + R"(", "do": "ramp", "to": { "gap_mm": )" + gap_mm +
         R"( }, "speed_mm_s": 0.1, "timeout_s": 60 })";
}
std::string measure(const std::string& id) {
  return R"({ "id": ")" + id + R"(", "do": "measure", "count": 1, "within_s": 1 })";
}
std::string mark(const std::string& id, const std::string& more = "") {
  return R"({ "id": ")" + id + R"(", "do": "mark", "text": "x")" + more + " }";
}
std::string repeat(const std::string& id, int count, const std::string& steps) {
  return fmt::format(R"({{ "id": "{}", "do": "repeat", "count": {}, "steps": [ {} ] }})", id, count,
                     steps);
}
std::string sweep(const std::string& id, const std::string& name, const std::string& values,
                  const std::string& steps) {
  return fmt::format(
      R"({{ "id": "{}", "do": "sweep", "name": "{}", "values": [ {} ], "steps": [ {} ] }})", id,
      name, values, steps);
}

struct Walk {
  explicit Walk(const std::string& steps) : protocol(parse_protocol(file(steps), "t").value()) {}
  // The steps at the end of such places, each with its number in the order of execution.
  std::vector<std::string> ends(StopPlace place) {
    StopPlaces places(environment);
    StepCursor cursor(protocol.steps, environment);
    std::vector<std::string> out;
    int n = 0;
    while (const Step* step = cursor.next()) {
      ++n;
      if (places.ends(place, cursor, *step)) out.push_back(fmt::format("{} {}", n, step->id));
    }
    return out;
  }
  // For the n-th step (from 1): the last step of the place that ends next, with its number.
  std::string next(int n, StopPlace place) {
    StopPlaces places(environment);
    StepCursor cursor(protocol.steps, environment);
    bool begun = false;
    const Step* step = nullptr;
    for (int i = 0; i < n; ++i) {
      if (step != nullptr && facts_of(*step).measures != nullptr) begun = false;
      step = cursor.next();
      begun = begun || begins_level(*step);
    }
    const auto ahead = places.ahead(place, cursor, *step, begun, [](const auto&) { return 2.0; });
    if (!ahead) return "none";
    EXPECT_EQ(ahead->seconds, 2.0 * static_cast<double>(ahead->steps - 1));
    return fmt::format("{} {}", n + ahead->steps - 1, ahead->step_id);
  }

  Protocol protocol;
  Environment environment;
};

// The static experiment: the sweep only loads; the repeat around it unloads.
const std::string kStatic =
    mark("begin") + "," +
    repeat("pass", 2,
           sweep("levels", "f_N", "1, 2",
                 load("load", "\"$f_N\"") + "," + mark("settle") + "," + measure("level")) +
               "," + unload("unload") + "," + mark("rest"));
// 1 begin, 2 load 3 settle 4 level 5 load 6 settle 7 level 8 unload 9 rest, 10 load ... 17 rest

TEST(StopPlaces, ASweepOfLoadsIsNoCycleTheLoopThatUnloadsIs) {
  Walk walk(kStatic);
  EXPECT_THAT(walk.ends(StopPlace::level),
              ElementsAre("4 level", "7 level", "12 level", "15 level"));
  EXPECT_THAT(walk.ends(StopPlace::cycle), ElementsAre("9 rest", "17 rest"));
  EXPECT_THAT(walk.ends(StopPlace::repeat), ElementsAre("9 rest", "17 rest"));
  EXPECT_EQ(walk.ends(StopPlace::step).size(), 17U);
}

// 1 pre, 2 load 3 unload, 4 load 5 unload, 6 tail, 7 pre ... 12 tail
TEST(StopPlaces, BesideTheInnermostLoopThatLoadsNoCycleIsUnderWay) {
  Walk walk(repeat("outer", 2,
                   mark("pre") + "," +
                       repeat("inner", 2, load("load", "1") + "," + unload("unload")) + "," +
                       mark("tail")));
  EXPECT_THAT(walk.ends(StopPlace::cycle),
              ElementsAre("3 unload", "5 unload", "9 unload", "11 unload"));
  EXPECT_EQ(walk.next(1, StopPlace::cycle), "1 pre");
  EXPECT_EQ(walk.next(2, StopPlace::cycle), "3 unload");
  EXPECT_EQ(walk.next(6, StopPlace::cycle), "6 tail");
  EXPECT_EQ(walk.next(1, StopPlace::repeat), "6 tail");
}

// The inner variables have no values yet.
TEST(StopPlaces, SweepsInsideThatHaveNotBegunDoNotMatter) {
  const std::string levels = sweep(
      "force", "f_N", "1, 2",
      sweep("again", "g_N", "1, 2", load("load", "\"$f_N\"") + "," + load("more", "\"$g_N\"")));
  Walk walk(repeat("pass", 2, mark("pre") + "," + levels + "," + unload("unload")));
  EXPECT_EQ(walk.next(1, StopPlace::cycle), "1 pre");
}

TEST(StopPlaces, WhatIsUnderWayIsFinished) {
  Walk walk(kStatic);
  EXPECT_EQ(walk.next(2, StopPlace::step), "2 load");
  for (const int n : {2, 3, 4}) EXPECT_EQ(walk.next(n, StopPlace::level), "4 level") << n;
  EXPECT_EQ(walk.next(5, StopPlace::level), "7 level");
  EXPECT_EQ(walk.next(5, StopPlace::cycle), "9 rest");
  EXPECT_EQ(walk.next(11, StopPlace::repeat), "17 rest");
}

TEST(StopPlaces, OfWhatIsNotUnderWayNothingIsBegun) {
  Walk walk(kStatic);
  EXPECT_EQ(walk.next(1, StopPlace::cycle), "1 begin");
  EXPECT_EQ(walk.next(1, StopPlace::repeat), "1 begin");
  EXPECT_EQ(walk.next(1, StopPlace::level), "1 begin");
  EXPECT_EQ(walk.next(8, StopPlace::level), "8 unload") << "the next level would load again";
  EXPECT_EQ(walk.next(9, StopPlace::level), "9 rest");
}

// Two measures at one load: the motion belongs to the first one.
TEST(StopPlaces, ALevelIsOneMeasureWithTheMotionBeforeIt) {
  Walk walk(load("fast", "1") + "," + load("slow", "2") + "," + measure("a") + "," + mark("m") +
            "," + measure("b"));
  EXPECT_EQ(walk.next(1, StopPlace::level), "1 fast") << "the motion before `a` is `slow`";
  EXPECT_EQ(walk.next(2, StopPlace::level), "3 a");
  EXPECT_EQ(walk.next(4, StopPlace::level), "4 m");
  EXPECT_EQ(walk.next(5, StopPlace::level), "5 b");
}

TEST(StopPlaces, ACycleIsThatOfTheInnermostLoopThatLoadsAndUnloads) {
  // Preload, three cycles, unload: all of it twice, at two rates.
  Walk walk(sweep("rates", "rate", "1, 2",
                  load("preload", "0.5") + "," +
                      repeat("cycles", 2, load("up", "2") + "," + unload("down", "0")) + "," +
                      unload("away")));
  // 1 preload, 2 up 3 down 4 up 5 down, 6 away; 7 preload ... 12 away
  EXPECT_THAT(walk.ends(StopPlace::cycle), ElementsAre("3 down", "5 down", "9 down", "11 down"));
  EXPECT_EQ(walk.next(1, StopPlace::cycle), "1 preload") << "it is in no cycle";
  EXPECT_THAT(walk.ends(StopPlace::repeat), ElementsAre("6 away", "12 away"));
  EXPECT_EQ(walk.next(2, StopPlace::cycle), "3 down");
  EXPECT_EQ(walk.next(2, StopPlace::repeat), "6 away");
  EXPECT_EQ(walk.next(6, StopPlace::cycle), "6 away") << "no cycle is begun any more";
}

TEST(StopPlaces, BetweenTwoForcesIsACycleToo) {
  Walk between(repeat("c", 2, load("up", "2") + "," + load("ease", "1")));
  EXPECT_THAT(between.ends(StopPlace::cycle), ElementsAre("2 ease", "4 ease"));
  Walk same(repeat("c", 2, load("up", "2") + "," + load("again", "2")));
  EXPECT_THAT(same.ends(StopPlace::cycle), ElementsAre());
  Walk apart(repeat("c", 2, unload("near", "1") + "," + unload("far", "2")));
  EXPECT_THAT(apart.ends(StopPlace::cycle), ElementsAre()) << "it never loads";
}

TEST(StopPlaces, ASafePointIsWhereTheFileSaysSo) {
  Walk walk(mark("a") + "," +
            repeat("r", 2, mark("b", R"(, "safe_point": true)") + "," + mark("c")) + "," +
            mark("d"));
  EXPECT_THAT(walk.ends(StopPlace::safe_point), ElementsAre("2 b", "4 b"));
  EXPECT_EQ(walk.next(1, StopPlace::safe_point), "2 b");
  EXPECT_EQ(walk.next(2, StopPlace::safe_point), "2 b");
  EXPECT_EQ(walk.next(3, StopPlace::safe_point), "4 b");
  EXPECT_EQ(walk.next(5, StopPlace::safe_point), "none");
}

TEST(StopPlaces, EveryWordIsReadAsItIsWritten) {
  for (const StopPlace place : {StopPlace::step, StopPlace::level, StopPlace::cycle,
                                StopPlace::repeat, StopPlace::safe_point}) {
    EXPECT_EQ(parse_word<StopPlace>(to_string(place)), place);
  }
  EXPECT_FALSE(parse_word<StopPlace>("levels"));
  EXPECT_FALSE(parse_word<StopPlace>(""));
}

}  // namespace
}  // namespace lcrig
