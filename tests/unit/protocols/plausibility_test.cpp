// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/plausibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

WatchFigures round_figures() {
  WatchFigures f;
  f.frozen_samples = 10;
  f.stall_s = 2;
  f.against_m = 3e-6;
  f.standing_m = 5e-6;
  f.order_force_N = 0.01;
  f.contact_force_N = 5e-3;
  return f;
}

// Fifty samples per second of a cell that scatters by 1 mN and a travel that shows nanometres.
class FakeFrame {
 public:
  explicit FakeFrame(WatchFigures figures = round_figures()) : eyes(figures) {}
  std::optional<Contradiction> show(double travel_m, double force_N, std::uint32_t flags = 0) {
    FrameSample s;
    t += 20ms;
    s.received = t;
    s.travel_m = travel_m;
    s.force_N = is_frozen ? 0.5 : std::round((force_N + noise_(random_)) * 1e5) / 1e5;
    s.flags = flags;
    return eyes.check(s);
  }
  // Seconds until something is noticed. nullopt: not within `most_s`.
  template <class At>
  std::optional<double> until_noticed(double most_s, At at) {
    const MonoTime begin = t;
    while (to_seconds(t - begin) < most_s) {
      const auto [travel_m, force_N] = at(to_seconds(t - begin) + 0.02);
      found = show(travel_m, force_N);
      if (found) return to_seconds(t - begin);
    }
    return std::nullopt;
  }

  Plausibility eyes;
  MonoTime t = MonoTime() + 100s;
  bool is_frozen = false;
  std::optional<Contradiction> found;

 private:
  std::mt19937 random_{7};
  std::normal_distribution<double> noise_{0, 1e-3};
};

using Place = std::pair<double, double>;

Plausibility::Motion pressing(double speed_m_s) {
  Plausibility::Motion m;
  m.direction = 1;
  m.speed_m_s = speed_m_s;
  m.against_N = 0.02;
  return m;
}

TEST(Plausibility, NothingIsSaidOfAFrameThatDoesWhatItIsTold) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-4), frame.t);
  EXPECT_FALSE(frame.until_noticed(60, [](double s) { return Place(1e-4 * s, 0.01 * s); }));
  frame.eyes.stand(frame.t);
  EXPECT_FALSE(frame.until_noticed(600, [](double s) {  // the force relaxes by a third
    return Place(6e-3, 0.6 * (0.67 + 0.33 * std::exp(-s / 10)));
  })) << frame.found->why;
}

TEST(Plausibility, DigitsThatNeverChangeAreAFrozenCell) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-4), frame.t);
  EXPECT_FALSE(frame.until_noticed(1, [](double s) { return Place(1e-4 * s, 0.0); }));
  frame.is_frozen = true;
  const auto after = frame.until_noticed(5, [](double s) { return Place(1e-4 * (1 + s), 0.0); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.24);
  EXPECT_EQ(frame.found->disbelief, Disbelief::force);
}

TEST(Plausibility, CoarseDigitsRepeatHonestly) {
  WatchFigures coarse = round_figures();
  coarse.frozen_samples.reset();
  FakeFrame frame(coarse);
  frame.is_frozen = true;
  frame.eyes.begin(pressing(1e-4), frame.t);
  EXPECT_FALSE(frame.until_noticed(60, [](double s) { return Place(1e-4 * s, 0.0); }));
}

TEST(Plausibility, ADriveThatRunsTheWrongWayIsNoticedWithinItsWay) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-4), frame.t);
  const auto after = frame.until_noticed(5, [](double s) { return Place(-1e-4 * s, 0.0); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 3e-6 / 1e-4 + 0.05);
  EXPECT_EQ(frame.found->disbelief, Disbelief::drive);
  EXPECT_THAT(frame.found->why, HasSubstr("against the command"));
}

TEST(Plausibility, ADriveThatStallsIsNoticedInTwoSeconds) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-4), frame.t);
  const auto after =
      frame.until_noticed(30, [](double s) { return Place(1e-4 * std::min(s, 5.0), 0.01); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 5 + 2.6);
  EXPECT_GE(*after, 5 + 2);
  EXPECT_EQ(frame.found->disbelief, Disbelief::drive);
  EXPECT_THAT(frame.found->why, HasSubstr("where 0.1 mm/s were ordered"));
}

// A tenth of a micrometre per second, shown in micrometres: the value changes every ten seconds.
TEST(Plausibility, TheSlowestSpeedOfACoarseTravelIsNoStall) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-7), frame.t);
  EXPECT_FALSE(frame.until_noticed(300, [](double s) {
    return Place(std::floor(1e-7 * s / 1e-6) * 1e-6, 0.0);
  })) << frame.found->why;
}

// Until the first motion nobody knows the digit: the travel of a frame that stands shows none.
TEST(Plausibility, TheFirstSlowMotionOfACoarseTravelIsNoStall) {
  for (const double digit_m : {2e-6, 5e-6, 10e-6, 12e-6, 20e-6}) {
    for (const double speed_m_s : {0.1e-6, 0.92e-6, 5e-6}) {
      for (const double part : {0.01, 0.5, 0.99}) {  // of the first digit that is behind it
        FakeFrame frame;
        frame.eyes.begin(pressing(speed_m_s), frame.t);
        EXPECT_FALSE(frame.until_noticed(
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
TEST(Plausibility, ADriveThatStallsBeforeItsDigitIsKnownIsNoticedAfterThreeOfTheCoarsest) {
  for (const double speed_m_s : {0.92e-6, 5e-6, 1e-4, 1e-3}) {
    FakeFrame frame;
    frame.eyes.begin(pressing(speed_m_s), frame.t);
    const auto after = frame.until_noticed(200, [](double) { return Place(0.0, 0.0); });
    ASSERT_TRUE(after) << speed_m_s;
    EXPECT_LE(*after, 1.01 * std::max(2.0, 36e-6 / speed_m_s) + 0.1) << speed_m_s;
    EXPECT_EQ(frame.found->disbelief, Disbelief::drive);
  }
}

// In a fast approach with few samples per second no two travels are near each other.
TEST(Plausibility, TheWayBetweenTwoSamplesIsNoDigit) {
  FakeFrame frame;
  frame.eyes.begin(pressing(0.02), frame.t);
  EXPECT_FALSE(frame.until_noticed(1, [](double s) { return Place(0.02 * s, 0.0); }));
  frame.eyes.begin(pressing(1e-5), frame.t);
  const auto after = frame.until_noticed(30, [](double s) { return Place(0.02 - 1e-5 * s, 0.0); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.4);
}

TEST(Plausibility, AForceThatFallsWhileItPressesIsNotBelieved) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-5), frame.t);
  const auto after =
      frame.until_noticed(30, [](double s) { return Place(1e-5 * s, s < 3 ? 0 : -0.1 * (s - 3)); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 3.3);
  EXPECT_EQ(frame.found->disbelief, Disbelief::force);
}

TEST(Plausibility, AForceThatRisesOnTheWayAwayStopsTheDrive) {
  FakeFrame frame;
  Plausibility::Motion m = pressing(1e-5);
  m.direction = -1;
  m.force_N = 0.5;
  frame.eyes.begin(m, frame.t);
  const auto after =
      frame.until_noticed(30, [](double s) { return Place(-1e-5 * s, 0.5 + 0.1 * s); });
  ASSERT_TRUE(after);
  EXPECT_EQ(frame.found->disbelief, Disbelief::drive);
}

// At DONE the cell shows 1.065 N of the 1.32 N that press: its filter of 28 ms still follows. The
// way away begins at once, and the play of the drive takes its first micrometres.
struct FilteredCell {
  FilteredCell() {
    Plausibility::Motion m = pressing(8e-4);
    m.worst_N = 1.4;
    m.shown_after = 300ms;
    frame.eyes.begin(m, frame.t);
    EXPECT_FALSE(frame.show(1e-3, 1.06));
    frame.eyes.stand(frame.t, 1e-3);
  }
  void move_away() {
    Plausibility::Motion m = pressing(5e-5);
    m.direction = -1;
    m.force_N = 1.065;
    m.against_N = 0.1;
    frame.eyes.begin(m, frame.t);
  }
  std::optional<double> rises_to(double force_N) {
    return frame.until_noticed(5, [force_N](double s) {
      return Place(1e-3 - 5e-5 * s, force_N - (force_N - 1.065) * std::exp(-s / 0.028));
    });
  }
  FakeFrame frame;
};

TEST(Plausibility, AForceThatACellWithAFilterShowsLateIsNoRiseOnTheWayAway) {
  FilteredCell cell;
  cell.move_away();
  EXPECT_FALSE(cell.rises_to(1.32)) << cell.frame.found->why;
}

TEST(Plausibility, AForceBeyondThePredictionRisesOnTheWayAwayWhateverTheFilter) {
  FilteredCell cell;
  cell.move_away();
  ASSERT_TRUE(cell.rises_to(1.6));
  EXPECT_EQ(cell.frame.found->disbelief, Disbelief::drive);
}

TEST(Plausibility, AForceThatRisesWhenTheFilterIsOverRisesOnTheWayAway) {
  FilteredCell cell;
  EXPECT_FALSE(cell.frame.until_noticed(0.4, [](double) { return Place(1e-3, 1.065); }));
  cell.move_away();
  ASSERT_TRUE(cell.rises_to(1.32));
  EXPECT_EQ(cell.frame.found->disbelief, Disbelief::drive);
}

// The next cycle begins at once: the cell still shows how the force fell on the way away.
class PressedAgain : public testing::Test {
 protected:
  PressedAgain() {
    Plausibility::Motion away = pressing(5e-4);
    away.direction = -1;
    away.force_N = 0.6;
    away.shown_after = 500ms;
    frame.eyes.begin(away, frame.t);
    EXPECT_FALSE(frame.show(1e-3, 0.35));
    frame.eyes.stand(frame.t, 0.9e-3);
    EXPECT_FALSE(frame.show(0.9e-3, 0.31));
    Plausibility::Motion m = pressing(1.5e-4);
    m.force_N = 0.31;
    m.free_N = -0.6;  // a zero that was taken under load has hidden 0.6 N
    m.against_N = 0.05;
    frame.eyes.begin(m, frame.t);
  }
  std::optional<double> falls_to(double force_N, double from_m = 0.9e-3) {
    return frame.until_noticed(2, [=](double s) {
      return Place(from_m + 1.5e-4 * s, force_N + (0.31 - force_N) * std::exp(-s / 0.1));
    });
  }
  FakeFrame frame;
};

TEST_F(PressedAgain, AForceThatACellWithAFilterShowsLateIsNoFallWhileItPresses) {
  EXPECT_FALSE(falls_to(-0.6)) << frame.found->why;
}

TEST_F(PressedAgain, AForceBelowThatOfTheUnloadedCellIsNotBelieved) {
  ASSERT_TRUE(falls_to(-0.9));
  EXPECT_EQ(frame.found->disbelief, Disbelief::force);
}

TEST_F(PressedAgain, AForceThatFallsWhenTheFilterIsOverIsNotBelieved) {
  EXPECT_FALSE(frame.until_noticed(0.6, [](double s) { return Place(0.9e-3 + 1.5e-4 * s, 0.31); }));
  ASSERT_TRUE(falls_to(0, 1e-3));
  EXPECT_EQ(frame.found->disbelief, Disbelief::force);
}

std::optional<double> noticed_in_force_loop(FakeFrame& frame, double contact_m) {
  frame.eyes.press().know(frame.t, contact_m, 0.1, 20e3);
  Plausibility::Motion m = pressing(1e-5);
  m.direction = 0;
  m.rate_N_s = 0.1;
  m.force_N = 0.6;
  frame.eyes.begin(m, frame.t);
  return frame.until_noticed(
      5, [](double s) { return Place(1e-3 + 3e-5 * s, 0.6 + 1e-3 * std::sin(97 * s)); });
}

TEST(Plausibility, AForceLoopThatGoesOnWhileTheForceDoesNotFollowIsNoProgress) {
  FakeFrame pressed, in_air;
  ASSERT_LT(noticed_in_force_loop(pressed, 0.97e-3).value_or(5), 4);
  EXPECT_EQ(pressed.found->disbelief, Disbelief::force) << "its travel is true";
  EXPECT_FALSE(noticed_in_force_loop(in_air, 2e-3)) << "after a zero that was taken under load";
}

TEST(Plausibility, AForceThatFellOnTheWayAwayHadBeenShown) {
  FilteredCell cell;
  cell.move_away();
  EXPECT_FALSE(cell.frame.show(1e-3 - 1e-6, 0.9));
  EXPECT_TRUE(cell.frame.show(1e-3 - 2e-6, 1.3));
}

// After an overload of the cell: 0.5 N was shown before it, and 4.6 N is the first force on the way
// back.
TEST(Plausibility, OnAWayAwayThatBeganInTheDarkTheFirstForceIsItsBegin) {
  FakeFrame frame;
  Plausibility::Motion m = pressing(1e-5);
  m.direction = -1;
  m.force_N = 0.5;
  m.force_known = false;
  frame.eyes.begin(m, frame.t);
  EXPECT_FALSE(frame.until_noticed(10, [](double s) {
    return Place(-1e-5 * s, std::max(0.0, 4.6 - s));
  })) << frame.found->why;
  frame.eyes.begin(m, frame.t);
  const auto rises = [](double s) { return Place(-1e-4 - 1e-5 * s, 4.6 + 0.1 * s); };
  const auto after = frame.until_noticed(10, rises);
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.4);
  EXPECT_EQ(frame.found->disbelief, Disbelief::drive);
  EXPECT_THAT(frame.found->why, HasSubstr("rises against the command"));
}

TEST(Plausibility, ASpecimenThatSticksMayLetGoOnTheWayAway) {
  FakeFrame frame;
  Plausibility::Motion m = pressing(1e-5);
  m.direction = -1;
  m.force_N = -0.1;
  m.rest_N = 0.012;
  const auto lets_go = [](double end_N) {
    return [end_N](double s) { return Place(-1e-5 * s, s < 3 ? -0.1 - 0.02 * s : end_N); };
  };
  frame.eyes.begin(m, frame.t);
  EXPECT_FALSE(frame.until_noticed(10, lets_go(0.012))) << frame.found->why;
  frame.eyes.begin(m, frame.t);
  const auto after = frame.until_noticed(
      10, [](double s) { return Place(-1e-4 - 1e-5 * s, s < 3 ? -0.1 : 0.06); });
  ASSERT_TRUE(after) << "it presses";
  EXPECT_NEAR(*after, 3, 0.1);
  EXPECT_EQ(frame.found->disbelief, Disbelief::drive);
}

// Its pull was taken for the force at rest.
TEST(Plausibility, ASpecimenThatPulledWhenTheCellWasReadMayLetGo) {
  const auto is_noticed = [](double begins_N, double end_N) {
    FakeFrame frame;
    Plausibility::Motion m = pressing(1e-5);
    m.direction = -1;
    m.force_N = begins_N;
    m.rest_N = -0.045;
    m.free_N = 0;
    frame.eyes.begin(m, frame.t);
    return frame
        .until_noticed(10, [=](double s) { return Place(-1e-5 * s, s < 3 ? begins_N : end_N); })
        .has_value();
  };
  EXPECT_FALSE(is_noticed(-0.045, 0));
  EXPECT_TRUE(is_noticed(-0.045, 0.05)) << "it presses";
  EXPECT_TRUE(is_noticed(0.5, 0.55)) << "a loaded specimen, and a drive that runs the wrong way";
}

TEST(Plausibility, AFrameThatCreepsOrSaysThatItMovesIsNotStanding) {
  FakeFrame frame;
  frame.eyes.stand(frame.t);
  const auto after = frame.until_noticed(30, [](double s) { return Place(1e-6 * s, 0.5); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 5.2);
  EXPECT_EQ(frame.found->disbelief, Disbelief::stillness);
  frame.eyes.stand(frame.t);
  EXPECT_FALSE(frame.show(0, 0.5, frame_flag::kMoving)) << "of the motion that just ended";
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(frame.show(0, 0.5));
  EXPECT_FALSE(frame.show(0, 0.5, frame_flag::kMoving));
  EXPECT_TRUE(frame.show(0, 0.5, frame_flag::kMoving));
}

TEST(Plausibility, AForceThatJumpsWhileItStandsIsNotBelievedAndASpikeIsNone) {
  FakeFrame frame;
  frame.eyes.stand(frame.t);
  const auto spike = [](double s) { return Place(0, s > 5 && s < 5.11 ? 0.9 : 0.6); };
  EXPECT_FALSE(frame.until_noticed(10, spike));
  const auto after = frame.until_noticed(10, [](double s) { return Place(0, s < 3 ? 0.6 : 0.2); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 4.4);
  EXPECT_EQ(frame.found->disbelief, Disbelief::force);
}

TEST(Plausibility, AForceThatIsNotBelievedAnyMoreProvesNothing) {
  FakeFrame frame;
  frame.eyes.distrust_force();
  frame.is_frozen = true;
  Plausibility::Motion m = pressing(1e-4);
  m.direction = -1;
  frame.eyes.begin(m, frame.t);
  EXPECT_FALSE(frame.until_noticed(10, [](double s) { return Place(-1e-4 * s, 0.0); }));
}

// 60 % in a few seconds, and a creep that does not end. This is quick, but no jump.
TEST(Plausibility, ASpecimenThatRelaxesQuicklyHasNotJumped) {
  FakeFrame frame;
  frame.eyes.stand(frame.t);
  EXPECT_FALSE(frame.until_noticed(20, [](double s) {
    return Place(0, 0.2 + 0.6 * std::exp(-s / 1.5));
  })) << frame.found->why;
  frame.eyes.stand(frame.t);
  EXPECT_FALSE(frame.until_noticed(8, [](double s) { return Place(0, 0.9 - 0.1 * s); }))
      << frame.found->why;
}

TEST(Plausibility, AServoThatGoesBeyondItsEndAndComesBackHasObeyed) {
  WatchFigures f = round_figures();
  f.order_travel_m = 10e-6;
  const auto rings = [](double s) {
    return Place(s < 1 ? 1e-4 * s : 1e-4 - 5e-6 * (1 - std::exp(-(s - 1) / 0.1)), 0.0);
  };
  FakeFrame frame(f);
  Plausibility::Motion m = pressing(1e-4);
  m.target_m = 95e-6;
  frame.eyes.begin(m, frame.t);
  EXPECT_FALSE(frame.until_noticed(2, rings)) << frame.found->why;
  m.target_m = 300e-6;
  frame.eyes.begin(m, frame.t);
  EXPECT_TRUE(frame.until_noticed(2, rings)) << "far from its end it has not";
}

TEST(Plausibility, WhatTheFrameSaysOfItsPlaceIsHeldAgainstItsSamples) {
  WatchFigures f = round_figures();
  f.order_travel_m = 10e-6;
  f.settled_s = 0.5;
  for (const double jump_m : {-50e-6, 50e-6}) {
    FakeFrame stands(f);
    stands.eyes.stand(stands.t, 1e-3);
    const auto there = [jump_m](double) { return Place(1e-3 + jump_m, 0.5); };
    const auto after = stands.until_noticed(5, there);
    ASSERT_TRUE(after);
    EXPECT_LE(*after, 0.6);
    EXPECT_EQ(stands.found->disbelief, Disbelief::stillness);
    FakeFrame moves(f);
    moves.eyes.stand(moves.t, 1e-3);
    moves.eyes.begin(pressing(1e-5), moves.t);
    EXPECT_TRUE(moves.until_noticed(
        0.1, [jump_m](double s) { return Place(1e-3 + jump_m + 1e-5 * s, 0.5); }));
  }
  FakeFrame settles(f);
  settles.eyes.stand(settles.t, 1e-3);
  EXPECT_FALSE(settles.until_noticed(5, [](double s) {
    return Place(s < 0.3 ? 0.9e-3 : 1e-3 - 2e-6, 0.5);  // samples that come late while it settles
  }) && settles.found->why.find("said") != std::string::npos);
}

TEST(Plausibility, AForceThatFallsFarBelowItsOwnPeakIsNotBelieved) {
  FakeFrame frame;
  frame.eyes.begin(pressing(1e-5), frame.t);
  const auto after =
      frame.until_noticed(30, [](double s) { return Place(1e-5 * s, s < 3 ? 0.2 * s : 0.04 * s); });
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 3.1);
  EXPECT_EQ(frame.found->disbelief, Disbelief::force);
}

TEST(Plausibility, TellsAForceThatChangedItsSignFromOneThatIsPulled) {
  FakeFrame frame;
  frame.eyes.stand(frame.t);
  frame.show(1e-3, 1);
  frame.show(1e-3, -1);
  EXPECT_TRUE(frame.eyes.changed_sign(100e3));
  frame.show(1e-3, -1.01);
  EXPECT_FALSE(frame.eyes.changed_sign(100e3)) << "it had that sign before";
  frame.show(1e-3, 1);
  frame.show(1e-3, -2.5);
  EXPECT_FALSE(frame.eyes.changed_sign(100e3)) << "a specimen may pull as hard as it likes";
  frame.show(1e-3, 0.3);
  frame.show(1e-3 - 10e-6, -0.3);
  EXPECT_FALSE(frame.eyes.changed_sign(100e3)) << "as far as the way explains";
}

}  // namespace
}  // namespace lcrig
