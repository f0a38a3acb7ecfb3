// SPDX-License-Identifier: Apache-2.0
// One axisymmetric rectangular element for FemSystem: biquadratic displacement and discontinuous
// linear pressure (Q2/P-1). The pressure is condensed inside the cell, which leaves a symmetric
// system of displacements. docs/model.md, "Elements".
#pragma once

#include <array>

#include "model/fem_space.hpp"

namespace lcrig {

inline constexpr int kCellNodes = 9;  // bottom line left to right, middle line, top line
inline constexpr int kCellDofs = 18;  // radial, axial per node
inline constexpr int kCellPressures = 3;  // 1, xi, eta

struct CellGeometry {
  double r0, r1, z0, z1;  // m
};

struct CellResult {
  std::array<std::array<double, kCellDofs>, kCellDofs> stiffness;  // condensed, N/m; full square
  std::array<double, kCellDofs> force;  // internal nodal force, N
  std::array<double, kCellDofs> condensed_force;  // N, with the pressure eliminated
  // For the pressure increment: dp = gain (coupling^T du + lack).
  std::array<std::array<double, kCellPressures>, kCellDofs> coupling;
  std::array<double, kCellPressures> lack;  // residual of the volume equations, m3
  std::array<std::array<double, kCellPressures>, kCellPressures> gain;
  double lack_scale;  // size of the terms that `lack` is the difference of, m3
  double min_j;  // smallest volume ratio
  double energy;  // J; `force` and `lack` are derivatives of it
};

// The energy is that of neo-Hooke form A, with the pressure as a separate field,
//   W = mu/2 (I1 - 3 - 2 ln J) + p ln J - p^2/(2 lambda),
// so nu = 0.5 (1/lambda = 0) is not a special case and nothing locks.
//
// Fills `out` at displacements u and pressures p. For a nearly incompressible material (1/lambda
// below 1e-7/mu) condensing would lose digits, so `gain` is that of 1e-7/mu; repeated steps still
// drive `lack` to zero. Returns false when an integration point is turned inside out; `out` is then
// useless.
bool evaluate_cell(const CellGeometry& cell, const ElasticLaw& law,
                   const std::array<double, kCellDofs>& u,
                   const std::array<double, kCellPressures>& p, CellResult& out);

}  // namespace lcrig
