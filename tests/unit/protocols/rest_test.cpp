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

// Two micrometres of noise reach over more than ten in a few hundred samples.
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

}  // namespace
}  // namespace lcrig
