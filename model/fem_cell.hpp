// SPDX-License-Identifier: Apache-2.0
// One axisymmetric rectangle: biquadratic displacement, discontinuous linear pressure (Q2/P-1),
// neo-Hooke form A with the pressure as a field of its own,
//   W = mu/2 (I1 - 3 - 2 ln J) + p ln J - p^2/(2 lambda),
// so that nu = 0.5 (1/lambda = 0) is nothing special and nothing locks. The pressure is condensed
// inside the cell: what leaves it is symmetric in displacements alone. docs/model.md, "Elements".
#pragma once

#include <array>

#include "model/fem_space.hpp"

namespace lcrig {

inline constexpr int kCellNodes = 9;  // bottom line left to right, middle line, top line
inline constexpr int kCellDofs = 18;  // radial, axial per node
inline constexpr int kCellPressures = 3;  // 1, xi, eta

enum class Kinematics { linear, finite };

struct CellGeometry {
  double r0, r1, z0, z1;  // m
};

struct CellResult {
  std::array<std::array<double, kCellDofs>, kCellDofs> stiffness;  // condensed, N/m; full square
  std::array<double, kCellDofs> force;  // internal nodal force, N
  std::array<double, kCellDofs> condensed_force;  // with the pressure eliminated, N
  // For the pressure increment: dp = gain (coupling^T du + lack).
  std::array<std::array<double, kCellPressures>, kCellDofs> coupling;
  std::array<double, kCellPressures> lack;  // of the volume equations, m3
  std::array<std::array<double, kCellPressures>, kCellPressures> gain;
  double lack_scale;  // size of the terms whose difference `lack` is, m3
  double min_j;  // smallest volume ratio; linear: 1
  double energy;  // whose derivatives `force` and `lack` are, J
};

// Fills `out` at displacements u and pressures p. Where the material is so nearly incompressible
// that condensing would lose its digits (1/lambda below 1e-7/mu) `gain` is that of 1e-7/mu;
// repeated steps still drive `lack` to zero. False (out is then useless) when an integration point
// is turned inside out. The stiffness is left alone unless `tangent`.
bool evaluate_cell(Kinematics kinematics, const CellGeometry& cell, const ElasticLaw& law,
                   const std::array<double, kCellDofs>& u,
                   const std::array<double, kCellPressures>& p, bool tangent, CellResult& out);

}  // namespace lcrig
