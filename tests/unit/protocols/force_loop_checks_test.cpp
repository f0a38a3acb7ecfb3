// SPDX-License-Identifier: Apache-2.0
// Checks of a frame that controls a force by itself.
#include <gtest/gtest.h>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

std::optional<double> noticed_in_force_loop(WatchedFrame& frame, double contact_m) {
  frame.rig.contact.travel_m = contact_m;
  frame.rig.contact.least.emplace(frame.t, contact_m, 0.1, 20e3);
  Order m = pressing(1e-5);
  m.direction = 0;
  m.rate_N_s = 0.1;
  m.force_N = 0.6;
  frame.order(m);
  return frame.until_found(
      5, [](double s) { return Place(1e-3 + 3e-5 * s, 0.6 + 1e-3 * std::sin(97 * s)); });
}

TEST(Checks, AForceLoopThatGoesOnWhileTheForceDoesNotFollowIsNoProgress) {
  WatchedFrame pressed, in_air;
  ASSERT_LT(noticed_in_force_loop(pressed, 0.97e-3).value_or(5), 4);
  EXPECT_EQ(pressed.found->check->doubt, Doubt::force) << "its travel is true";
  EXPECT_FALSE(noticed_in_force_loop(in_air, 2e-3)) << "after a zero that was taken under load";
}

// A force loop from 0.6 N to another force, at 0.1 N/s. The frame moves by `way_m_s`, and the cell
// shows what a contact of 10 N/mm does then.
std::optional<std::string_view> found_in_loop(double to_N, double way_m_s, bool holds = false) {
  WatchedFrame frame;
  Order m;
  m.speed_m_s = 1e-4;
  m.rate_N_s = holds ? 0 : 0.1;
  m.force_N = 0.6;
  m.to_N = to_N;
  m.against_N = 0.02;
  m.holds = holds;
  frame.order(m);
  const auto after = frame.until_found(
      3, [way_m_s](double s) { return Place(1e-3 + way_m_s * s, 0.6 + 1e4 * way_m_s * s); });
  return after ? std::optional(frame.found->check->name) : std::nullopt;
}

TEST(Checks, AForceLoopThatRunsAwayFromItsSetPointIsFoundInEitherDirection) {
  EXPECT_EQ(found_in_loop(1, -1e-5), "loop_runs_away");
  EXPECT_EQ(found_in_loop(0.2, 1e-5), "loop_runs_away");
  EXPECT_EQ(found_in_loop(1, -1e-5, true), "loop_runs_away");
  EXPECT_FALSE(found_in_loop(1, 1e-5)) << "as ordered";
  EXPECT_FALSE(found_in_loop(0.2, -1e-5)) << "as ordered";
  EXPECT_FALSE(found_in_loop(0.6, 1e-7, true)) << "it holds, and hunts a little";
}

// Whether the cell or the drive does nothing, nobody can tell: a retreat shows it.
TEST(Checks, AForceLoopThatStandsLeavesTheRetreatOpen) {
  EXPECT_EQ(found_in_loop(1, 0), "loop_without_force");
}

}  // namespace
}  // namespace lcrig
