// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/force_bound.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lcrig {
namespace {

TEST(ForceBound, OfALinearContactIsItsStiffnessTimesTheWay) {
  const ForceBound bound({}, 50e3);
  EXPECT_TRUE(bound.is_bounded());
  EXPECT_NEAR(bound.stiffness_N_m(0.3), 50e3, 1);
  EXPECT_NEAR(bound.force_after_N(1, 4e-6), 1.2, 1e-6);
  EXPECT_NEAR(bound.force_before_N(1.2, 4e-6), 1, 1e-6);
  EXPECT_NEAR(bound.way_m(1, 1.2), 4e-6, 1e-11);
  EXPECT_EQ(bound.way_m(-1, 0.5), bound.way_m(0, 0.5)) << "in the air nothing is pressed";
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

// The table is stored with a run: its first value holds up to 1 mN, each further one over 5 %.
TEST(ForceBound, OfATableKeepsTheForcesOfItsValues) {
  std::vector<double> table(400);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = 1e3 + static_cast<double>(i);
  const ForceBound bound = ForceBound::from_table(table);
  EXPECT_EQ(bound.stiffness_N_m(0), 1e3);
  for (std::size_t i = 1; i < table.size(); ++i) {
    const double low_N = 1e-3 * std::pow(1.05, static_cast<double>(i - 1));
    EXPECT_EQ(bound.stiffness_N_m(low_N * 1.001), table[i]) << low_N;
    EXPECT_EQ(bound.stiffness_N_m(low_N * 1.049), table[i]) << low_N;
  }
  EXPECT_EQ(bound.stiffness_N_m(1e9), table.back());
}

// Against a sum over small steps of the force, through random tables.
TEST(ForceBound, WayAndForceAgreeWithSmallSteps) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> even(0, 1);
  for (int n = 0; n < 50; ++n) {
    std::vector<double> table(400);
    for (double& k : table) k = 1e3 * std::pow(100.0, even(random));
    const ForceBound bound = ForceBound::from_table(table);
    const double from_N = 2 * even(random), to_N = from_N + even(random);
    constexpr int kSteps = 100'000;
    double way_m = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double at_N = from_N + (to_N - from_N) * (i + 0.5) / kSteps;
      way_m += (to_N - from_N) / kSteps / bound.stiffness_N_m(at_N);
    }
    EXPECT_NEAR(bound.way_m(from_N, to_N), way_m, 1e-4 * way_m);
    EXPECT_NEAR(bound.force_after_N(from_N, way_m), to_N, 1e-3 * to_N);
    EXPECT_NEAR(bound.force_before_N(to_N, way_m), from_N, 1e-3 * to_N);
    EXPECT_NEAR(bound.force_before_N(to_N, bound.way_m(from_N, to_N)), from_N, 1e-9);
    EXPECT_NEAR(bound.force_after_N(from_N, bound.way_m(from_N, to_N)), to_N, 1e-9);
  }
}

// A foam: stiff at first, soft from 0.4 N on. A bound at 0.4 N is the stiff one.
TEST(ForceBound, OfAContactThatSoftensIsTheStiffnessBefore) {
  const ForceBound bound(
      [](double force) { return force < 0.4 ? force / 50e3 : 0.4 / 50e3 + (force - 0.4) / 5e3; });
  for (const double force : {0.1, 0.37, 0.38}) {
    EXPECT_GE(bound.stiffness_N_m(force), 50e3 * (1 - 1e-9)) << force;
  }
  EXPECT_NEAR(bound.stiffness_N_m(0.45), 5e3, 1);
}

}  // namespace
}  // namespace lcrig
