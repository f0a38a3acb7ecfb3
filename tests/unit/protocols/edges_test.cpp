// SPDX-License-Identifier: Apache-2.0
// Each edge of the corridors against its formula, in numbers where no term is zero.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "protocols/rig/constants.hpp"
#include "protocols/rig/corridor.hpp"
#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr double kEdgeStiffness_N_m = 100e3;

// A motion that began two seconds ago, of a cell whose zero is not 0 and drifts.
struct Moving {
  explicit Moving(double direction) {
    RigState& rig = frame.rig;
    rig.frame.motion = FrameMotion::moving;
    rig.frame.since = begin;
    rig.frame.order.direction = direction;
    rig.frame.order.speed_m_s = 1e-5;
    rig.frame.order.zero_N = 0.3;
    rig.frame.order.force_N = 0.4;
    rig.frame.order.against_N = 0.02;
    rig.frame.order.drift_N_s = 0.01;
    rig.facts.frame.travel_step = Length::from_si(2e-6);
  }
  RigState& rig() { return frame.rig; }
  // A contact at 1 mm with 0.05 N, in which the motion starts.
  void in_contact(double start_m) {
    rig().contact.travel_m = 1e-3;
    rig().contact.least.emplace(begin, 1e-3, 0.05, kEdgeStiffness_N_m);
    Course::Pressed& p = rig().course.pressed;
    p.start = begin;
    p.last = now;
    p.zero_N = 0.3;
    p.start_N = 0.1;
    set_base(p, *rig().contact.least, start_m, p.start_N);
  }

  WatchedFrame frame;
  MonoTime begin = frame.t, now = frame.t + 2s;
};

TEST(Edges, FromTheStartAndFromTheLargestForceOfAnApproach) {
  Moving m(1);
  EXPECT_NEAR(edge_from_start(m.rig(), m.now)->value(), 0.4 - 0.02 - 0.02, 1e-12);
  EXPECT_FALSE(edge_from_peak(m.rig(), m.now)) << "no force has come yet";
  m.rig().course.peak_N = 1.3;
  EXPECT_NEAR(edge_from_peak(m.rig(), m.now)->value(), 1.3 - 0.02 - 0.02 - 0.4 * (1.3 - 0.3),
              1e-12);
  EXPECT_NEAR(force_corridor(m.rig(), m.now, std::nullopt).lower->value(), 0.86, 1e-12)
      << "the higher one";
  EXPECT_FALSE(edge_of_retreat(m.rig(), m.now));
  m.rig().trust.force = false;
  EXPECT_FALSE(edge_from_start(m.rig(), m.now));
  EXPECT_FALSE(edge_from_peak(m.rig(), m.now));
}

TEST(Edges, OfARetreatIsTheLargestForceThatTheCellMayStillShow) {
  for (const auto& [force_N, free_N, least_N] : {std::tuple(0.4, std::optional(0.35), 0.4),
                                                 {0.1, std::optional(0.35), 0.35},
                                                 {0.1, std::optional(0.2), 0.3},
                                                 {0.1, std::optional<double>(), 0.3}}) {
    Moving m(-1);
    m.rig().frame.order.force_N = force_N;
    m.rig().frame.order.free_N = free_N;
    EXPECT_NEAR(edge_of_retreat(m.rig(), m.now)->value(), least_N + 0.02 + 0.02, 1e-12);
    EXPECT_FALSE(edge_from_start(m.rig(), m.now));
  }
}

TEST(Edges, OfTheTravelGrowWithTheOrderedSpeed) {
  for (const double direction : {1.0, -1.0}) {
    Moving m(direction);
    EXPECT_FALSE(edge_ahead(m.rig(), m.now)) << "nobody knows where it started";
    EXPECT_FALSE(edge_behind(m.rig()));
    m.rig().course.from_m = 5e-3;
    m.rig().course.furthest_m = direction * 5.01e-3;
    m.rig().tolerances.order_travel_m = 7e-6;
    m.rig().tolerances.against_m = 1e-6;
    const double step_m = 1.5 * 2e-6;
    EXPECT_NEAR(edge_ahead(m.rig(), m.now)->value(),
                5e-3 + direction * (1.2 * 1e-5 * (2 + 0.2) + 7e-6 + step_m), 1e-15);
    EXPECT_NEAR(edge_behind(m.rig())->value(), 5.01e-3 - direction * step_m, 1e-15);
    m.rig().course.runs_on_m = 4e-6;
    EXPECT_NEAR(edge_behind(m.rig())->value(), 5.01e-3 - direction * (step_m + 4e-6), 1e-15);
    m.rig().course.runs_on_m = 0;
    m.rig().tolerances.against_m = 9e-6;
    EXPECT_NEAR(edge_behind(m.rig())->value(), 5.01e-3 - direction * 9e-6, 1e-15);
    // A servo that passed its target may come back to it.
    m.rig().frame.order.target_m = 5.01e-3 - direction * 2e-6;
    EXPECT_NEAR(edge_behind(m.rig())->value(), 5.01e-3 - direction * 11e-6, 1e-15);
  }
}

TEST(Edges, OfAFrameThatStandsAreWhereItWasSeenToStand) {
  Moving m(1);
  m.rig().frame.motion = FrameMotion::standing;
  EXPECT_FALSE(travel_corridor(m.rig(), m.now).lower) << "no sample has shown it";
  m.rig().course.stood_m = 3e-3;
  m.rig().tolerances.standing_m = 5e-6;
  EXPECT_NEAR(travel_corridor(m.rig(), m.now).lower->value(), 3e-3 - 5e-6, 1e-15);
  EXPECT_NEAR(travel_corridor(m.rig(), m.now).upper->value(), 3e-3 + 5e-6, 1e-15);
}

TEST(Edges, InTheContactIsTheForceAtTheStartAndTheLeastRise) {
  for (const double start_m : {1e-3, 1.001e-3}) {
    Moving m(1);
    m.rig().tolerances.order_force_N = 0.01;
    m.rig().frame.order.loop_N = 0.003;
    m.in_contact(start_m);
    const double depth_m = 40e-6;
    const double from_m = start_m + 1e-6 + 1.5 * 2e-6;  // uncertain place, and steps of the travel
    const double elastic_N = kEdgeStiffness_N_m * (start_m + depth_m - from_m);
    const double near_N = 4 * 0.05 - kEdgeStiffness_N_m * (start_m - 1e-3);
    const double rise_N = 0.25 * near_N + 0.05 * (elastic_N - near_N);
    ASSERT_GE(near_N, 0);
    const auto edge = edge_in_contact(m.rig(), m.now, start_m + depth_m);
    ASSERT_TRUE(edge);
    EXPECT_NEAR(edge->value(), 0.3 + 0.1 * (1 - 0.3) + rise_N - 0.01 - 0.003 - 0.02, 1e-9);
    EXPECT_FALSE(edge_in_contact(m.rig(), m.now, from_m)) << "that may be where it started";
  }
}

TEST(Edges, InTheContactFollowARelaxationThatWasSeenHalfAsFastAgain) {
  const auto edge_N = [](std::optional<double> relaxes_N_s) {
    Moving m(1);
    m.in_contact(1e-3);
    m.rig().course.pressed.relaxes_N_s = relaxes_N_s;
    return edge_in_contact(m.rig(), m.now, 1.04e-3)->value();
  };
  EXPECT_NEAR(edge_N(0.004) - edge_N(std::nullopt), 0.3 * 0.1 - 1.5 * 0.004 * 2, 1e-12);
  EXPECT_NEAR(edge_N(1) - edge_N(std::nullopt), 0, 1e-12) << "never more than a third";
}

// The rig may have expanded since the contact was found, unless the motion starts deeper than that.
TEST(Edges, InTheContactAllowForExpansionUnlessItStartsUnderLoad) {
  for (const double start_m : {0.9e-3, 1e-3}) {
    Moving m(1);
    m.in_contact(start_m);
    EXPECT_EQ(m.rig().course.pressed.is_loaded, start_m == 1e-3);
    const MonoTime hours = m.now + 4h;  // 14.4 um
    const double from_m = 1e-3 + 4e-6;
    EXPECT_TRUE(is_in_contact(m.rig(), m.now, from_m + 1e-7));
    EXPECT_EQ(is_in_contact(m.rig(), hours, from_m + 13e-6), start_m == 1e-3);
    EXPECT_TRUE(is_in_contact(m.rig(), hours, from_m + 15e-6));
    EXPECT_TRUE(is_clear_of_contact(m.rig(), m.now, 1e-3 - 11e-6));
    EXPECT_FALSE(is_clear_of_contact(m.rig(), hours, 1e-3 - 11e-6));
    m.rig().contact.depth_m = 3e-6;
    EXPECT_FALSE(is_clear_of_contact(m.rig(), m.now, 1e-3 - 11e-6));
  }
}

TEST(Edges, SinceTheLargestForceCountTheWayBeyondWhatCrept) {
  Moving m(1);
  m.in_contact(1e-3);
  Course::Pressed& p = m.rig().course.pressed;
  p.best_N = 2;
  p.best_at = m.now - 1s;
  p.best_m = 1.03e-3;
  p.crept_m = 1e-6;
  m.rig().tolerances.order_force_N = 0.01;
  const double travel_m = 1.04e-3, relaxed_N = 0.3 * 0.1;
  const double edge_N =
      0.3 + 2 + 0.05 * kEdgeStiffness_N_m * (travel_m - 1e-6) - relaxed_N - 0.01 - 0.02;
  EXPECT_NEAR(edge_in_contact(m.rig(), m.now, travel_m)->value(), edge_N, 1e-9);
  // Half of the ordered speed since then; slower, the frame brakes and the force relaxes.
  p.best_m = travel_m - 0.4 * 1e-5;
  EXPECT_LT(edge_in_contact(m.rig(), m.now, travel_m)->value(), edge_N - 1);
}

// How far a search for a force may go: at once near, then far, from what the last motion left.
TEST(Edges, AForceIsReachedAtTheLatestWhereTheLeastStiffnessSays) {
  Moving m(1);
  m.rig().frame.motion = FrameMotion::standing;
  m.rig().tolerances.order_force_N = 0.01;
  m.rig().contact.travel_m = 1e-3;
  EXPECT_FALSE(furthest_m(m.rig(), m.now, 1)) << "no contact is known";
  m.rig().contact.least.emplace(m.now, 1e-3, 0.05, kEdgeStiffness_N_m);
  m.rig().contact.least->deepest_N = 0.2;
  const double tolerance_m = 1e-6 + 1.5 * 2e-6, near_N = 4 * 0.05;
  // From the air: a quarter of the force where it was deepest may return.
  m.rig().course.last_travel_m = 0.9e-3;
  const auto way_m = [&](double rise_N) {
    const double by_near_N = std::min(rise_N, 0.25 * near_N);
    return tolerance_m + by_near_N / 0.25 / kEdgeStiffness_N_m +
           (rise_N - by_near_N) / 0.05 / kEdgeStiffness_N_m;
  };
  EXPECT_NEAR(*furthest_m(m.rig(), m.now, 0.08), 1e-3 + way_m(0.08 + 0.01 - 0.05), 1e-12);
  EXPECT_NEAR(*furthest_m(m.rig(), m.now, 1), 1e-3 + way_m(1 + 0.01 - 0.05), 1e-12);
  EXPECT_NEAR(*furthest_m(m.rig(), m.now, 0.01), 1e-3 + tolerance_m, 1e-12)
      << "it shows it already";
  // Under load: from the force there, of which a third may relax.
  m.rig().course.last_travel_m = 1e-3;
  EXPECT_NEAR(*furthest_m(m.rig(), m.now, 1), 1e-3 + way_m(1 + 0.01 + 0.3 * 0.2 - 0.2), 1e-12);
}

TEST(Edges, SpecimensMayPullUnlessTheFrameApproaches) {
  for (const auto motion : {FrameMotion::unknown, FrameMotion::standing, FrameMotion::moving}) {
    for (const double direction : {-1.0, 0.0, 1.0}) {
      Moving m(direction);
      m.rig().frame.motion = motion;
      EXPECT_EQ(m.rig().may_pull(), motion != FrameMotion::moving || direction <= 0);
    }
  }
}

}  // namespace
}  // namespace lcrig
