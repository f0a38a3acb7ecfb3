// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/rest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "protocols/watch/watch_figures.hpp"

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

TEST(Rest, HasMeanAndScatterOfTheForcesThatAreThere) {
  Rest rest;
  rest.add(samples({1.0, std::nullopt, 2.0, 3.0}));
  EXPECT_EQ(rest.forces(), 3);
  EXPECT_DOUBLE_EQ(rest.force_N(), 2);
  EXPECT_DOUBLE_EQ(rest.scatter_N(), 1);
  EXPECT_TRUE(rest.is_alive());
}

TEST(Rest, ACellThatRepeatsItsLastDigitIsNotAlive) {
  Rest rest;
  rest.add(samples(std::vector<std::optional<double>>(100, 0.1)));
  EXPECT_FALSE(rest.is_alive());
  rest.add(samples({0.1001}));
  EXPECT_TRUE(rest.is_alive());
}

TEST(Rest, AFrameThatMovesDoesNotStand) {
  Rest rest;
  rest.add(samples({0.1, 0.2}, 1e-3));
  EXPECT_TRUE(rest.stands());
  rest.add(samples({0.1}, 1.02e-3));
  EXPECT_FALSE(rest.stands());
}

// A noise of two micrometres has a range of more than ten in a few hundred samples.
TEST(Rest, AFrameWhoseTravelJittersStandsAndOneThatGoesOrJumpsDoesNot) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 2e-6);
  const auto stands = [&](double jitter, double way_m, double jump_m) {
    Rest rest;
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

TEST(TravelStep, IsTheSmallestDifferenceSeen) {
  TravelStep step;
  step.add(1e-3);
  EXPECT_EQ(step.step_m(), 0);
  step.add(1.003e-3);
  step.add(std::nullopt);
  step.add(1.003e-3);
  step.add(1.002e-3);
  EXPECT_NEAR(step.step_m(), 1e-6, 1e-12);
}

double digit_of(const std::vector<double>& travels_um) {
  TravelDigit digit;
  for (const double x : travels_um) digit.add(x * 1e-6);
  return digit.digit_m() * 1e6;
}

TEST(TravelDigit, IsWhatAllStepsAreMultiplesOf) {
  EXPECT_NEAR(digit_of({100, 110, 140, 140, 120, 100, 90, 110}), 10, 1e-6);
  EXPECT_NEAR(digit_of({0, 15, 25, 25, 50, 60, 75}), 5, 1e-6) << "less than any step";
  EXPECT_NEAR(digit_of({0, 0.1, 4000.1, 4001.3, 0.4, 0, 3}), 0.1, 1e-6) << "the steps are long";
  EXPECT_NEAR(digit_of({0, 2.441, 4.883, 14.648, 13.428, 15.869, 17.090, 17.090}), 1.22, 0.01)
      << "told to a nanometre";
}

// A search of few samples.
TEST(TravelDigit, IsAtMostWhatFewStepsAllow) {
  EXPECT_NEAR(digit_of({0, 30, 60, 90, 110}), 10, 1e-6);
  EXPECT_NEAR(digit_of({0, 60, 120, 190, 250, 290}), 10, 1e-6);
  EXPECT_NEAR(digit_of({0, 51.3, 102.6, 148.77}), 5.13, 1e-6);
  EXPECT_NEAR(digit_of({0, 30, 60, 90}), 10, 1e-6) << "30 is too coarse for a digit";
  EXPECT_LE(digit_of({0, 1.7, 6.7, 11.7, 16.7, 18.1}), 0.1) << "where it began and ended";
}

TEST(TravelDigit, IsNotChangedByANewZero) {
  TravelDigit digit;
  for (const double x_um : {6000, 6010, 6010, 6030, 6030, 6070, 6080}) digit.add(x_um * 1e-6);
  digit.begin(4.6e-6);
  digit.add(14.6e-6);
  EXPECT_NEAR(digit.digit_m(), 10e-6, 1e-12);
}

TEST(TravelDigit, IsTakenForTheCoarsestUntilItShows) {
  EXPECT_NEAR(digit_of({}), 12, 1e-6);
  EXPECT_NEAR(digit_of({4000}), 12, 1e-6);
  EXPECT_NEAR(digit_of({4000, 4370, 4370}), 12, 1e-6);
  EXPECT_NEAR(digit_of({4000, 4000, 4010, 4010}), 10, 1e-6) << "a slow motion";
}

// They have so many parts that trying all would hold up the thread of the instruments.
TEST(TravelDigit, OfLongStepsIsTakenForTheCoarsest) {
  EXPECT_NEAR(digit_of({0, 20000.3, 41000.9, 62000.1}), 12, 1e-6);
}

TEST(TravelDigit, IsSureAfterSomeChangesOfTheStep) {
  const auto is_sure = [](const std::vector<double>& travels_um) {
    TravelDigit digit;
    for (const double x : travels_um) digit.add(x * 1e-6);
    return digit.is_sure();
  };
  EXPECT_TRUE(is_sure({100, 110, 140, 140, 120, 110, 90}));
  EXPECT_FALSE(is_sure({0, 2, 6, 10, 14, 18, 22, 26, 30, 31})) << "one speed, round figures";
}

// Searches at one speed, from a place at rest to another one.
class DigitOfDrives : public testing::Test {
 protected:
  struct Drive {
    double digit_um = 0.1, jitter = 0;  // of the sample times, in periods
    bool in_nanometres = false;  // sends its travel so
  };
  double even(double low, double high) {
    return std::uniform_real_distribution(low, high)(random_);
  }
  // A slow drive may end its search after two samples.
  double found_um(const Drive& drive) {
    const double step_um = std::exp(even(std::log(0.5), std::log(80)));  // from sample to sample
    const double from_um = even(0, 1000), way_um = step_um * even(2, 12), phase = even(0, 1);
    TravelDigit digit;
    const auto shown_m = [&](double travel_um) {
      const double um = std::round(travel_um / drive.digit_um) * drive.digit_um;
      return 1e-6 * (drive.in_nanometres ? std::round(um * 1e3) * 1e-3 : um);
    };
    digit.begin(shown_m(from_um));
    for (double k = phase; k * step_um < way_um; ++k) {
      const double late = drive.jitter > 0 ? even(0, drive.jitter) : 0;
      digit.add(shown_m(from_um + std::min(way_um, (k + late) * step_um)));
    }
    digit.add(shown_m(from_um + way_um));
    return digit.digit_m() * 1e6;
  }

 private:
  std::mt19937 random_{3};
};

constexpr int kDrives = 2000;

// Less than the digit would lead the first step back deeper.
TEST_F(DigitOfDrives, IsNeverTakenForFinerThanItIs) {
  for (const double digit_um : {0.7, 1.220703125, 2.0, 5.13, 10.0, 12.0}) {
    for (int i = 0; i < kDrives; ++i) {
      const Drive drive{digit_um, i % 2 == 0 ? 0 : 0.3, i % 3 == 0};
      const double um = found_um(drive);
      ASSERT_GE(um, 0.999 * digit_um) << i;
      ASSERT_LE(um, 12.01) << i;
    }
  }
}

// Such a step back would leave a contact whose stiffness could be measured.
TEST_F(DigitOfDrives, OfAFineDriveIsSeldomTakenForCoarse) {
  for (const double digit_um : {0.001, 0.01, 0.1, 0.5}) {
    for (const double jitter : {0.0, 0.3}) {
      int coarse = 0;
      for (int i = 0; i < kDrives; ++i) {
        if (found_um({digit_um, jitter, i % 3 == 0}) > 1) ++coarse;
      }
      EXPECT_LT(coarse, 0.05 * kDrives) << digit_um << " um, jitter " << jitter;
    }
  }
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

TEST(Rest, AnHonestHourHasNoFalseAlarmHoweverFewSamplesToldTheScatter) {
  for (const double freedoms : {14, 17, 19, 24, 50, 100, 400, 4000}) {
    EXPECT_LT(false_alarms(freedoms), 1e-4) << freedoms;
    EXPECT_GT(false_alarms(freedoms), 1e-6) << freedoms << ": blind for nothing";
  }
  EXPECT_LT(3600 * 100 * tail(kDifferenceSigmas / std::numbers::sqrt2), 1e-4);
}

ForceScatter scatter(double noise_N, double digit_N) {
  Rest rest;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, noise_N);
  std::vector<FrameSample> samples(50);
  MonoTime t = MonoTime() + 1s;
  for (FrameSample& s : samples) {
    s.force_N = std::round(noise(random) / digit_N) * digit_N;
    s.received = t += 20ms;
  }
  rest.add(samples);
  return ForceScatter(rest);
}

// How often equal digits follow each other by chance, compared with what the figure allows.
TEST(WatchFigures, AHealthyCellNeverRepeatsItselfThatOften) {
  const ForceBound rigid{Compression()};
  for (const double digit_N : {1e-5, 1e-4, 3e-4, 9e-4, 1.1e-3, 1.4e-3, 1.7e-3}) {
    SCOPED_TRACE(digit_N);
    const auto f = watch_figures(FrameCapabilities(), rigid, 1, 50, scatter(1e-3, digit_N), 1e-3);
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
  EXPECT_FALSE(
      watch_figures(FrameCapabilities(), rigid, 1, 50, scatter(1e-4, 1e-3), 1e-4).frozen_samples);
}

TEST(Rest, TellsADriftAndHowWellItIsKnown) {
  Rest rest;
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
TEST(Rest, HumThatTheSamplingMakesSlowIsNoDrift) {
  for (int phase = 0; phase < 12; ++phase) {
    Rest rest;
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

TEST(Rest, TellsHowATravelScattersButNotHowItsDigitFlips) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 1e-6);
  std::vector<FrameSample> fine(50), coarse(50);
  for (std::size_t i = 0; i < fine.size(); ++i) {
    fine[i].received = coarse[i].received = MonoTime() + 1s + i * 20ms;
    fine[i].travel_m = 2e-3 + noise(random);
    coarse[i].travel_m = i % 3 == 0 ? 2e-3 : 2.01e-3;
  }
  Rest scatters, flips;
  scatters.add(fine);
  flips.add(coarse);
  EXPECT_NEAR(scatters.travel_scatter_m(), 1e-6, 0.3e-6);
  EXPECT_EQ(flips.travel_scatter_m(), 0);
}

}  // namespace
}  // namespace lcrig
