// SPDX-License-Identifier: Apache-2.0
#include "model/partition_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/fem_levels.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

PartitionRequest four_layers() {
  PartitionRequest request;
  request.layers = 4;
  request.total_m = 1;
  request.least_m = 0.1;
  return request;
}

TEST(PartitionSearch, ConvexSumEndsAtAVertex) {
  auto found = best_partition(four_layers(), [](double a, double b) { return 1 / (b - a); });
  std::sort(found.thickness_m.begin(), found.thickness_m.end());
  EXPECT_NEAR(found.thickness_m[2], 0.1, 1e-12);
  EXPECT_NEAR(found.thickness_m[3], 0.7, 1e-12);
  EXPECT_NEAR(found.sensitivity_F_Pa, 30 + 1 / 0.7, 1e-9);
}

TEST(PartitionSearch, ConcaveSumEndsInTheMiddle) {
  const auto found =
      best_partition(four_layers(), [](double a, double b) { return std::sqrt(b - a); });
  for (const double t : found.thickness_m) EXPECT_NEAR(t, 0.25, 1e-9);
}

// The optimum lies off the grid and differs for each place: the weights decide the boundaries.
TEST(PartitionSearch, RefinesOffTheGrid) {
  PartitionRequest request;
  request.layers = 2;
  request.total_m = 1;
  request.least_m = 0.01;
  const double best = 1 / std::sqrt(7.0);
  const auto found = best_partition(
      request, [&](double a, double b) { return a == 0 ? -(b - best) * (b - best) : 0; });
  EXPECT_NEAR(found.thickness_m[0], best, 1e-5);
}

TEST(PartitionSearch, NoRoomMeansEqualLayers) {
  PartitionRequest request = four_layers();
  request.least_m = 0.25;
  const auto found = best_partition(request, [](double a, double b) { return 1 / (b - a); });
  for (const double t : found.thickness_m) EXPECT_NEAR(t, 0.25, 1e-12);
}

// The sum that the search computes equals the slope that the level gives for the same partition.
TEST(PartitionSearch, SweptVolumesAreTheSlopeOfThePartition) {
  Specimen block = soft_stack({1e-3});
  block.faces = Faces::bonded_base;
  LevelSettings settings;
  settings.level = Level::fem_linear;
  auto model = FemLinear::make(block, settings).value();
  const std::vector<double> cut{0.13e-3, 0.4e-3, 0.47e-3};
  const double eps = kVacuumPermittivity_F_m * 2.75;
  double slope = 0, z = 0;
  for (const double t : cut) {
    slope += eps * (model->swept_volume_m3_Pa(z + t) - model->swept_volume_m3_Pa(z)) / (t * t);
    z += t;
  }
  const double exact = model->at_pressure(Pressure::from_si(1e-4), cut)->delta_capacitance_F / 1e-4;
  expect_relative(slope, exact, 1e-8);
}

}  // namespace
}  // namespace lcrig
