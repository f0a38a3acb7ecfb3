// SPDX-License-Identifier: Apache-2.0
#include "daemon/liveness.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

MonoTime at(Duration d) {
  return MonoTime() + d;
}

TEST(Liveness, NamesExactlyThePartThatStandsStill) {
  std::uint64_t runner = 0, sampler = 0;
  Liveness parts;
  parts.watch("the runner", 2s, [&] { return std::optional(runner); });
  parts.watch("the sampler", 5s, [&] { return std::optional(sampler); });
  for (int second = 0; second < 60; ++second) {
    ++runner;
    if (second < 30) ++sampler;
    const auto stuck = parts.check(at(second * 1s));
    if (second <= 34) {
      EXPECT_THAT(stuck, IsEmpty()) << second;
    } else {
      EXPECT_THAT(stuck, ElementsAre(HasSubstr("the sampler"))) << second;
    }
  }
  ++sampler;
  EXPECT_THAT(parts.check(at(60s)), IsEmpty()) << "it moves again";
}

TEST(Liveness, APartWithoutWorkMayRest) {
  std::optional<std::uint64_t> beats = 3;
  Liveness parts;
  parts.watch("the recorder", 1s, [&] { return beats; });
  EXPECT_THAT(parts.check(at(0s)), IsEmpty());
  beats.reset();
  EXPECT_THAT(parts.check(at(100s)), IsEmpty());
  beats = 3;
  EXPECT_THAT(parts.check(at(200s)), IsEmpty()) << "its patience begins with its work";
  EXPECT_THAT(parts.check(at(202s)), ElementsAre(HasSubstr("2.0 s")));
}

// The whole process was stopped for a minute. A part that hangs after it is found all the same.
TEST(Liveness, NobodyHangsWhileTheProcessItselfStandsStill) {
  std::uint64_t beats = 1;
  Liveness parts;
  parts.watch("the runner", 20s, [&] { return std::optional(beats); });
  EXPECT_THAT(parts.check(at(0s)), IsEmpty());
  EXPECT_THAT(parts.check(at(60s)), IsEmpty());
  for (int second = 61; second <= 77; ++second) {
    EXPECT_THAT(parts.check(at(second * 1s)), IsEmpty()) << second;
  }
  EXPECT_THAT(parts.check(at(79s)), ElementsAre(HasSubstr("21.0 s")));
}

TEST(LoopLag, TellsWhatIsLateAndKeepsTheWorst) {
  LoopLag lag(200ms);
  EXPECT_FALSE(lag.note(at(1s), at(1s + 150ms)));
  EXPECT_EQ(lag.note(at(2s), at(2s + 700ms)), 700ms);
  EXPECT_FALSE(lag.note(at(3s), at(3s)));
  EXPECT_EQ(lag.worst(), 700ms);
}

}  // namespace
}  // namespace lcrig
