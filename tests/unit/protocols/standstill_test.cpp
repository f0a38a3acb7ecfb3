// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/standstill.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr double kTolerance_m = 3e-6;
constexpr Duration kPeriod = 20ms;

class StandstillTest : public ::testing::Test {
 protected:
  MonoTime at(Duration d) const { return MonoTime(d); }
  // Shows samples from now on, of a frame that moves at this speed.
  void show(Duration lasts, double speed_m_s, std::uint32_t flags = 0) {
    for (const MonoTime end = now + lasts; now < end;) {
      now += kPeriod;
      travel_m += speed_m_s * to_seconds(kPeriod);
      FrameSample s;
      s.travel_m = travel_m;
      s.flags = flags;
      s.received = now;
      still.take(s, kTolerance_m);
    }
  }
  Standstill word() const { return still.at(now); }

  MonoTime now{1h};
  double travel_m = 0;
  StandstillWatch still{true};
};

TEST_F(StandstillTest, IsClaimedOnlyAfterTheWordOfTheFrameAndSamplesThatAgree) {
  EXPECT_EQ(word(), Standstill::not_asked);
  still.order(1e-4);
  still.ask(now, 0ms);
  show(500ms, 0);
  EXPECT_EQ(word(), Standstill::awaited) << "it stands, and has not said so";
  still.confirm(now, kPeriod);
  EXPECT_FALSE(still.holds());
  show(400ms, 0);
  EXPECT_EQ(word(), Standstill::confirmed);
  still.order(1e-4);
  EXPECT_EQ(word(), Standstill::not_asked);
}

// What arrived while this program stood still came at one instant, and shows nothing of that time.
TEST_F(StandstillTest, IsAwaitedLongerByTheLagOfThisProgram) {
  still.order(1e-4);
  still.ask(now, 0ms);
  still.confirm(now, kPeriod);
  const MonoTime ended = still.look_ends();
  now += 1500ms;
  still.allow_lag(1480ms);
  EXPECT_EQ(still.look_ends(), ended + 1480ms);
  EXPECT_EQ(word(), Standstill::awaited) << "no alarm because of it";
  show(400ms, 0);
  EXPECT_EQ(word(), Standstill::confirmed);
}

TEST_F(StandstillTest, IsNotConfirmedBySamplesThatMove) {
  for (const double speed_m_s : {8e-6, 1e-4, 1e-3, -1e-4}) {
    SCOPED_TRACE(speed_m_s);
    still.order(speed_m_s);
    still.ask(now, 0ms);
    still.confirm(now, kPeriod);
    show(1100ms, speed_m_s);
    EXPECT_EQ(word(), Standstill::awaited);
    show(100ms, speed_m_s);
    EXPECT_EQ(word(), Standstill::not_confirmed);
    show(1s, 0);
    EXPECT_EQ(word(), Standstill::confirmed) << "it stands now";
  }
}

// An order that is carried out after STOP. Samples of the braking may still be under way.
TEST_F(StandstillTest, IsContradictedByAMotionThatBeginsAfterTheWordOfTheFrame) {
  still.order(1e-4);
  still.ask(now, 0ms);
  still.confirm(now, kPeriod);
  show(200ms, 1e-4);
  EXPECT_FALSE(still.has_moved()) << "it may have braked";
  show(120ms, 0);
  EXPECT_TRUE(still.is_being_looked_at());
  show(40ms, 1e-3);
  EXPECT_TRUE(still.has_moved());
  EXPECT_FALSE(still.is_being_looked_at());
  still.confirm(now, kPeriod);
  EXPECT_FALSE(still.has_moved());
  show(700ms, 0);
  EXPECT_EQ(word(), Standstill::awaited) << "it moved once, so the look is longer";
  show(200ms, 0);
  EXPECT_EQ(word(), Standstill::confirmed);
}

// A frame that creeps at 20 um/s after the last motion of a run was called standing: 4 um in the
// shorter look are within the tolerance.
TEST_F(StandstillTest, TheLookAtTheEndOfARunSeesACreepHoweverFastTheLastMotionWas) {
  for (const double ordered_m_s : {1e-5, 5e-4, 5e-3}) {
    for (const double creep_m_s : {4e-6, 1e-5, 1.5e-5, 2e-5, -2e-5, 1e-4}) {
      SCOPED_TRACE(testing::Message() << ordered_m_s << " " << creep_m_s);
      still.order(ordered_m_s);
      still.look_longer();
      still.ask(now, 0ms);
      still.confirm(now, kPeriod);
      show(1200ms, creep_m_s);
      EXPECT_EQ(word(), Standstill::not_confirmed);
      show(1s, 0);
      EXPECT_EQ(word(), Standstill::confirmed);
    }
  }
}

TEST_F(StandstillTest, IsNotConfirmedWhileTheFrameSaysThatItMoves) {
  still.order(1e-4);
  still.ask(now, 0ms);
  still.confirm(now, kPeriod);
  show(500ms, 0, frame_flag::kMoving);
  EXPECT_FALSE(still.holds());
}

// Batches of 100 ms, of which the first one may come late.
TEST_F(StandstillTest, AfterASlowMotionIsConfirmedByTheTimeTheLookEnds) {
  still.order(2e-6);
  still.ask(now, 0ms);
  still.confirm(now, kPeriod);
  now += 200ms;
  FrameSample s;
  s.travel_m = 1e-3;
  for (int i = 0; i < 9; ++i, now += 100ms) {
    s.received = now;
    still.take(s, kTolerance_m);
  }
  EXPECT_LT(now - 100ms, still.look_ends());
  EXPECT_EQ(word(), Standstill::confirmed);
}

TEST_F(StandstillTest, HasTheTimeOfBraking) {
  still.order(1e-2);
  still.ask(now, 2s);
  now += 2900ms;
  EXPECT_EQ(word(), Standstill::awaited);
  now += 200ms;
  EXPECT_EQ(word(), Standstill::not_confirmed);
}

TEST_F(StandstillTest, IsAnAlarmNoLaterWhenStopIsRepeated) {
  still.order(1e-4);
  for (int i = 0; i < 5; ++i) {
    still.ask(now, 0ms);
    now += 300ms;
  }
  EXPECT_EQ(word(), Standstill::not_confirmed);
}

TEST_F(StandstillTest, IsAnAlarmNoLaterWhenEachStopIsConfirmedAndTheFrameMovesOn) {
  still.order(1e-4);
  for (int i = 0; i < 4; ++i) {
    still.ask(now, 0ms);
    still.confirm(now, kPeriod);
    show(500ms, 1e-4);
  }
  EXPECT_EQ(word(), Standstill::not_confirmed);
}

TEST_F(StandstillTest, IsUnknownWithoutALinkWhateverWasConfirmed) {
  still.ask(now, 0ms);
  still.confirm(now, std::nullopt);
  EXPECT_TRUE(still.holds());
  still.lose();
  EXPECT_EQ(word(), Standstill::unknown);
  still.ask(now, 0ms);
  still.confirm(now, std::nullopt);
  EXPECT_EQ(word(), Standstill::unknown) << "the link that is lost said so";
  still.rejoin();
  still.ask(now, 0ms);
  still.confirm(now, std::nullopt);
  EXPECT_EQ(word(), Standstill::confirmed);
}

TEST_F(StandstillTest, EndsWhenASampleContradicts) {
  still.ask(now, 0ms);
  still.confirm(now, std::nullopt);
  now += 1ms;
  still.contradict(now);
  now += 1ms;
  EXPECT_EQ(word(), Standstill::not_confirmed);
}

TEST(Standstills, EachHasWordsIfSomebodyHasToAct) {
  EXPECT_NE(alarm_words(Standstill::not_confirmed), "");
  EXPECT_NE(alarm_words(Standstill::unknown), "");
  EXPECT_EQ(alarm_words(Standstill::awaited), "");
  EXPECT_EQ(alarm_words(Standstill::cannot_move), "");
}

}  // namespace
}  // namespace lcrig
