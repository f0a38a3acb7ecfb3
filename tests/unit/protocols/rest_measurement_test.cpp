// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/rest_measurement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "protocols/rig/cell_noise.hpp"
#include "protocols/rig/tolerances.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

std::vector<FrameSample> samples(const std::vector<std::optional<double>>& forces,
                                 double travel_m = 1e-3) {
  std::vector<FrameSample> out;
  for (const auto& f : forces) {
    FrameSample s;
    s.force_N = f;
    s.travel_m = travel_m;
    out.push_back(s);
  }
  return out;
}

TEST(RestMeasurement, HasMeanAndScatterOfTheForcesThatAreThere) {
  RestMeasurement rest;
  rest.add(samples({1.0, std::nullopt, 2.0, 3.0}));
  EXPECT_EQ(rest.forces(), 3);
  EXPECT_DOUBLE_EQ(rest.force_N(), 2);
  EXPECT_DOUBLE_EQ(rest.scatter_N(), 1);
  EXPECT_TRUE(rest.is_alive());
}

TEST(RestMeasurement, ACellThatRepeatsItsLastDigitIsNotAlive) {
  RestMeasurement rest;
  rest.add(samples(std::vector<std::optional<double>>(100, 0.1)));
  EXPECT_FALSE(rest.is_alive());
  rest.add(samples({0.1001}));
  EXPECT_TRUE(rest.is_alive());
}

TEST(RestMeasurement, AFrameThatMovesDoesNotStand) {
  RestMeasurement rest;
  rest.add(samples({0.1, 0.2}, 1e-3));
  EXPECT_TRUE(rest.stands());
  rest.add(samples({0.1}, 1.02e-3));
  EXPECT_FALSE(rest.stands());
}

// A noise of two micrometres has a range of more than ten in a few hundred samples.
TEST(RestMeasurement, AFrameWhoseTravelJittersStandsAndOneThatGoesOrJumpsDoesNot) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 2e-6);
  const auto stands = [&](double jitter, double way_m, double jump_m) {
    RestMeasurement rest;
    constexpr int kSamples = 200;
    for (int i = 0; i < kSamples; ++i) {
      const double at_m = way_m * i / kSamples + (i > kSamples / 2 ? jump_m : 0);
      rest.add(samples({0.1}, at_m + jitter * noise(random)));
    }
    return rest.stands();
  };
  EXPECT_TRUE(stands(1, 0, 0));
  EXPECT_FALSE(stands(0, 12e-6, 0));
  EXPECT_FALSE(stands(0, 0, 12e-6));
  EXPECT_FALSE(stands(1, 25e-6, 0));
  EXPECT_FALSE(stands(1, 0, 25e-6));
  EXPECT_FALSE(stands(10, 0, 0)) << "that is no noise of a sensor";
}

// Chance of one sample beyond `sigmas` of its normal distribution.
double tail(double sigmas) {
  return 0.5 * std::erfc(sigmas / std::numbers::sqrt2);
}

// How often an honest hour at 100 Hz has a sample beyond kSampleSigmas of a scatter that was
// estimated with so many degrees of freedom: the mean over all estimates (chi distribution).
double false_alarms(double freedoms) {
  constexpr double kLooks = 3600 * 100, kStep = 1e-3;
  const double log_of_constant =
      std::log(2) + freedoms / 2 * std::log(freedoms / 2) - std::lgamma(freedoms / 2);
  double sum = 0;
  for (double part = kStep; part < 3; part += kStep) {  // estimated, of the true scatter
    const double density =
        std::exp(log_of_constant + (freedoms - 1) * std::log(part) - freedoms / 2 * part * part);
    const double sigmas = kSampleSigmas * sure_scatter_N(part, freedoms);
    sum += kStep * density * std::min(1.0, kLooks * tail(sigmas));
  }
  return sum;
}

TEST(RestMeasurement, AnHonestHourHasNoFalseAlarmHoweverFewSamplesToldTheScatter) {
  for (const double freedoms : {14, 17, 19, 24, 50, 100, 400, 4000}) {
    EXPECT_LT(false_alarms(freedoms), 1e-4) << freedoms;
    EXPECT_GT(false_alarms(freedoms), 1e-6) << freedoms << ": blind for nothing";
  }
  EXPECT_LT(3600 * 100 * tail(kDifferenceSigmas / std::numbers::sqrt2), 1e-4);
}

CellNoise scatter(double noise_N, double digit_N) {
  RestMeasurement rest;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, noise_N);
  std::vector<FrameSample> samples(50);
  MonoTime t = MonoTime() + 1s;
  for (FrameSample& s : samples) {
    s.force_N = std::round(noise(random) / digit_N) * digit_N;
    s.received = t += 20ms;
  }
  rest.add(samples);
  return CellNoise(rest);
}

// How often equal digits follow each other by chance, compared with what the figure allows.
TEST(Tolerances, AHealthyCellNeverRepeatsItselfThatOften) {
  const ForceBound rigid{Compression()};
  for (const double digit_N : {1e-5, 1e-4, 3e-4, 9e-4, 1.1e-3, 1.4e-3, 1.7e-3}) {
    SCOPED_TRACE(digit_N);
    const CellNoise seen = scatter(1e-3, digit_N);
    const auto f = tolerances_of(FrameCapabilities(), rigid, 1, 50, &seen, 1e-3);
    ASSERT_TRUE(f.frozen_samples);
    EXPECT_LE(*f.frozen_force_s, digit_N < 1e-3 ? 0.6 : 2);
    std::mt19937 random(11);
    std::normal_distribution<double> noise(0, 1e-3);
    std::int64_t longest = 0, run = 0;
    double last = 0;
    for (int i = 0; i < 2'000'000; ++i) {
      const double now = std::round(noise(random) / digit_N);
      run = now == last ? run + 1 : 1;
      last = now;
      longest = std::max(longest, run);
    }
    EXPECT_LT(longest, *f.frozen_samples * 3 / 4);
  }
  const CellNoise coarse = scatter(1e-4, 1e-3);
  EXPECT_FALSE(tolerances_of(FrameCapabilities(), rigid, 1, 50, &coarse, 1e-4).frozen_samples);
}

TEST(RestMeasurement, TellsADriftAndHowWellItIsKnown) {
  RestMeasurement rest;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 1e-3);
  std::vector<FrameSample> samples(150);
  MonoTime t = MonoTime() + 1s;
  for (FrameSample& s : samples) {
    s.received = t += 20ms;
    s.force_N = 5e-3 * to_seconds(t.time_since_epoch()) + noise(random);
  }
  rest.add(samples);
  EXPECT_NEAR(rest.drift_N_s(), 5e-3, 3 * rest.drift_error_N_s());
  EXPECT_NEAR(rest.drift_error_N_s(), 1e-3 * std::sqrt(12.0 / 150) / 3, 5e-5);
}

// 50.3 Hz of 10 mN, sampled fifty times a second, looks like a slow wave. It is not a drift.
TEST(RestMeasurement, HumThatTheSamplingMakesSlowIsNoDrift) {
  for (int phase = 0; phase < 12; ++phase) {
    RestMeasurement rest;
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 1e-3);
    std::vector<FrameSample> samples(150);
    MonoTime t = MonoTime() + 1s;
    for (FrameSample& s : samples) {
      s.received = t += 20ms;
      const double turns = 50.3 * to_seconds(t.time_since_epoch()) + phase / 12.0;
      s.force_N = 0.01 * std::sin(2 * std::numbers::pi * turns) + noise(random);
    }
    rest.add(samples);
    EXPECT_FALSE(rest.drifts()) << phase;
  }
}

// Samples of this force, a hundred a second.
RestMeasurement forces_of(std::size_t n, const std::function<double(std::size_t)>& force_N) {
  RestMeasurement rest;
  std::vector<FrameSample> samples(n);
  for (std::size_t i = 0; i < n; ++i) {
    samples[i].received = MonoTime() + 1s + i * 10ms;
    samples[i].force_N = force_N(i);
  }
  rest.add(samples);
  return rest;
}

// Standard error of the slope of independent samples: sqrt(sum of squares / (n - 2) / sum of t^2).
TEST(RestMeasurement, TheErrorOfADriftIsThatOfAStraightLine) {
  // 0, 1, 0 at 0, 10, 20 ms: no slope, and two thirds are left.
  const RestMeasurement three = forces_of(3, [](std::size_t i) { return i == 1 ? 1.0 : 0.0; });
  EXPECT_NEAR(three.drift_N_s(), 0, 1e-9);
  EXPECT_NEAR(three.drift_error_N_s(), std::sqrt(2.0 / 3 / 1 / (2 * 1e-4)), 1e-6);
  EXPECT_TRUE(std::isinf(forces_of(2, [](std::size_t) { return 0.0; }).drift_error_N_s()));
  RestMeasurement at_once;
  std::vector<FrameSample> same(5);
  for (std::size_t i = 0; i < same.size(); ++i) same[i].force_N = static_cast<double>(i % 2);
  at_once.add(same);
  EXPECT_TRUE(std::isinf(at_once.drift_error_N_s())) << "all at one instant";
}

double sum_of_squares(std::size_t n) {  // of times 10 ms apart, about their mean
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = 0.01 * (static_cast<double>(i) - static_cast<double>(n - 1) / 2);
    sum += t * t;
  }
  return sum;
}

// One wave is no drift, and neither half of it shows one; only its means by quarters do: 2/pi of
// the amplitude each, where independent samples leave a fifth of their scatter.
TEST(RestMeasurement, AWaveMakesADriftAsUncertainAsItsMeans) {
  const RestMeasurement wave = forces_of(100, [](std::size_t i) {
    return std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / 100);
  });
  const double independent = std::sqrt(50.0 / 98 / sum_of_squares(100));
  const double factor = 2 / std::numbers::pi * std::sqrt(25.0 / 0.5);
  EXPECT_NEAR(wave.drift_error_N_s(), factor * independent, 0.01 * factor * independent);
  // Samples that alternate have the same mean in every block: that makes no drift more certain.
  const RestMeasurement turns =
      forces_of(96, [](std::size_t i) { return i % 2 == 0 ? 1.0 : -1.0; });
  const double left = std::sqrt(96.0 / 94 / sum_of_squares(96));
  EXPECT_NEAR(turns.drift_error_N_s(), left, 0.01 * left);
}

// Rounding leaves less than nothing about a straight line.
TEST(RestMeasurement, OfAPerfectDriftTheErrorIsNothing) {
  for (int slope = 1; slope < 200; ++slope) {
    const RestMeasurement rest =
        forces_of(20, [&](std::size_t i) { return 0.37 + 1e-3 * slope * static_cast<double>(i); });
    EXPECT_GE(rest.drift_error_N_s(), 0) << slope;
    EXPECT_LT(rest.drift_error_N_s(), 1e-6) << slope;
  }
}

TEST(RestMeasurement, ADigitIsMoreThanRounding) {
  EXPECT_DOUBLE_EQ(forces_of(2, [](std::size_t i) { return i == 0 ? 0.0 : 1.5e-9; }).digit_N(),
                   1.5e-9);
  EXPECT_EQ(forces_of(2, [](std::size_t i) { return i == 0 ? 0.0 : 0.5e-9; }).digit_N(), 0);
}

// Steps of the same length are a motion, however short: they jitter by nothing.
TEST(RestMeasurement, AFrameThatGoesSteadilyOrSaysThatItMovesDoesNotStand) {
  std::vector<FrameSample> samples(10);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].travel_m = 1.4e-6 * static_cast<double>(i);
  }
  RestMeasurement goes, flagged;
  goes.add(samples);
  EXPECT_FALSE(goes.stands());
  for (FrameSample& s : samples) s.travel_m = 1e-3;
  samples[5].flags = frame_flag::kMoving;
  flagged.add(samples);
  EXPECT_FALSE(flagged.stands());
}

// Of a micrometre of noise a range of 10 um and five standard deviations counts as standing.
TEST(RestMeasurement, AFrameThatWandersBeyondItsJitterDoesNotStand) {
  const auto stands = [](double wanders_m) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 1e-6);
    std::vector<FrameSample> samples(1000);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i].travel_m = wanders_m * static_cast<double>(i) / 1000 + noise(random);
    }
    RestMeasurement rest;
    rest.add(samples);
    return rest.stands();
  };
  EXPECT_TRUE(stands(5e-6));
  EXPECT_FALSE(stands(13e-6));
}

TEST(CellNoise, IsNeverLessThanTheLastLookAndForgetsSlowly) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  const RestMeasurement quiet = forces_of(1000, [&](std::size_t) { return 1e-3 * normal(random); });
  const RestMeasurement loud =
      forces_of(4, [](std::size_t i) { return i % 2 == 0 ? 0.02 : -0.02; });
  CellNoise noise(quiet);
  noise.add(loud, std::nullopt);
  EXPECT_GE(noise.sure_noise_N(), loud.scatter_N());
  CellNoise before(loud);
  before.add(quiet, std::nullopt);
  EXPECT_NEAR(before.noise_N, 0.7 * loud.scatter_N(), 1e-12);
  const RestMeasurement repeats = forces_of(40, [](std::size_t i) { return i < 8 ? 0.0 : 1.0; });
  before.add(repeats, std::nullopt);
  EXPECT_EQ(before.longest_run, 32) << "a habit of the gateway";
  before.add(quiet, std::nullopt);
  EXPECT_EQ(before.longest_run, 32);
}

TEST(RestMeasurement, TellsHowATravelScattersButNotHowItsDigitFlips) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 1e-6);
  std::vector<FrameSample> fine(50), coarse(50);
  for (std::size_t i = 0; i < fine.size(); ++i) {
    fine[i].received = coarse[i].received = MonoTime() + 1s + i * 20ms;
    fine[i].travel_m = 2e-3 + noise(random);
    coarse[i].travel_m = i % 3 == 0 ? 2e-3 : 2.01e-3;
  }
  RestMeasurement scatters, flips;
  scatters.add(fine);
  flips.add(coarse);
  EXPECT_NEAR(scatters.travel_scatter_m(), 1e-6, 0.3e-6);
  EXPECT_EQ(flips.travel_scatter_m(), 0);
}

}  // namespace
}  // namespace lcrig
