// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

TEST(Checks, NothingIsSaidOfAFrameThatDoesWhatItIsTold) {
  WatchedFrame frame;
  frame.order(pressing(1e-4));
  EXPECT_FALSE(frame.until_found(60, [](double s) { return Place(1e-4 * s, 0.01 * s); }));
  frame.stand();
  EXPECT_FALSE(frame.until_found(600, [](double s) {  // the force relaxes by a third
    return Place(6e-3, 0.6 * (0.67 + 0.33 * std::exp(-s / 10)));
  })) << frame.found->why;
}

TEST(Checks, DigitsThatNeverChangeAreAFrozenCell) {
  WatchedFrame frame;
  frame.order(pressing(1e-4));
  EXPECT_FALSE(frame.until_found(1, [](double s) { return Place(1e-4 * s, 0.0); }));
  frame.is_frozen = true;
  const auto after = frame.until_found(5, [](double s) { return Place(1e-4 * (1 + s), 0.0); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.24);
  EXPECT_EQ(frame.found->check->doubt, Doubt::force);
}

TEST(Checks, CoarseDigitsRepeatHonestly) {
  Tolerances coarse = round_tolerances();
  coarse.frozen_samples.reset();
  WatchedFrame frame(coarse);
  frame.is_frozen = true;
  frame.order(pressing(1e-4));
  EXPECT_FALSE(frame.until_found(60, [](double s) { return Place(1e-4 * s, 0.0); }));
}

TEST(Checks, ADriveThatRunsTheWrongWayIsNoticedWithinItsWay) {
  WatchedFrame frame;
  frame.order(pressing(1e-4));
  const auto after = frame.until_found(5, [](double s) { return Place(-1e-4 * s, 0.0); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 3e-6 / 1e-4 + 0.05);
  EXPECT_EQ(frame.found->check->doubt, Doubt::drive);
  EXPECT_THAT(frame.found->why, HasSubstr("against the command"));
}

TEST(Checks, ADriveThatStallsIsNoticedInTwoSeconds) {
  WatchedFrame frame;
  frame.order(pressing(1e-4));
  const auto after =
      frame.until_found(30, [](double s) { return Place(1e-4 * std::min(s, 5.0), 0.01); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 5 + 2.6);
  EXPECT_GE(*after, 5 + 2);
  EXPECT_EQ(frame.found->check->doubt, Doubt::drive);
  EXPECT_THAT(frame.found->why, HasSubstr("where 0.1 mm/s were ordered"));
}

// A tenth of the ordered way is progress.
TEST(Checks, ADriveThatCrawlsIsNoticedBelowATenthOfItsSpeed) {
  for (const double part : {0.07, 0.15}) {
    WatchedFrame frame;
    frame.order(pressing(1e-4));
    const auto crawls = [part](double s) { return Place(1e-4 * part * s, 0.01); };
    EXPECT_EQ(frame.until_found(30, crawls).has_value(), part < 0.1) << part;
  }
}

// A tenth of a micrometre per second, shown in micrometres: the value changes every ten seconds.
TEST(Checks, TheSlowestSpeedOfACoarseTravelIsNoStall) {
  WatchedFrame frame;
  frame.order(pressing(1e-7));
  EXPECT_FALSE(frame.until_found(300, [](double s) {
    return Place(std::floor(1e-7 * s / 1e-6) * 1e-6, 0.0);
  })) << frame.found->why;
}

// Until the first motion nobody knows the digit: the travel of a frame that stands shows none.
TEST(Checks, TheFirstSlowMotionOfACoarseTravelIsNoStall) {
  for (const double digit_m : {2e-6, 5e-6, 10e-6, 12e-6, 20e-6}) {
    for (const double speed_m_s : {0.1e-6, 0.92e-6, 5e-6}) {
      for (const double part : {0.01, 0.5, 0.99}) {  // of the first digit that is behind it
        WatchedFrame frame;
        frame.order(pressing(speed_m_s));
        EXPECT_FALSE(frame.until_found(
            80e-6 / speed_m_s,
            [&](double s) {
              return Place(std::floor(part + speed_m_s * s / digit_m) * digit_m, 0.0);
            }))
            << digit_m << " m at " << speed_m_s << " m/s: " << frame.found->why;
      }
    }
  }
}

// Then a stall is one when the frame was told to go farther than the coarsest digits.
TEST(Checks, ADriveThatStallsBeforeItsDigitIsKnownIsNoticedAfterThreeOfTheCoarsest) {
  for (const double speed_m_s : {0.92e-6, 5e-6, 1e-4, 1e-3}) {
    WatchedFrame frame;
    frame.order(pressing(speed_m_s));
    const auto after = frame.until_found(200, [](double) { return Place(0.0, 0.0); });
    ASSERT_TRUE(after) << speed_m_s;
    EXPECT_LE(*after, 1.01 * std::max(2.0, 36e-6 / speed_m_s) + 0.1) << speed_m_s;
    EXPECT_EQ(frame.found->check->doubt, Doubt::drive);
  }
}

// In a fast approach with few samples per second no two travels are near each other.
TEST(Checks, TheWayBetweenTwoSamplesIsNoDigit) {
  WatchedFrame frame;
  frame.order(pressing(0.02));
  EXPECT_FALSE(frame.until_found(1, [](double s) { return Place(0.02 * s, 0.0); }));
  frame.order(pressing(1e-5));
  const auto after = frame.until_found(30, [](double s) { return Place(0.02 - 1e-5 * s, 0.0); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.4);
}

TEST(Checks, AForceThatFallsWhileItPressesIsNotBelieved) {
  WatchedFrame frame;
  frame.order(pressing(1e-5));
  const auto after =
      frame.until_found(30, [](double s) { return Place(1e-5 * s, s < 3 ? 0 : -0.1 * (s - 3)); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 3.3);
  EXPECT_EQ(frame.found->check->doubt, Doubt::force);
}

TEST(Checks, AForceThatRisesOnTheWayAwayStopsTheDrive) {
  WatchedFrame frame;
  Order m = pressing(1e-5);
  m.direction = -1;
  m.force_N = 0.5;
  frame.order(m);
  const auto after =
      frame.until_found(30, [](double s) { return Place(-1e-5 * s, 0.5 + 0.1 * s); });
  ASSERT_TRUE(after);
  EXPECT_EQ(frame.found->check->doubt, Doubt::drive);
}

// After an overload of the cell: 0.5 N was shown before it, and 4.6 N is the first force on the way
// back.
TEST(Checks, OnAWayAwayThatBeganInTheDarkTheFirstForceIsItsBegin) {
  WatchedFrame frame;
  Order m = pressing(1e-5);
  m.direction = -1;
  m.force_N = 0.5;
  m.force_known = false;
  frame.order(m);
  EXPECT_FALSE(frame.until_found(10, [](double s) {
    return Place(-1e-5 * s, std::max(0.0, 4.6 - s));
  })) << frame.found->why;
  frame.order(m);
  const auto rises = [](double s) { return Place(-1e-4 - 1e-5 * s, 4.6 + 0.1 * s); };
  const auto after = frame.until_found(10, rises);
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.4);
  EXPECT_EQ(frame.found->check->doubt, Doubt::drive);
  EXPECT_THAT(frame.found->why, HasSubstr("rises against the command"));
}

TEST(Checks, ASpecimenThatSticksMayLetGoOnTheWayAway) {
  WatchedFrame frame;
  Order m = pressing(1e-5);
  m.direction = -1;
  m.force_N = -0.1;
  m.zero_N = 0.012;
  const auto lets_go = [](double end_N) {
    return [end_N](double s) { return Place(-1e-5 * s, s < 3 ? -0.1 - 0.02 * s : end_N); };
  };
  frame.order(m);
  EXPECT_FALSE(frame.until_found(10, lets_go(0.012))) << frame.found->why;
  frame.order(m);
  const auto after =
      frame.until_found(10, [](double s) { return Place(-1e-4 - 1e-5 * s, s < 3 ? -0.1 : 0.06); });
  ASSERT_TRUE(after) << "it presses";
  EXPECT_NEAR(*after, 3, 0.1);
  EXPECT_EQ(frame.found->check->doubt, Doubt::drive);
}

// Its pull was taken for the force at rest.
TEST(Checks, ASpecimenThatPulledWhenTheCellWasReadMayLetGo) {
  const auto is_noticed = [](double begins_N, double end_N) {
    WatchedFrame frame;
    Order m = pressing(1e-5);
    m.direction = -1;
    m.force_N = begins_N;
    m.zero_N = -0.045;
    m.free_N = 0;
    frame.order(m);
    return frame
        .until_found(10, [=](double s) { return Place(-1e-5 * s, s < 3 ? begins_N : end_N); })
        .has_value();
  };
  EXPECT_FALSE(is_noticed(-0.045, 0));
  EXPECT_TRUE(is_noticed(-0.045, 0.05)) << "it presses";
  EXPECT_TRUE(is_noticed(0.5, 0.55)) << "a loaded specimen, and a drive that runs the wrong way";
}

TEST(Checks, AFrameThatCreepsOrSaysThatItMovesIsNotStanding) {
  WatchedFrame frame;
  frame.stand();
  const auto after = frame.until_found(30, [](double s) { return Place(1e-6 * s, 0.5); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 5.2);
  EXPECT_EQ(frame.found->check->doubt, Doubt::standstill);
  frame.stand();
  EXPECT_FALSE(frame.show(0, 0.5, frame_flag::kMoving)) << "of the motion that just ended";
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(frame.show(0, 0.5));
  EXPECT_FALSE(frame.show(0, 0.5, frame_flag::kMoving));
  EXPECT_TRUE(frame.show(0, 0.5, frame_flag::kMoving));
}

TEST(Checks, AForceThatJumpsWhileItStandsIsNotBelievedAndASpikeIsNone) {
  WatchedFrame frame;
  frame.stand();
  const auto spike = [](double s) { return Place(0, s > 5 && s < 5.11 ? 0.9 : 0.6); };
  EXPECT_FALSE(frame.until_found(10, spike));
  const auto after = frame.until_found(10, [](double s) { return Place(0, s < 3 ? 0.6 : 0.2); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 4.4);
  EXPECT_EQ(frame.found->check->doubt, Doubt::force);
}

TEST(Checks, AForceThatIsNotBelievedAnyMoreProvesNothing) {
  WatchedFrame frame;
  frame.apply(WatchInputEvent(WatchInput::force_invalid));
  frame.is_frozen = true;
  Order m = pressing(1e-4);
  m.direction = -1;
  frame.order(m);
  EXPECT_FALSE(frame.until_found(10, [](double s) { return Place(-1e-4 * s, 0.0); }));
}

// 60 % in a few seconds, and a creep that does not end. This is quick, but no jump.
TEST(Checks, ASpecimenThatRelaxesQuicklyHasNotJumped) {
  WatchedFrame frame;
  frame.stand();
  EXPECT_FALSE(frame.until_found(20, [](double s) {
    return Place(0, 0.2 + 0.6 * std::exp(-s / 1.5));
  })) << frame.found->why;
  frame.stand();
  EXPECT_FALSE(frame.until_found(8, [](double s) { return Place(0, 0.9 - 0.1 * s); }))
      << frame.found->why;
}

TEST(Checks, AServoThatGoesBeyondItsEndAndComesBackHasObeyed) {
  Tolerances f = round_tolerances();
  f.order_travel_m = 10e-6;
  const auto rings = [](double s) {
    return Place(s < 1 ? 1e-4 * s : 1e-4 - 5e-6 * (1 - std::exp(-(s - 1) / 0.1)), 0.0);
  };
  WatchedFrame frame(f);
  Order m = pressing(1e-4);
  m.target_m = 95e-6;
  frame.order(m);
  EXPECT_FALSE(frame.until_found(2, rings)) << frame.found->why;
  m.target_m = 300e-6;
  frame.order(m);
  EXPECT_TRUE(frame.until_found(2, rings)) << "far from its end it has not";
}

TEST(Checks, WhatTheFrameSaysOfItsPlaceIsHeldAgainstItsSamples) {
  Tolerances f = round_tolerances();
  f.order_travel_m = 10e-6;
  f.settled_s = 0.5;
  for (const double jump_m : {-50e-6, 50e-6}) {
    WatchedFrame stands(f);
    stands.stand(1e-3);
    const auto there = [jump_m](double) { return Place(1e-3 + jump_m, 0.5); };
    const auto after = stands.until_found(5, there);
    ASSERT_TRUE(after);
    EXPECT_LE(*after, 0.6);
    EXPECT_EQ(stands.found->check->doubt, Doubt::standstill);
    WatchedFrame moves(f);
    moves.stand(1e-3);
    moves.order(pressing(1e-5));
    EXPECT_TRUE(moves.until_found(
        0.1, [jump_m](double s) { return Place(1e-3 + jump_m + 1e-5 * s, 0.5); }));
  }
  WatchedFrame settles(f);
  settles.stand(1e-3);
  EXPECT_FALSE(settles.until_found(5, [](double s) {
    return Place(s < 0.3 ? 0.9e-3 : 1e-3 - 2e-6, 0.5);  // samples that come late while it settles
  }) && settles.found->why.find("said") != std::string::npos);
}

TEST(Checks, AForceThatFallsFarBelowItsOwnPeakIsNotBelieved) {
  WatchedFrame frame;
  frame.order(pressing(1e-5));
  const auto after =
      frame.until_found(30, [](double s) { return Place(1e-5 * s, s < 3 ? 0.2 * s : 0.04 * s); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 3.1);
  EXPECT_EQ(frame.found->check->doubt, Doubt::force);
}

TEST(Checks, AForceThatChangedItsSignIsNotOneThatIsPulled) {
  RigFacts facts = watched_facts();
  facts.limits.force_min_N = -0.2;
  facts.limits.force_max_N = 2;
  Tolerances tolerances = round_tolerances();
  WatchedFrame frame(tolerances, facts);
  const auto is_sign = [&](double travel_m, double force_N) {
    const auto found = frame.show(travel_m, force_N);
    return found && found->check->name == "sign_changed";
  };
  frame.stand();
  EXPECT_FALSE(is_sign(1e-3, 1));
  EXPECT_TRUE(is_sign(1e-3, -1));
  EXPECT_FALSE(is_sign(1e-3, -1.01)) << "it had that sign before";
  EXPECT_FALSE(is_sign(1e-3, 1));
  EXPECT_FALSE(is_sign(1e-3, -2.5)) << "a specimen may pull as hard as it likes";
  EXPECT_FALSE(is_sign(1e-3, 0.3));
  EXPECT_FALSE(is_sign(1e-3 - 10e-6, -0.3)) << "as far as the way explains";
}

// A frame that runs five times as fast as it was ordered is ahead of the corridor within 0.1 s.
TEST(Checks, AFrameThatIsFasterThanOrderedIsAheadOfTheOrder) {
  for (const double factor : {1.0, 5.0}) {
    WatchedFrame frame;
    frame.stand(1e-3);
    frame.order(pressing(1e-4));
    const auto after =
        frame.until_found(5, [factor](double s) { return Place(1e-3 + factor * 1e-4 * s, 0.0); });
    EXPECT_EQ(after.has_value(), factor > 1);
    if (!after) continue;
    EXPECT_EQ(frame.found->check->name, "ahead_of_order");
    EXPECT_LT(*after, 0.2);
  }
}

// The words of the table are unique, and every response has a doubt that explains it.
TEST(Checks, TheTableSaysWhatFollows) {
  std::set<std::string_view> names;
  for (const Check& check : all_checks()) {
    EXPECT_TRUE(names.insert(check.name).second) << check.name;
    EXPECT_NE(check.find == nullptr, check.find_by_clock == nullptr) << check.name;
    EXPECT_EQ(check.response == Response::lock_out, check.doubt == Doubt::drive) << check.name;
    EXPECT_EQ(check.response == Response::stop_and_retreat, check.doubt == Doubt::force)
        << check.name;
  }
}

}  // namespace
}  // namespace lcrig
