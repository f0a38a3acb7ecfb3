// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/rest.hpp"

#include <gtest/gtest.h>

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
