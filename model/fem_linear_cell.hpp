// SPDX-License-Identifier: Apache-2.0
// One axisymmetric rectangle of linear elasticity of any degree up to kMostDegree, for the level
// `fem_linear`. The displacement has that degree in each direction. The pressure is discontinuous,
// and its degree is one less in both directions together. On a rectangle every integral is a
// product of one along the radius and one along the height. docs/model.md, "Elements".
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "model/fem_space.hpp"
#include "model/lagrange.hpp"

namespace lcrig {

// Polynomials of the pressure along one axis. They are orthonormal in the weight of the integral,
// so the mass matrix of a cell's pressures is the identity.
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
  std::size_t pressures;  // a multiple of four; the last ones may be unused and zero
  double inverse_lambda;  // 1/Pa
  double condensed_lambda;  // Pa, at most 1e7 mu; iterating reaches the true value
  std::vector<double> shear;  // lower triangle by rows, N/m: without the pressure
  std::vector<double> stiffness;  // the same with the pressure condensed
  std::vector<double> coupling;  // by displacement, then by pressure
  // Forces and volumes when every node moves radially by one. When a thin stiff cell moves as a
  // whole, its stiffness would produce a force from rounding errors alone; these members avoid
  // that. A motion along the axis has no such force.
  std::vector<double> widened_force, widened_volume;
};
// Displacements are ordered by line, node along the line, component.
LinearCell make_linear_cell(int degree, const AxisIntegrals& radial, const AxisIntegrals& axial,
                            const ElasticLaw& law);
// Effect of displacements u plus a radial motion of every node by `widened`: the volume that each
// pressure sees and, with the pressures, the forces on the nodes.
void add_volumes(const LinearCell& cell, const double* u, double widened, double* volumes);
void add_forces(const LinearCell& cell, const double* u, double widened, const double* pressures,
                double* forces);

}  // namespace lcrig
