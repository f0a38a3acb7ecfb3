// SPDX-License-Identifier: Apache-2.0
// One axisymmetric rectangle of linear elasticity, of any degree up to kMostDegree, for the level
// `fem_linear`: displacement of that degree in each direction, discontinuous pressure of one degree
// less in both together. On a rectangle every integral is a product of one along the radius and one
// along the height. docs/model.md, "Elements".
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "model/fem_space.hpp"
#include "model/lagrange.hpp"

namespace lcrig {

// Polynomials of the pressure along one axis, orthonormal in the weight of the integral, so that
// the pressures of a cell have the identity as their mass matrix.
using AxisTable = std::array<std::array<double, kMostNodes>, kMostNodes>;

// Integrals of shape functions along one axis, from low to high.
struct AxisIntegrals {
  AxisTable value{}, slope{};  // of N_a N_b and N_a' N_b', with the weight
  AxisTable mixed{};  // of N_a N_b', with the weight
  AxisTable inverse{};  // of N_a N_b over the radius
  AxisTable pressure{};  // of Q_p N_a, with the weight
  AxisTable slope_pressure{}, hoop_pressure{};  // of Q_p N_a', and of Q_p N_a over the radius
};
// Weight: 2 pi r along the radius, 1 along the height.
AxisIntegrals radial_integrals(int degree, double r0_m, double r1_m);
AxisIntegrals axial_integrals(int degree, double z0_m, double z1_m);

struct LinearCell {
  std::size_t dofs;
  std::size_t pressures;  // a multiple of four; the last ones may be of no polynomial and zero
  double inverse_lambda;  // 1/Pa
  double condensed_lambda;  // Pa, at most 1e7 mu; the true one is reached by iterating
  std::vector<double> shear;  // lower triangle by rows, N/m: without the pressure
  std::vector<double> stiffness;  // the same, with the pressure condensed
  std::vector<double> coupling;  // by displacement, then pressure
  // Forces and volumes of a radial displacement by one of every node. A thin stiff cell that moves
  // as a whole would get rounding for a force from its stiffness; a motion along the axis has none.
  std::vector<double> widened_force, widened_volume;
};
// Displacements are ordered by line, node along the line, component.
LinearCell make_linear_cell(int degree, const AxisIntegrals& radial, const AxisIntegrals& axial,
                            const ElasticLaw& law);
// Effect of displacements u beside a radial motion of every node by `widened`: the volume that each
// pressure sees and, with the pressures, the forces of the nodes.
void add_volumes(const LinearCell& cell, const double* u, double widened, double* volumes);
void add_forces(const LinearCell& cell, const double* u, double widened, const double* pressures,
                double* forces);

}  // namespace lcrig
