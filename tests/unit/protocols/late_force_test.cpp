// SPDX-License-Identifier: Apache-2.0
// A cell with a filter shows a force later than it acts: that is no contradiction.
#include <gtest/gtest.h>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

RigFacts with_filter(Duration filter) {
  FrameCapabilities caps = watched_capabilities();
  caps.filter = filter;
  return watched_facts(caps);
}

// At DONE the cell shows 1.065 N of the 1.32 N that press: its filter of 28 ms still follows. The
// way away begins at once, and the play of the drive takes its first micrometres.
struct FilteredCell {
  FilteredCell() {
    Order m = pressing(8e-4);
    m.worst_N = 1.4;
    frame.order(m);
    EXPECT_FALSE(frame.show(1e-3, 1.06));
    frame.stand(1e-3);
  }
  void move_away() {
    Order m = pressing(5e-5);
    m.direction = -1;
    m.force_N = 1.065;
    m.against_N = 0.1;
    frame.order(m);
  }
  std::optional<double> rises_to(double force_N) {
    return frame.until_found(5, [force_N](double s) {
      return Place(1e-3 - 5e-5 * s, force_N - (force_N - 1.065) * std::exp(-s / 0.028));
    });
  }
  WatchedFrame frame{round_tolerances(), with_filter(33ms)};
};

TEST(Checks, AForceThatACellWithAFilterShowsLateIsNoRiseOnTheWayAway) {
  FilteredCell cell;
  cell.move_away();
  EXPECT_FALSE(cell.rises_to(1.32)) << cell.frame.found->why;
}

TEST(Checks, AForceBeyondThePredictionRisesOnTheWayAwayWhateverTheFilter) {
  FilteredCell cell;
  cell.move_away();
  ASSERT_TRUE(cell.rises_to(1.6));
  EXPECT_EQ(cell.frame.found->check->doubt, Doubt::drive);
}

TEST(Checks, AForceThatRisesWhenTheFilterIsOverRisesOnTheWayAway) {
  FilteredCell cell;
  EXPECT_FALSE(cell.frame.until_found(0.4, [](double) { return Place(1e-3, 1.065); }));
  cell.move_away();
  ASSERT_TRUE(cell.rises_to(1.32));
  EXPECT_EQ(cell.frame.found->check->doubt, Doubt::drive);
}

// The next cycle begins at once: the cell still shows how the force fell on the way away.
class PressedAgain : public testing::Test {
 protected:
  PressedAgain() {
    Order away = pressing(5e-4);
    away.direction = -1;
    away.force_N = 0.6;
    frame.order(away);
    EXPECT_FALSE(frame.show(1e-3, 0.35));
    frame.stand(0.9e-3);
    EXPECT_FALSE(frame.show(0.9e-3, 0.31));
    Order m = pressing(1.5e-4);
    m.force_N = 0.31;
    m.free_N = -0.6;  // a zero that was taken under load has hidden 0.6 N
    m.against_N = 0.05;
    frame.order(m);
  }
  std::optional<double> falls_to(double force_N, double from_m = 0.9e-3) {
    return frame.until_found(2, [=](double s) {
      return Place(from_m + 1.5e-4 * s, force_N + (0.31 - force_N) * std::exp(-s / 0.1));
    });
  }
  WatchedFrame frame{round_tolerances(), with_filter(100ms)};
};

TEST_F(PressedAgain, AForceThatACellWithAFilterShowsLateIsNoFallWhileItPresses) {
  EXPECT_FALSE(falls_to(-0.6)) << frame.found->why;
}

TEST_F(PressedAgain, AForceBelowThatOfTheUnloadedCellIsNotBelieved) {
  ASSERT_TRUE(falls_to(-0.9));
  EXPECT_EQ(frame.found->check->doubt, Doubt::force);
}

TEST_F(PressedAgain, AForceThatFallsWhenTheFilterIsOverIsNotBelieved) {
  EXPECT_FALSE(frame.until_found(0.6, [](double s) { return Place(0.9e-3 + 1.5e-4 * s, 0.31); }));
  ASSERT_TRUE(falls_to(0, 1e-3));
  EXPECT_EQ(frame.found->check->doubt, Doubt::force);
}

TEST(Checks, AForceThatFellOnTheWayAwayHadBeenShown) {
  FilteredCell cell;
  cell.move_away();
  EXPECT_FALSE(cell.frame.show(1e-3 - 1e-6, 0.9));
  EXPECT_TRUE(cell.frame.show(1e-3 - 2e-6, 1.3));
}

}  // namespace
}  // namespace lcrig
