// SPDX-License-Identifier: Apache-2.0
#include "model/mesh_limit.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lcrig {
namespace {

std::vector<double> falling(double limit, double error, double ratio, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(limit + error / std::pow(ratio, i));
  return values;
}

MeshSequence halving(std::size_t meshes) {
  return {{2, 3}, std::vector<double>(meshes - 1, 1)};
}

TEST(MeshLimit, FindsTheLimitOfAGeometricSequence) {
  for (const double ratio : {2.5, 4.0, 9.0, 15.0}) {
    for (const int count : {3, 4, 6}) {
      const auto values = falling(7, -0.1, ratio, count);
      const MeshLimit limit = limit_of(values, halving(values.size()));
      EXPECT_TRUE(limit.settled);
      EXPECT_NEAR(limit.value, 7, 1e-12);
      EXPECT_NEAR(limit.order, std::log2(ratio), 1e-9);
      EXPECT_GE(limit.doubt, (7 - values.back()) * (1 - 1e-9));
    }
  }
}

// Two cells become three, and three become four, in turn.
TEST(MeshLimit, FindsTheLimitOfUnevenRefinement) {
  const double cells[] = {2, 3, 4, 6};
  for (const double order : {1.5, 3.0, 4.0, 6.0}) {
    for (const std::size_t first : {0U, 1U}) {
      MeshSequence meshes{{4, 4}, {}};
      std::vector<double> values;
      for (std::size_t i = first; i < 4; ++i) {
        values.push_back(7 - std::pow(cells[i], -order));
        if (i > first) meshes.halvings.push_back(std::log2(cells[i] / cells[i - 1]));
      }
      const MeshLimit limit = limit_of(values, meshes);
      EXPECT_TRUE(limit.settled);
      EXPECT_NEAR(limit.value, 7, 1e-8);
      EXPECT_NEAR(limit.order, order, 1e-6);
      EXPECT_GE(limit.doubt, (7 - values.back()) * (1 - 1e-6));
    }
  }
}

TEST(MeshLimit, SaysWhenTheMeshesDoNotConvergeYet) {
  for (const std::vector<double>& values :
       {std::vector<double>{1, 2, 3}, {1, 2, 3.9}, {1, 2, 1}, {1, 1.1, 1.9}, {4, 1, 2, 3.5}}) {
    const MeshLimit limit = limit_of(values, halving(values.size()));
    EXPECT_FALSE(limit.settled);
    EXPECT_EQ(limit.value, values.back());
    EXPECT_GE(limit.doubt, std::abs(values.back() - values[values.size() - 2]));
  }
}

TEST(MeshLimit, AStepThatIsSmallByChanceIsNotBelieved) {
  for (const double last : {1e-9, -1e-9})
    EXPECT_GT(limit_of({1, 2, 2 + last}, halving(3)).doubt, 1e-2);
}

// fem_finite on meshes -2 to 0, stack 2000963: the next mesh is 1.9e-3 farther.
TEST(MeshLimit, AStepBackThatIsSmallByChanceIsNotBelieved) {
  EXPECT_GT(limit_of({1 + 1.827e-2, 1, 1 + 7.1e-6}, halving(3)).doubt, 1.9e-3);
}

TEST(MeshLimit, AroundTheLimitItIsNoFartherThanTheLastStep) {
  const MeshLimit limit = limit_of({1, 2, 1.75}, halving(3));
  EXPECT_TRUE(limit.settled);
  EXPECT_DOUBLE_EQ(limit.doubt, 0.25);
}

TEST(MeshLimit, EqualValuesAreExactToRounding) {
  const MeshLimit limit = limit_of({3, 3, 3}, halving(3));
  EXPECT_TRUE(limit.settled);
  EXPECT_LT(limit.doubt, 1e-13);
}

}  // namespace
}  // namespace lcrig
