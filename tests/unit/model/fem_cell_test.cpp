// SPDX-License-Identifier: Apache-2.0
#include "model/fem_cell.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/fem_linear_cell.hpp"

namespace lcrig {
namespace {

constexpr CellGeometry kCell{0.7, 1.1, 0.2, 0.5};
constexpr ElasticLaw kSoft{42, 1.0 / 2058};

struct CellState {
  std::array<double, kCellDofs> u{};
  std::array<double, kCellPressures> p{};
};

CellState some_state(double size, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-size, size);
  CellState state;
  for (double& x : state.u) x = any(random);
  for (double& x : state.p) x = 100 * any(random);
  return state;
}

CellResult evaluate(const CellState& s, const ElasticLaw& law = kSoft) {
  CellResult result{};
  EXPECT_TRUE(evaluate_cell(kCell, law, s.u, s.p, result));
  return result;
}

TEST(Cell, ForceIsDerivativeOfEnergy) {
  const CellState at = some_state(0.03);
  const CellResult here = evaluate(at);
  const double h = 1e-6;
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    CellState up = at, down = at;
    up.u[i] += h;
    down.u[i] -= h;
    const double slope = (evaluate(up).energy - evaluate(down).energy) / (2 * h);
    EXPECT_NEAR(here.force[i], slope, 1e-6) << i;
  }
  for (std::size_t k = 0; k < kCellPressures; ++k) {
    CellState up = at, down = at;
    up.p[k] += h;
    down.p[k] -= h;
    const double slope = (evaluate(up).energy - evaluate(down).energy) / (2 * h);
    EXPECT_NEAR(here.lack[k], slope, 1e-8) << k;
  }
}

// If the pressure follows the displacements, du changes the force by condensed stiffness x du.
TEST(Cell, TangentIsDerivativeOfForce) {
  const CellState at = some_state(0.03);
  const CellResult here = evaluate(at);
  const double h = 1e-6;
  for (std::size_t j = 0; j < kCellDofs; ++j) {
    const auto moved = [&](double by) {
      CellState s = at;
      s.u[j] += by;
      for (std::size_t k = 0; k < kCellPressures; ++k) {
        for (std::size_t l = 0; l < kCellPressures; ++l) {
          s.p[k] += here.gain[k][l] * here.coupling[j][l] * by;
        }
      }
      return evaluate(s);
    };
    const CellResult up = moved(h), down = moved(-h);
    for (std::size_t i = 0; i < kCellDofs; ++i) {
      const double slope = (up.force[i] - down.force[i]) / (2 * h);
      EXPECT_NEAR(here.stiffness[i][j], slope, 2e-5 * (1 + std::abs(slope))) << i << " " << j;
    }
  }
}

TEST(Cell, UndeformedStateIsStressFree) {
  const CellResult rest = evaluate(CellState{});
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    EXPECT_EQ(rest.force[i], 0);
    for (std::size_t j = 0; j < kCellDofs; ++j) {
      EXPECT_EQ(rest.stiffness[i][j], rest.stiffness[j][i]);
    }
  }
  EXPECT_EQ(rest.energy, 0);
}

// The only rigid motion of an axisymmetric body is along its axis. It changes nothing.
TEST(Cell, RigidMotionCostsNothing) {
  CellState at = some_state(0.03);
  const CellResult before = evaluate(at);
  for (std::size_t a = 0; a < kCellNodes; ++a) at.u[2 * a + 1] += 5;
  const CellResult after = evaluate(at);
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    EXPECT_NEAR(before.force[i], after.force[i], 1e-11);
  }
  double total = 0;
  for (std::size_t a = 0; a < kCellNodes; ++a) total += after.force[2 * a + 1];
  EXPECT_NEAR(total, 0, 1e-12);
}

// The two codes have nothing else in common: one uses products of integrals along the axes, the
// other Gauss points in the plane.
TEST(Cell, TangentAtRestIsTheLinearCellOfDegreeTwo) {
  const CellResult finite = evaluate(CellState{});
  const LinearCell linear = make_linear_cell(2, radial_integrals(2, kCell.r0, kCell.r1),
                                             axial_integrals(2, kCell.z0, kCell.z1), kSoft);
  ASSERT_EQ(linear.dofs, kCellDofs);
  const double size = finite.stiffness[0][0];
  auto value = linear.stiffness.begin();
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    // Gauss points are not exact for integrands that are divided by the radius
    for (std::size_t j = 0; j <= i; ++j) {
      EXPECT_NEAR(*value++, finite.stiffness[i][j], 1e-4 * size) << i << " " << j;
    }
  }
}

TEST(LinearCell, RigidMotionAndUniformPressureCostNothingElse) {
  for (const int degree : {2, 4}) {
    const LinearCell cell = make_linear_cell(degree, radial_integrals(degree, 0.7, 1.1),
                                             axial_integrals(degree, 0, 0.3), kSoft);
    const double size = cell.stiffness[0];
    std::vector<double> force(cell.dofs);  // of a motion along the axis by one
    auto value = cell.stiffness.begin();
    for (std::size_t i = 0; i < cell.dofs; ++i) {
      for (std::size_t j = 0; j <= i; ++j, ++value) {
        if (j % 2 == 1) force[i] += *value;
        if (i % 2 == 1 && i != j) force[j] += *value;
      }
    }
    for (const double f : force) EXPECT_NEAR(f, 0, 1e-9 * size);
  }
}

// Mirrored in z: the response of the mirrored state is the mirrored response.
TEST(Cell, MirroredStateGivesMirroredForce) {
  const CellState at = some_state(0.05);
  CellState mirrored;
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const std::size_t b = 3 * (2 - a / 3) + a % 3;
    mirrored.u[2 * b] = at.u[2 * a];
    mirrored.u[2 * b + 1] = -at.u[2 * a + 1];
  }
  mirrored.p = {at.p[0], at.p[1], -at.p[2]};
  const CellResult one = evaluate(at);
  const CellResult two = evaluate(mirrored);
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const std::size_t b = 3 * (2 - a / 3) + a % 3;
    EXPECT_NEAR(one.force[2 * a], two.force[2 * b], 1e-12);
    EXPECT_NEAR(one.force[2 * a + 1], -two.force[2 * b + 1], 1e-12);
  }
}

// A superposed rotation costs no energy and rotates the forces. A rotation in the meridional plane
// is not axisymmetric, but far from the axis the hoop strain that it causes vanishes.
TEST(Cell, FrameIndifference) {
  constexpr double kFar = 1e9;
  const CellGeometry cell{kFar, kFar + 0.5, 0.2, 0.5};
  const CellState at = some_state(0.03);
  const double angle = 0.7, c = std::cos(angle), s = std::sin(angle);
  CellState turned = at;
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const double x = 0.25 * static_cast<double>(a % 3), z = 0.2 + 0.15 * static_cast<double>(a / 3);
    const double r1 = x + at.u[2 * a], z1 = z + at.u[2 * a + 1];
    turned.u[2 * a] = c * r1 - s * z1 - x;
    turned.u[2 * a + 1] = s * r1 + c * z1 - z;
  }
  CellResult one{}, two{};
  ASSERT_TRUE(evaluate_cell(cell, kSoft, at.u, at.p, one));
  ASSERT_TRUE(evaluate_cell(cell, kSoft, turned.u, turned.p, two));
  EXPECT_NEAR(two.energy / one.energy, 1, 1e-6);
  double size = 0;
  for (const double f : one.force) size = std::max(size, std::abs(f));
  for (std::size_t a = 0; a < kCellNodes; ++a) {
    const double fr = one.force[2 * a], fz = one.force[2 * a + 1];
    EXPECT_NEAR(two.force[2 * a], c * fr - s * fz, 1e-6 * size) << a;
    EXPECT_NEAR(two.force[2 * a + 1], s * fr + c * fz, 1e-6 * size) << a;
  }
}

TEST(Cell, TurnedInsideOutIsNoticed) {
  CellState at;
  for (std::size_t a = 6; a < kCellNodes; ++a) at.u[2 * a + 1] = -1;  // top below bottom
  CellResult result{};
  EXPECT_FALSE(evaluate_cell(kCell, kSoft, at.u, at.p, result));
}

TEST(Cell, IncompressibleIsNothingSpecial) {
  const CellState at = some_state(0.01);
  const CellResult result = evaluate(at, ElasticLaw{42, 0});
  for (const auto& row : result.stiffness) {
    for (const double value : row) EXPECT_TRUE(std::isfinite(value));
  }
}

}  // namespace
}  // namespace lcrig
