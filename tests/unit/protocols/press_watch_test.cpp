// SPDX-License-Identifier: Apache-2.0
// Specimens of several kinds, pressed by independent arithmetic, and cells that show no force.
#include "protocols/watch/press_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr double kPressStiffness_N_m = 100e3, kTolerance_N = 0.01, kDoubt_m = 1e-6;

// A contact of 100 N/mm that was found at 1 mm with 0.05 N.
struct Pressed {
  Pressed() { eyes.know(t, 1e-3, 0.05, kPressStiffness_N_m); }
  void begin(double felt_N, std::optional<double> relaxes_N_s = std::nullopt, bool holds = false,
             double speed_m_s = 0) {
    PressWatch::Motion m;
    m.speed_m_s = speed_m_s;
    m.felt_N = felt_N;
    m.relaxes_N_s = relaxes_N_s;
    m.holds = holds;
    eyes.begin(m, t);
  }
  // Presses from `from_m` beyond contact at this speed. `shown` gives the force for depth and
  // seconds. Returns the depth at which something was noticed.
  std::optional<double> press(double from_m, double to_m, double speed_m_s,
                              const std::function<double(double, double)>& shown) {
    for (double s = 0; from_m + speed_m_s * s <= to_m; s += 0.02) {
      t += 20ms;
      depth_m = from_m + speed_m_s * s;
      why = eyes.check(t, 1e-3 + depth_m, shown(depth_m, s), kTolerance_N, kDoubt_m);
      if (why) return depth_m;
    }
    return std::nullopt;
  }

  PressWatch eyes;
  MonoTime t = MonoTime() + 100s;
  double depth_m = 0;
  std::optional<std::string> why;
};

double linear(double depth_m, double /*s*/) {
  return std::max(0.0, kPressStiffness_N_m * (depth_m + 0.5e-6));
}

TEST(PressWatch, BelievesSpecimensThatPushBack) {
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
      p.begin(0);
      EXPECT_FALSE(p.press(-10e-6, 100e-6, speed, specimen)) << p.why.value_or("");
      // ... and again, after the probe stood still and lost a third of its force.
      const double felt_N = specimen(100e-6, 0) * 0.67;
      p.eyes.rest(1.1e-3, felt_N);
      p.begin(felt_N);
      EXPECT_FALSE(p.press(100e-6, 200e-6, speed, [&](double x, double s) {
        return 0.67 * specimen(x, s);
      })) << p.why.value_or("");
    }
  }
}

TEST(PressWatch, ACellThatScattersAboutOneForceIsNoticedInTenthsOfANewton) {
  for (const double frozen_N : {0.0, 0.02, 0.3, 0.8}) {  // before contact, and after it
    Pressed p;
    p.begin(0);
    const auto depth = p.press(-10e-6, 5e-3, 1e-5,
                               [&](double x, double) { return std::min(frozen_N, linear(x, 0)); });
    ASSERT_TRUE(depth);
    EXPECT_LT(linear(*depth, 0), frozen_N + 0.4);
    EXPECT_THAT(*p.why, HasSubstr("does not follow the way into the specimen"));
  }
}

TEST(PressWatch, WhatIsSeenToRelaxSlowlyIsWatchedMoreClosely) {
  const auto frozen = [](double, double) { return 0.5; };
  const auto pressed_N = [&](std::optional<double> relaxes_N_s) {
    Pressed p;
    p.begin(0);
    EXPECT_FALSE(p.press(-10e-6, 4.5e-6, 1e-5, linear));
    p.eyes.rest(1e-3 + 4.5e-6, 0.5);
    p.begin(0.5, relaxes_N_s);
    return linear(p.press(4.5e-6, 5e-3, 1e-5, frozen).value_or(1), 0);
  };
  EXPECT_LT(pressed_N(1e-3), 1.2);
  EXPECT_GT(pressed_N(std::nullopt), 2);
  EXPECT_LT(pressed_N(std::nullopt), 5);
}

TEST(PressWatch, AGainThatFellToATenthIsNoticedNearContact) {
  Pressed p;
  p.begin(0);
  const auto depth =
      p.press(-10e-6, 5e-3, 1e-5, [](double x, double) { return 0.1 * linear(x, 0); });
  ASSERT_TRUE(depth);
  EXPECT_LT(linear(*depth, 0), 0.5);
}

// A hundred micrometres in an hour under a held force: the frame only follows the specimen.
TEST(PressWatch, AForceThatIsHeldMayCreep) {
  Pressed p;
  p.begin(0.5, 1e-3, true);
  EXPECT_FALSE(p.press(4.5e-6, 105e-6, 100e-6 / 3600, [](double, double) { return 0.5; }));
  p.begin(0.5, 1e-3, true);
  EXPECT_TRUE(p.press(105e-6, 200e-6, 20e-6, [](double, double) { return 0.5; }));
}

// The frame brakes, stands, and loses most of its force before it says that it is done.
TEST(PressWatch, AFrameThatBrakesIsPressingNoDeeper) {
  Pressed p;
  p.begin(0, std::nullopt, false, 1e-4);
  EXPECT_FALSE(p.press(-10e-6, 50e-6, 1e-4, linear));
  const double most_N = linear(50e-6, 0);
  EXPECT_FALSE(p.press(50e-6, 50.5e-6, 1e-6, [&](double, double s) {
    return most_N * (0.2 + 0.8 * std::exp(-s / 0.1));
  })) << *p.why;
}

TEST(PressWatch, OneSampleIsNoProofAndWithoutAContactThereIsNone) {
  Pressed p;
  p.begin(0);
  EXPECT_FALSE(p.press(-10e-6, 50e-6, 1e-5, [](double x, double s) {
    return std::lround(s * 50) % 10 == 0 ? 0 : linear(x, 0);
  })) << *p.why;
  PressWatch nothing;
  nothing.begin(PressWatch::Motion(), MonoTime());
  EXPECT_FALSE(nothing.check(MonoTime() + 1s, 1, 0, kTolerance_N, kDoubt_m));
  EXPECT_FALSE(nothing.furthest_m(MonoTime() + 1s, 1, kTolerance_N, kDoubt_m));
}

// The device's own end of a search for a force: no healthy specimen needs to be pressed that far,
// and with a cell that shows nothing the frame presses no further.
TEST(PressWatch, SaysHowFarAForceIsReachedAtTheLatest) {
  Pressed p;
  p.begin(0);
  const auto end = p.eyes.furthest_m(p.t, 1, kTolerance_N, kDoubt_m);
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
