// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/rest.hpp"

#include <gtest/gtest.h>

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

TEST(TravelDigit, IsWhatAllChangesOfAStepAreMultiplesOf) {
  EXPECT_NEAR(digit_of({100, 110, 140, 140, 120, 100, 90, 110}), 10, 1e-6);
  EXPECT_NEAR(digit_of({0, 15, 25, 25, 50, 60, 75}), 5, 1e-6) << "less than any step";
  EXPECT_NEAR(digit_of({0, 0.1, 4000.1, 4001.3, 0.4, 0, 3}), 0.1, 1e-6) << "the steps are long";
  EXPECT_NEAR(digit_of({0, 2.441, 4.883, 14.648, 13.428, 15.869, 17.090, 17.090}), 1.22, 0.01)
      << "told to a nanometre";
}

TEST(TravelDigit, IsNotChangedByANewZero) {
  TravelDigit digit;
  for (const double x_um : {6000, 6010, 6010, 6030, 6030, 6070, 6080}) digit.add(x_um * 1e-6);
  digit.begin();
  for (const double x_um : {4.6, 14.6}) digit.add(x_um * 1e-6);
  EXPECT_NEAR(digit.digit_m(), 10e-6, 1e-12);
}

TEST(TravelDigit, IsNotKnownAtFirst) {
  EXPECT_EQ(digit_of({}), 0);
  EXPECT_EQ(digit_of({4000}), 0);
  EXPECT_EQ(digit_of({4000, 4010, 4010, 4020}), 0);
  EXPECT_EQ(digit_of({0, 4, 8, 12, 16, 20, 24, 28, 32, 33}), 0) << "one speed, and where it ends";
  EXPECT_EQ(digit_of({0, 100, 200, 400, 300, 400, 400, 500}), 0) << "steps of a fast motion";
}

}  // namespace
}  // namespace lcrig
