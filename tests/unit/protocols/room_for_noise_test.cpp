// SPDX-License-Identifier: Apache-2.0
// How much noise a short look at the unloaded cell must be taken for.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "protocols/rig/cell_noise.hpp"
#include "protocols/rig/rest_measurement.hpp"
#include "protocols/rig/tolerances.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// Chance that of two scatters, each estimated with so many degrees of freedom, the second is more
// than `ratio` times the first (F distribution).
double exceeds_by(double ratio, double freedoms) {
  constexpr int kSteps = 20'000;
  const double a = freedoms / 2, end = 1 / (1 + ratio * ratio);
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) * end / kSteps;
    sum += std::exp((a - 1) * std::log(t * (1 - t)) + std::lgamma(2 * a) - 2 * std::lgamma(a));
  }
  return sum * end / kSteps;
}

TEST(RestMeasurement, AnotherLookHardlyEverFindsMoreScatterThanWasForeseenHoweverFewItsSamples) {
  for (const double freedoms : {2, 3, 4, 9, 14, 19, 24, 50, 100, 400}) {
    EXPECT_LT(exceeds_by(scatter_anew(freedoms), freedoms), 1e-3) << freedoms;
    EXPECT_GT(exceeds_by(scatter_anew(freedoms), freedoms), 1e-4) << freedoms << ": too careful";
  }
}

RestMeasurement look_at_cell(std::mt19937& random, double noise_N, double digit_N, int count) {
  std::normal_distribution<double> noise(0, noise_N);
  RestMeasurement rest;
  for (int i = 0; i < count; ++i) {
    FrameSample s;
    s.force_N = std::round(noise(random) / digit_N) * digit_N;
    s.received = MonoTime() + i * 50ms;
    rest.add(std::span(&s, 1));
  }
  return rest;
}

TEST(CellNoise, AnotherLookHardlyEverNeedsMoreRoomThanWasForeseen) {
  constexpr int kPairs = 10'000;
  std::mt19937 random(17);
  for (const int count : {10, 20, 25, 50}) {
    for (const double digit_N : {1e-5, 1e-3, 2e-3, 4e-3}) {  // of 1 mN
      SCOPED_TRACE(testing::Message() << count << " samples, digit " << digit_N);
      int more = 0;
      for (int i = 0; i < kPairs; ++i) {
        const CellNoise first(look_at_cell(random, 1e-3, digit_N, count));
        const CellNoise second(look_at_cell(random, 1e-3, digit_N, count));
        if (first.alive) more += second.sure_noise_N() > first.sure_noise_anew_N();
      }
      EXPECT_LT(more, kPairs / 1000);
    }
  }
}

// A digit of four standard deviations that flips once in 20 samples.
TEST(CellNoise, NoiseIsNeverLessThanTheDigitMayHide) {
  const auto seen = [](int flips) {
    RestMeasurement rest;
    for (int i = 0; i < 20; ++i) {
      FrameSample s;
      s.force_N = i < flips ? 8e-3 : 0;
      s.received = MonoTime() + i * 50ms;
      rest.add(std::span(&s, 1));
    }
    return CellNoise(rest).sure_noise_N();
  };
  EXPECT_GE(seen(1), 4e-3);
  EXPECT_GE(seen(10), 4e-3);
  EXPECT_LT(seen(10), 8e-3);
  EXPECT_EQ(seen(0), 0) << "no digit was seen";
}

}  // namespace
}  // namespace lcrig
