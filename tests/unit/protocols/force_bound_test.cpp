// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/force_bound.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lcrig {
namespace {

TEST(ForceBound, OfALinearContactIsItsStiffnessTimesTheWay) {
  const ForceBound bound({}, 50e3);
  EXPECT_TRUE(bound.is_bounded());
  EXPECT_NEAR(bound.stiffness_N_m(0.3), 50e3, 1);
  EXPECT_NEAR(bound.force_after_N(1, 4e-6), 1.2, 1e-6);
  EXPECT_NEAR(bound.force_before_N(1.2, 4e-6), 1, 1e-6);
  EXPECT_NEAR(bound.way_m(1, 1.2), 4e-6, 1e-11);
  EXPECT_EQ(bound.force_before_N(0.1, 1), 0) << "the whole compression is shorter";
}

// F = (x/c)^2: dF/dx grows with the force, and so does the force that a distance adds.
TEST(ForceBound, OfAStiffeningContactGoesUpToTheEndOfTheWay) {
  constexpr double c = 10e-6;
  const ForceBound bound([](double force) { return c * std::sqrt(force); });
  for (const double force : {0.05, 0.5, 2.0}) {
    for (const double way : {0.2e-6, 3e-6, 20e-6}) {
      const double x = c * std::sqrt(force) + way;
      const double exact = x * x / (c * c);
      const double end = bound.force_after_N(force, way);
      EXPECT_GE(end, exact * (1 - 1e-9)) << force << " N, " << way << " m: it is a bound";
      EXPECT_LE(end - force, 1.08 * (exact - force)) << "and not far above";
      EXPECT_GT(end - force, 2 * std::sqrt(force) / c * way) << "k at the threshold is no bound";
    }
  }
}

TEST(ForceBound, PutsSpecimenAndFrameInSeries) {
  const ForceBound both([](double force) { return force / 100e3; }, 25e3);
  EXPECT_NEAR(both.stiffness_N_m(1), 20e3, 1);
}

TEST(ForceBound, WithoutAnythingThatGivesWayIsNone) {
  const ForceBound rigid{Compression()};
  EXPECT_FALSE(rigid.is_bounded());
  EXPECT_TRUE(std::isinf(rigid.force_after_N(0.1, 1e-9)));
  EXPECT_EQ(rigid.force_before_N(1, 1e-9), 0);
  EXPECT_EQ(rigid.way_m(0, 1), 0);
}

TEST(ForceBound, TakesASpecimenThatGivesNoAnswerForRigidFromThere) {
  const ForceBound bound([](double force) { return std::min(force, 1.0) / 50e3; });
  EXPECT_NEAR(bound.force_after_N(0.1, 2e-6), 0.2, 1e-6);
  EXPECT_TRUE(std::isinf(bound.force_after_N(0.1, 40e-6)));
}

TEST(ForceBound, AMeasurementCanOnlyLowerIt) {
  ForceBound bound({}, 50e3);
  bound.limit_to(10e3, [](double force) { return 1 + force; });
  EXPECT_NEAR(bound.stiffness_N_m(1), 10e3 * 2, 10e3 * 0.06);
  EXPECT_NEAR(bound.stiffness_N_m(9), 50e3, 1) << "where it has grown beyond";
  bound.limit_to(1e9, [](double) { return 1.0; });
  EXPECT_LT(bound.stiffness_N_m(0.5), 16e3);
}

}  // namespace
}  // namespace lcrig
