// SPDX-License-Identifier: Apache-2.0
// What the state of a rig remembers of the course of the samples.
#include "protocols/rig/course.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// Shows samples as they are, without noise.
struct Followed : WatchedFrame {
  void see(std::optional<double> travel_m, std::optional<double> force_N, std::uint32_t flags = 0) {
    FrameSample s;
    s.received = t += 20ms;
    s.travel_m = travel_m;
    s.force_N = force_N;
    s.flags = flags;
    rig.apply(s);
  }
  void see_for(double seconds, double travel_m, double force_N) {
    for (double s = 0; s < seconds; s += 0.02) see(travel_m, force_N);
  }
  // A contact of 100 N/mm at 1 mm with 0.05 N.
  void place_contact() {
    rig.contact.travel_m = 1e-3;
    rig.contact.least.emplace(t, 1e-3, 0.05, 100e3);
  }
};

TEST(Course, TheLargestForceOfARunIsThatOfItsSteps) {
  Followed f;
  f.see(1e-3, 0.8);
  f.see(1e-3, 0.5);
  WatchInputEvent end(WatchInput::motion_end);
  end.force_N = 0.6;
  f.apply(end);
  EXPECT_DOUBLE_EQ(f.rig.course.peak_force_N, 0.8);
  end.force_N = 0.9;
  f.apply(end);
  EXPECT_DOUBLE_EQ(f.rig.course.peak_force_N, 0.9);
  f.apply(WatchInputEvent(WatchInput::retreat));
  f.see(1e-3, 1.5);
  f.apply(end);
  EXPECT_DOUBLE_EQ(f.rig.course.peak_force_N, 0.9) << "on the retreat it only falls";
  // ... unless the cell was overloaded: then nobody knows the largest force yet.
  f.see(1e-3, std::nullopt, frame_flag::kForceOverload);
  f.see(1e-3, 1.8);
  EXPECT_DOUBLE_EQ(f.rig.course.peak_force_N, 1.8);
  f.see(1e-3, 1.9);
  EXPECT_DOUBLE_EQ(f.rig.course.peak_force_N, 1.8);
}

TEST(Course, ASampleWithoutAForceSaysNothingOfIt) {
  for (const double direction : {-1.0, 0.0, 1.0}) {
    Followed f;
    f.place_contact();
    f.see(1.01e-3, 0.7);
    Order order = pressing(1e-5);
    order.direction = direction;
    order.to_N = 2;
    order.rate_N_s = 1;
    order.force_N = 0.7;
    f.order(order);
    f.see(1.011e-3, 0.7);
    const Course before = f.rig.course;
    const Contact::Least least = *f.rig.contact.least;
    for (int i = 0; i < 200; ++i) f.see(1.02e-3, std::nullopt);
    const Course& after = f.rig.course;
    EXPECT_EQ(f.rig.contact.least->deepest_m, least.deepest_m);
    EXPECT_EQ(f.rig.contact.least->deepest_N, least.deepest_N);
    EXPECT_EQ(after.pressed.best_N, before.pressed.best_N);
    EXPECT_EQ(after.idle, before.idle);
    EXPECT_EQ(after.loop.has_value(), before.loop.has_value());
    EXPECT_EQ(after.equal_forces, before.equal_forces);
  }
}

TEST(Course, TheDeepestTravelIsThatOfTheWholeRun) {
  Followed f;
  f.place_contact();
  f.order(pressing(1e-5));
  f.see(1.02e-3, 1.5);
  EXPECT_DOUBLE_EQ(f.rig.contact.least->deepest_m, 1.02e-3);
  f.stand();
  f.see(1.02e-3, 1.2);
  EXPECT_NEAR(f.rig.contact.least->deepest_N, 1.2, 1e-12) << "it relaxes there";
  f.see(1.0205e-3, 1.1);
  EXPECT_DOUBLE_EQ(f.rig.contact.least->deepest_m, 1.0205e-3);
  f.see(1.0201e-3, 1.0);
  EXPECT_DOUBLE_EQ(f.rig.contact.least->deepest_m, 1.0205e-3) << "within a micrometre of it";
  EXPECT_NEAR(f.rig.contact.least->deepest_N, 1.0, 1e-12);
  f.see(1.01e-3, 0.3);
  EXPECT_NEAR(f.rig.contact.least->deepest_N, 1.0, 1e-12) << "higher up the force is another one";
}

// What a motion under load counts from: the zero of the cell, or what it shows in the air.
TEST(Course, AMotionStartsFromTheForceBeyondTheZero) {
  for (const double travel_m : {0.9e-3, 1e-3}) {
    Followed f;
    f.place_contact();
    f.see(travel_m, 0.5);
    Order order = pressing(1e-5);
    order.force_N = 0.5;
    order.zero_N = 0.2;
    f.order(order);
    const bool in_air = travel_m < 1e-3;
    EXPECT_NEAR(f.rig.course.pressed.zero_N, in_air ? 0.5 : 0.2, 1e-12);
    EXPECT_NEAR(f.rig.course.pressed.start_N, in_air ? 0 : 0.3, 1e-12);
  }
}

// While the filter of the cell follows, a retreat may still show falling forces; an approach not.
TEST(Course, OnlyARetreatLeavesAForceThatStillFalls) {
  for (const double direction : {-1.0, 1.0}) {
    Followed f;
    Order order = pressing(1e-5);
    order.direction = direction;
    f.order(order);
    f.see(1e-3, 0.1);
    f.stand();
    EXPECT_EQ(f.rig.course.falls_until > f.t, direction < 0);
    Followed standing;
    standing.rig.frame.order.direction = direction;
    standing.stand();
    EXPECT_EQ(standing.rig.course.falls_until, MonoTime()) << "there was no motion";
  }
}

TEST(Course, AReportedPlaceIsComparedOnceEvenIfTheNextReportHasNone) {
  Followed f;
  f.order(pressing(1e-5));
  f.stand(2e-3);
  f.stand();
  EXPECT_EQ(f.rig.frame.reported_m, 2e-3) << "it stood already, and still does";
  f.order(pressing(1e-5));
  f.stand();
  EXPECT_FALSE(f.rig.frame.reported_m) << "it moved, and nobody says where it stands";
  // The allowance: the tolerance, the way since the order, and the step of the travel.
  Followed g;
  g.rig.facts.frame.travel_step = Length::from_si(2e-6);
  g.rig.tolerances.order_travel_m = 5e-6;
  g.stand(2e-3);
  g.order(pressing(1e-5));
  g.see(2e-3, 0.0);
  ASSERT_TRUE(g.rig.course.claim);
  EXPECT_NEAR(g.rig.course.claim->allowed_m, 5e-6 + 1.2 * 1e-5 * (0.02 + 0.2) + 1.5 * 2e-6, 1e-15);
  g.see(2e-3, 0.0);
  EXPECT_FALSE(g.rig.course.claim);
}

// The noise of a frame that hunts: about the force just before, not about zero.
TEST(Course, TheNoiseAtStandstillIsThatAboutTheForceItself) {
  Followed f;
  f.stand();
  for (int i = 0; i < 2000; ++i) f.see(1e-3, 5 + (i % 2 == 0 ? 0.01 : -0.01));
  EXPECT_NEAR(f.rig.standing_noise_N(), 0.01, 0.002);
}

TEST(Course, AJumpIsToldFromAStepOfTheTravel) {
  for (const bool shows_travel : {true, false}) {
    Followed f;
    f.stand();
    for (double s = 0; s < 4; s += 0.02) f.see(1e-3, 1.0);
    bool jumped = false;
    for (double s = 0; s < 2; s += 0.02) {
      f.see(shows_travel ? std::optional(1e-3) : std::nullopt, 1.5);
      if (const auto& jump = f.rig.course.jump) {
        jumped = true;
        EXPECT_FALSE(jump->moves);
        EXPECT_NEAR(jump->after_N - jump->before_N, 0.5, 1e-9);
      }
    }
    EXPECT_TRUE(jumped);
  }
}

TEST(Course, AJumpIsLookedForOnceAFrameHasStoodForAWhile) {
  // From 1.5 s after the stop on; the two intervals are a second apart.
  const auto first_s = [](double jump_s) {
    Followed f;
    f.stand();
    const MonoTime begin = f.t;
    for (double s = 0; s < 8; s += 0.02) {
      f.see(1e-3, s < jump_s ? 1.0 : 1.5);
      if (f.rig.course.jump) return to_seconds(f.t - begin);
    }
    return -1.0;
  };
  EXPECT_EQ(first_s(1.4), -1) << "it may be the end of the motion";
  EXPECT_NEAR(first_s(1.7), 2.6, 0.15);
  EXPECT_GT(first_s(4), 4);
}

// A force in the air is one of the cell, near contact it presses, and a drift explains some of it.
TEST(Course, AForceInTheAirDoesNotPress) {
  const auto best_N = [](double travel_m, double drift_N_s) {
    Followed f;
    f.place_contact();
    f.see(travel_m, 0.0);
    Order order = pressing(1e-5);
    order.drift_N_s = drift_N_s;
    order.against_N = 10;
    f.order(order);
    f.see_for(3, travel_m, 0.0);
    f.see(travel_m, 0.5);
    return f.rig.course.pressed.best_N;
  };
  EXPECT_FALSE(best_N(0.9e-3, 0));
  EXPECT_TRUE(best_N(0.995e-3, 0));
  EXPECT_FALSE(best_N(0.995e-3, 0.1)) << "0.3 N in three seconds, twice";
}

// A specimen creeps by 1 % of its indentation a second while it is pressed, and ten times as fast
// under a held force.
TEST(Course, TheForceBeyondTheLeastRiseCountsTheWayWithoutCreep) {
  for (const bool holds : {false, true}) {
    Followed f;
    f.place_contact();
    f.see(1.02e-3, 2.0);
    Order order = pressing(1e-5);
    order.direction = holds ? 0 : 1;
    order.holds = holds;
    order.force_N = 2;
    f.order(order);
    f.see(1.02e-3, 2.0);
    const double crept_m = (holds ? 0.1 : 0.01) * 2.0 / 100e3 * 0.02;
    EXPECT_NEAR(f.rig.course.pressed.crept_m, crept_m, 1e-15);
    ASSERT_TRUE(f.rig.course.pressed.best_N);
    EXPECT_NEAR(*f.rig.course.pressed.best_N, 2 - 0.05 * 100e3 * (1.02e-3 - crept_m), 1e-9);
  }
}

// Whether a frame that stands at 1 N and then shows another force counts as one that jumped.
bool jumps_from_1_N(double to_N, const Tolerances& tolerances) {
  Followed f;
  f.rig.tolerances = tolerances;
  f.stand();
  f.see_for(4, 1e-3, 1.0);
  bool jumped = false;
  for (double s = 0; s < 2; s += 0.02) {
    f.see(1e-3, to_N);
    jumped = jumped || f.rig.course.jump;
  }
  return jumped;
}

// A tenth of the force and the noise: no relaxation is as sudden.
TEST(Course, AJumpIsMoreThanATenthOfTheForce) {
  for (const double to_N : {1.08, 1.13}) {
    EXPECT_EQ(jumps_from_1_N(to_N, round_tolerances()), to_N > 1.1) << to_N;
  }
}

TEST(Course, ARelaxationIsObservedForHalfASecond) {
  Followed f;
  f.stand();
  f.see_for(0.7, 1e-3, 1.0);  // the first 0.3 s may belong to the motion
  EXPECT_FALSE(f.rig.relaxes_N_s());
  f.see_for(0.3, 1e-3, 1.0);
  ASSERT_TRUE(f.rig.relaxes_N_s());
  EXPECT_LT(*f.rig.relaxes_N_s(), 0.02);
}

// What a motion may take from the force, or give back, are parts of it.
TEST(Course, AnOrderAllowsForAPartOfTheForce) {
  const auto against_N = [](double direction, double force_N) {
    Followed f;
    f.see(1e-3, force_N);
    return f.rig.order_now(direction, 1e-5, 1e-3).against_N;
  };
  EXPECT_NEAR(against_N(1, 2) - against_N(1, 0), 0.3 * 2, 1e-9);
  EXPECT_NEAR(against_N(-1, 2) - against_N(-1, 0), 0.05 * 2, 1e-9);
  Followed f;
  const double zero_N = f.rig.zero_uncertainty_N();
  ASSERT_GT(zero_N, 0);
  EXPECT_NEAR(against_N(-1, 0), 0.02 * 20 + zero_N, 1e-9)
      << "a fiftieth of the limit does no harm, and the zero may err";
  // Pressing never makes a specimen pull, so it ends at the lower limit.
  f.rig.limits.force_min_N = -0.1;
  f.see(1e-3, 0.2);
  EXPECT_NEAR(f.rig.order_now(1, 1e-5, 1e-3).against_N, 0.3, 1e-9);
}

TEST(Course, TheFinestStepOfTheTravelIsItsResolution) {
  Followed f;
  for (const double travel_m : {1e-3, 1.004e-3, 1.006e-3, 1.010e-3}) f.see(travel_m, 0.0);
  EXPECT_NEAR(f.rig.travel_step_m(), 2e-6, 1e-12);
}

// Twice what a contact must show, where that is more than the end of a motion may be off by.
TEST(Course, AJumpIsMoreThanTwiceTheNoiseOfTheCell) {
  Tolerances noisy = round_tolerances();
  noisy.contact_force_N = 0.1;
  for (const double to_N : {1.25, 1.36}) {
    EXPECT_EQ(jumps_from_1_N(to_N, noisy), to_N > 1.34) << to_N;
  }
}

TEST(Course, ADepthIsAsSureAsPlaceStepAndNoiseOfTheTravel) {
  Followed f;
  f.rig.facts.frame.travel_step = Length::from_si(2e-6);
  f.rig.tolerances.travel_noise_m = 3e-6;
  EXPECT_NEAR(f.rig.travel_tolerance_m(), 1e-6 + 1.5 * 2e-6 + 5 * 3e-6, 1e-15);
}

// What a standing frame may wander by: its tolerance, or the finest step that was seen.
TEST(Course, AFrameStandsWithinItsToleranceOrAStepOfItsTravel) {
  Followed f;
  EXPECT_DOUBLE_EQ(f.rig.still_m(), f.rig.tolerances.against_m);
  EXPECT_DOUBLE_EQ(f.rig.standing_m(), f.rig.tolerances.standing_m);
  f.see(1e-3, 0.0);
  f.see(1e-3 + 8e-6, 0.0);
  EXPECT_NEAR(f.rig.still_m(), 12e-6, 1e-12);
  EXPECT_NEAR(f.rig.standing_m(), 12e-6, 1e-12);
  const RigState follows(watched_facts(), std::nullopt);
  EXPECT_DOUBLE_EQ(follows.still_m(), 10e-6) << "of a frame that others move nothing is known";
}

// Ordered out of a force loop, a frame first has to stop: 8 ms and v^2/2a at the speed of the loop,
// of which the last samples come up to 0.2 s later.
TEST(Course, AForceLoopThatIsInterruptedRunsOnUntilItStops) {
  FrameCapabilities caps = watched_capabilities();
  caps.force_loop.emplace();
  caps.force_loop->approach = Velocity::from_si(1e-3);
  const auto runs_on_m = [&](double direction, double rate_N_s, bool stood) {
    Followed f;
    f.rig.frame.caps = caps;
    f.place_contact();
    Order order = pressing(1e-5);
    order.direction = direction;
    order.rate_N_s = rate_N_s;
    f.order(order);
    if (stood) f.stand();
    order.direction = -1;
    f.order(order);
    return f.rig.course.runs_on_m;
  };
  EXPECT_EQ(runs_on_m(1, 0, false), 0);
  EXPECT_EQ(runs_on_m(0, 1, true), 0);
  EXPECT_NEAR(runs_on_m(0, 1, false), 1e-3 * (0.2 + 8e-3) + 1e-6 / 0.4, 1e-12);
  EXPECT_NEAR(runs_on_m(0, 200, false), 2e-3 * (0.2 + 8e-3) + 4e-6 / 0.4, 1e-12)
      << "0.2 kN/s at 0.1 N/um";
}

TEST(Course, TheUnloadedCellShowsAtMostWhatItShowedUntouched) {
  Cell cell;
  EXPECT_EQ(cell.unloaded_at_most_N(), 0);
  cell.untouched_N = 0.3;
  cell.zeros_under_load_N = 0.1;
  EXPECT_NEAR(cell.unloaded_N(), -0.1, 1e-12);
  EXPECT_NEAR(cell.unloaded_at_most_N(), 0.2, 1e-12) << "the zero took a part of it";
  cell.untouched_N = -0.5;
  EXPECT_NEAR(cell.unloaded_at_most_N(), -0.1, 1e-12);
}

}  // namespace
}  // namespace lcrig
