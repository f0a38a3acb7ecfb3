// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "model/fem_levels.hpp"
#include "model/fem_system.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

StackSpace space_of(int mesh) {
  MeshSettings settings;
  settings.refinement = mesh;
  return StackSpace::make(laminate(2), settings, true).value();
}

LevelSettings finite_on(int mesh) {
  LevelSettings settings;
  settings.level = Level::fem_finite;
  settings.mesh.refinement = mesh;
  return settings;
}

FemState solved_on(const StackSpace& space) {
  FemSystem system(space);
  FemState state = system.rest();
  EXPECT_TRUE(system.solve(1e3, state).converged);
  return state;
}

TEST(Prolong, ToTheSameMeshChangesNothing) {
  const StackSpace space = space_of(0);
  const FemState state = solved_on(space);
  const FemState same = prolong(space, state, space);
  for (std::size_t i = 0; i < state.u.size(); ++i) {
    ASSERT_NEAR(same.u[i], state.u[i], 1e-12 * space.radius_m()) << i;
  }
  for (std::size_t i = 0; i < state.p.size(); ++i) ASSERT_NEAR(same.p[i], state.p[i], 1e-6) << i;
}

// A biquadratic field of the coarse mesh is also one of the finer mesh.
TEST(Prolong, ToAFinerMeshKeepsTheField) {
  const StackSpace coarse = space_of(-1), fine = space_of(0);
  const FemState state = solved_on(coarse);
  const FemState finer = prolong(coarse, state, fine);
  const double shortening = coarse.shortening_m(state.u);
  EXPECT_NEAR(fine.shortening_m(finer.u), shortening, 1e-12 * shortening);
  for (std::size_t i = 0; i < coarse.radii().size(); i += 2) {  // every second edge is the same
    const Height top{static_cast<int>(fine.rows().size()) - 1, 1};
    const Height coarse_top{static_cast<int>(coarse.rows().size()) - 1, 1};
    EXPECT_NEAR(fine.displacement(finer.u, top, 1)[2 * i],
                coarse.displacement(state.u, coarse_top, 1)[i], 1e-12 * shortening);
  }
}

TEST(Prolong, StartFromACoarserMeshGivesTheSameAnswerSooner) {
  const Specimen s = laminate(2);
  auto coarse = FemFinite::make(s, finite_on(0)).value();
  auto alone = FemFinite::make(s, finite_on(1)).value();
  auto helped = FemFinite::make(s, finite_on(1)).value();
  helped->start_from(*coarse);
  const auto expected = alone->at_pressure(50.0_kPa), found = helped->at_pressure(50.0_kPa);
  ASSERT_TRUE(expected && found);
  expect_relative(found->delta_capacitance_F, expected->delta_capacitance_F, 1e-9);
  EXPECT_LE(2 * helped->iterations(), alone->iterations());
}

// A start that fails costs only time: the loads are then climbed as without it.
TEST(Prolong, LoadThatTheCoarserMeshDoesNotReachIsClimbedTo) {
  const Specimen s = laminate(2);
  LevelSettings settings = finite_on(0);
  Specimen soft = s;  // another stack, whose solutions are no good starts
  for (Material& m : soft.materials) {
    m.youngs_modulus_Pa /= 30;
    m.given_shear_modulus_Pa.reset();
  }
  auto wrong = FemFinite::make(soft, settings).value();
  auto alone = FemFinite::make(s, finite_on(1)).value();
  auto misled = FemFinite::make(s, finite_on(1)).value();
  misled->start_from(*wrong);
  const auto expected = alone->at_pressure(50.0_kPa), found = misled->at_pressure(50.0_kPa);
  ASSERT_TRUE(expected && found);
  expect_relative(found->delta_capacitance_F, expected->delta_capacitance_F, 1e-9);
  EXPECT_GE(misled->iterations(), alone->iterations());  // it was climbed to
}

}  // namespace
}  // namespace lcrig
