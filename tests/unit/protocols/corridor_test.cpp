// SPDX-License-Identifier: Apache-2.0
// Specimens of several kinds, pressed by independent arithmetic, and cells that show no force.
#include "protocols/rig/corridor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr double kPressStiffness_N_m = 100e3;

// A contact of 100 N/mm that was found at 1 mm with 0.05 N.
// A motion of a frame that is not stopped by anything else than the corridor in the contact.
struct Pressed {
  Pressed() {
    frame.rig.contact.travel_m = 1e-3;
    frame.rig.contact.least.emplace(frame.t, 1e-3, 0.05, kPressStiffness_N_m);
  }
  // Stands and relaxes as long as it takes to see how fast, if a rate is given.
  void start(double felt_N, std::optional<double> relaxes_N_s = std::nullopt, bool holds = false,
             double speed_m_s = 0) {
    frame.stand();
    if (relaxes_N_s) {
      for (double s = 0; s < 5; s += 0.02) step(*frame.rig.course.last_travel_m, felt_N);
    }
    Order m;
    m.direction = holds ? 0 : 1;
    m.speed_m_s = speed_m_s;
    m.force_N = felt_N;
    m.against_N = 1e3;  // nothing but the depth counts
    m.holds = holds;
    frame.order(m);
    if (relaxes_N_s) frame.rig.course.pressed.relaxes_N_s = relaxes_N_s;
  }
  void step(double travel_m, double force_N) {
    FrameSample s;
    frame.t += 20ms;
    s.received = frame.t;
    s.travel_m = travel_m;
    s.force_N = force_N;
    const auto compared = frame.rig.apply(s);
    for (const Finding& f : find(frame.rig, Sight{s, compared})) {
      if (f.check->name == "force_too_small") why = f.why;
    }
  }
  // Presses from `from_m` beyond contact at this speed. `shown` gives the force for depth and
  // seconds. Returns the depth at which something was found.
  std::optional<double> press(double from_m, double to_m, double speed_m_s,
                              const std::function<double(double, double)>& shown) {
    why.reset();
    for (double s = 0; from_m + speed_m_s * s <= to_m; s += 0.02) {
      depth_m = from_m + speed_m_s * s;
      step(1e-3 + depth_m, shown(depth_m, s));
      if (why) return depth_m;
    }
    return std::nullopt;
  }
  void rest(double travel_m, double felt_N) {
    frame.stand();
    step(travel_m, felt_N);
  }

  WatchedFrame frame;
  double depth_m = 0;
  std::optional<std::string> why;
};

double linear(double depth_m, double /*s*/) {
  return std::max(0.0, kPressStiffness_N_m * (depth_m + 0.5e-6));
}

TEST(Corridor, BelievesSpecimensThatPushBack) {
  const std::vector<std::function<double(double, double)>> specimens{
      linear,
      [](double x, double) { return linear(x, 0) * (1 + 2e4 * std::max(x, 0.0)); },  // stiffens
      // a foam: elastic up to 0.4 N, then a tenth as stiff
      [](double x, double) {
        const double f = linear(x, 0);
        return f < 0.4 ? f : 0.4 + 0.1 * (f - 0.4);
      },
      // two thirds relax at once
      [](double x, double) { return linear(x, 0) / 3; },
  };
  for (const auto& specimen : specimens) {
    for (const double speed : {1e-6, 1e-5, 1e-4}) {
      Pressed p;
      p.start(0);
      EXPECT_FALSE(p.press(-10e-6, 100e-6, speed, specimen)) << p.why.value_or("");
      // ... and again, after the probe stood still and lost a third of its force.
      const double felt_N = specimen(100e-6, 0) * 0.67;
      p.rest(1.1e-3, felt_N);
      p.start(felt_N);
      EXPECT_FALSE(p.press(100e-6, 200e-6, speed, [&](double x, double s) {
        return 0.67 * specimen(x, s);
      })) << p.why.value_or("");
    }
  }
}

TEST(Corridor, ACellThatScattersAboutOneForceIsNoticedInTenthsOfANewton) {
  for (const double frozen_N : {0.0, 0.02, 0.3, 0.8}) {  // before contact, and after it
    Pressed p;
    p.start(0);
    const auto depth = p.press(-10e-6, 5e-3, 1e-5,
                               [&](double x, double) { return std::min(frozen_N, linear(x, 0)); });
    ASSERT_TRUE(depth);
    EXPECT_LT(linear(*depth, 0), frozen_N + 0.4);
    EXPECT_THAT(*p.why, HasSubstr("does not follow the way into the specimen"));
  }
}

TEST(Corridor, WhatIsSeenToRelaxSlowlyIsWatchedMoreClosely) {
  const auto frozen = [](double, double) { return 0.5; };
  const auto pressed_N = [&](std::optional<double> relaxes_N_s) {
    Pressed p;
    p.start(0);
    EXPECT_FALSE(p.press(-10e-6, 4.5e-6, 1e-5, linear));
    p.rest(1e-3 + 4.5e-6, 0.5);
    p.start(0.5, relaxes_N_s);
    return linear(p.press(4.5e-6, 5e-3, 1e-5, frozen).value_or(1), 0);
  };
  EXPECT_LT(pressed_N(1e-3), 1.2);
  EXPECT_GT(pressed_N(std::nullopt), 2);
  EXPECT_LT(pressed_N(std::nullopt), 5);
}

TEST(Corridor, AGainThatFellToATenthIsNoticedNearContact) {
  Pressed p;
  p.start(0);
  const auto depth =
      p.press(-10e-6, 5e-3, 1e-5, [](double x, double) { return 0.1 * linear(x, 0); });
  ASSERT_TRUE(depth);
  EXPECT_LT(linear(*depth, 0), 0.5);
}

// A hundred micrometres in an hour under a held force: the frame only follows the specimen.
TEST(Corridor, AForceThatIsHeldMayCreep) {
  Pressed p;
  p.step(1e-3 + 4.5e-6, 0.5);
  p.start(0.5, 1e-3, true);
  EXPECT_FALSE(p.press(4.5e-6, 105e-6, 100e-6 / 3600, [](double, double) { return 0.5; }));
  p.start(0.5, 1e-3, true);
  EXPECT_TRUE(p.press(105e-6, 200e-6, 20e-6, [](double, double) { return 0.5; }));
}

// The frame brakes, stands, and loses most of its force before it says that it is done.
TEST(Corridor, AFrameThatBrakesIsPressingNoDeeper) {
  Pressed p;
  p.start(0, std::nullopt, false, 1e-4);
  EXPECT_FALSE(p.press(-10e-6, 50e-6, 1e-4, linear));
  const double most_N = linear(50e-6, 0);
  EXPECT_FALSE(p.press(50e-6, 50.5e-6, 1e-6, [&](double, double s) {
    return most_N * (0.2 + 0.8 * std::exp(-s / 0.1));
  })) << *p.why;
}

// Millimetres above the contact a force is the drift of the cell, and no depth is counted from it.
TEST(Corridor, ACellThatDriftsInTheAirDoesNotPress) {
  for (const double drift_N : {0.08, -0.08}) {
    Pressed p;
    p.step(1e-3 - 3e-3, drift_N);
    p.start(drift_N, std::nullopt, false, 1e-3);
    EXPECT_FALSE(p.press(-3e-3, 50e-6, 1e-3, [drift_N](double x, double) {
      return drift_N + linear(x, 0);
    })) << *p.why;
  }
}

// A new zero of the travel moves no specimen.
TEST(Corridor, ANewZeroOfTheTravelKeepsTheContact) {
  Pressed p;
  WatchInputEvent zero(WatchInput::travel_zeroed);
  zero.travel_m = 0.7e-3;
  p.frame.apply(zero);
  EXPECT_FALSE(p.frame.rig.contact.travel_m) << "a gap needs a new search";
  p.start(0);
  EXPECT_TRUE(p.press(-0.7e-3 - 10e-6, 100e-6, 1e-5, [](double, double) { return 0.0; }));
}

TEST(Corridor, OneSampleIsNoProofAndWithoutAContactThereIsNone) {
  Pressed p;
  p.start(0);
  EXPECT_FALSE(p.press(-10e-6, 50e-6, 1e-5, [](double x, double s) {
    return std::lround(s * 50) % 10 == 0 ? 0 : linear(x, 0);
  })) << *p.why;
  WatchedFrame nothing;
  EXPECT_FALSE(furthest_m(nothing.rig, nothing.t, 1));
}

// The device's own end of a search for a force: no healthy specimen needs to be pressed that far,
// and with a cell that shows nothing the frame presses no further.
TEST(Corridor, SaysHowFarAForceIsReachedAtTheLatest) {
  Pressed p;
  p.start(0);
  const auto end = furthest_m(p.frame.rig, p.frame.t, 1);
  ASSERT_TRUE(end);
  const auto depth = p.press(-10e-6, 5e-3, 1e-4, [](double x, double) {
    return 0.06 * linear(x, 0) + std::min(linear(x, 0), 0.1);
  });
  EXPECT_FALSE(depth) << *p.why;
  EXPECT_GT(*end - 1e-3, 1.0 / kPressStiffness_N_m);
  EXPECT_LT(*end - 1e-3, 25.0 / kPressStiffness_N_m);
}

}  // namespace
}  // namespace lcrig
