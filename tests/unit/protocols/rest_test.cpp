// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/rest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace lcrig {
namespace {

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

}  // namespace
}  // namespace lcrig
