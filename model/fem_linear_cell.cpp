// SPDX-License-Identifier: Apache-2.0
#include "model/fem_linear_cell.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/fem_vector.hpp"
#include "model/gauss.hpp"

namespace lcrig {
namespace {

using Powers = std::array<std::array<double, kGauss5.size()>, kMostDegree>;

// Polynomials of degree 0, 1 ... at the points of Gauss, orthonormal with these weights.
Powers orthonormal(int count, const std::array<double, kGauss5.size()>& weight) {
  Powers q{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
    for (std::size_t i = 0; i < weight.size(); ++i) {
      q[k][i] = k == 0 ? 1 : q[k - 1][i] * kGauss5[i].x;
    }
    const auto product = [&](std::size_t l) {
      double sum = 0;
      for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * q[k][i] * q[l][i];
      return sum;
    };
    for (std::size_t l = 0; l < k; ++l) {
      const double along = product(l);
      for (std::size_t i = 0; i < weight.size(); ++i) q[k][i] -= along * q[l][i];
    }
    const double norm = std::sqrt(product(k));
    for (double& value : q[k]) value /= norm;
  }
  return q;
}

// The weight is a + b r.
AxisIntegrals integrals(int degree, double low, double high, double a, double b) {
  const double half = (high - low) / 2;
  std::array<double, kGauss5.size()> at{}, weight{};
  for (std::size_t i = 0; i < at.size(); ++i) {
    at[i] = (low + high) / 2 + half * kGauss5[i].x;
    weight[i] = kGauss5[i].weight * half * (a + b * at[i]);
  }
  const Powers q = orthonormal(degree, weight);
  const auto nodes = static_cast<std::size_t>(degree) + 1;
  AxisIntegrals sum;
  for (std::size_t i = 0; i < at.size(); ++i) {
    Lagrange n = lagrange(degree, kGauss5[i].x);
    for (double& slope : n.slope) slope /= half;
    for (std::size_t j = 0; j < nodes; ++j) {
      for (std::size_t k = 0; k < nodes; ++k) {
        sum.value[j][k] += weight[i] * n.value[j] * n.value[k];
        sum.slope[j][k] += weight[i] * n.slope[j] * n.slope[k];
        sum.mixed[j][k] += weight[i] * n.value[j] * n.slope[k];
        sum.inverse[j][k] += weight[i] * n.value[j] * n.value[k] / (at[i] * at[i]);
      }
      for (std::size_t p = 0; p + 1 < nodes; ++p) {
        sum.pressure[p][j] += weight[i] * q[p][i] * n.value[j];
        sum.slope_pressure[p][j] += weight[i] * q[p][i] * n.slope[j];
        sum.hoop_pressure[p][j] += weight[i] * q[p][i] * n.value[j] / at[i];
      }
    }
  }
  return sum;
}

// The stiffness of the energy 2 mu eps : eps.
void add_shear(std::size_t nodes, const AxisIntegrals& r, const AxisIntegrals& z, double mu,
               LinearCell& cell) {
  double* to = cell.shear.data();
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t a = 0; a < nodes; ++a) {
      for (std::size_t component = 0; component < 2; ++component) {
        const std::size_t own = i * nodes + a;
        for (std::size_t other = 0; other <= own; ++other) {
          const std::size_t j = other / nodes, b = other % nodes;
          if (component == 0) {
            *to++ = mu * (2 * (r.slope[a][b] + r.inverse[a][b]) * z.value[i][j] +
                          r.value[a][b] * z.slope[i][j]);
            if (other < own) *to++ = mu * r.mixed[a][b] * z.mixed[j][i];
          } else {
            *to++ = mu * r.mixed[b][a] * z.mixed[i][j];
            *to++ = mu * (2 * r.value[a][b] * z.slope[i][j] + r.slope[a][b] * z.value[i][j]);
          }
        }
      }
    }
  }
}

void add_coupling(std::size_t nodes, const AxisIntegrals& r, const AxisIntegrals& z,
                  LinearCell& cell) {
  double* to = cell.coupling.data();
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t a = 0; a < nodes; ++a) {
      for (std::size_t component = 0; component < 2; ++component) {
        double* next = to;
        for (std::size_t p = 0; p + 1 < nodes; ++p) {
          for (std::size_t q = 0; p + q + 1 < nodes; ++q) {
            *next++ = component == 0
                          ? (r.slope_pressure[p][a] + r.hoop_pressure[p][a]) * z.pressure[q][i]
                          : r.pressure[p][a] * z.slope_pressure[q][i];
          }
        }
        to += cell.pressures;
      }
    }
  }
}

void add_widened(std::size_t nodes, const AxisIntegrals& r, const AxisIntegrals& z, double mu,
                 LinearCell& cell) {
  std::size_t pressure = 0;
  for (std::size_t p = 0; p + 1 < nodes; ++p) {
    for (std::size_t q = 0; p + q + 1 < nodes; ++q, ++pressure) {
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < nodes; ++a) {
          cell.widened_volume[pressure] += r.hoop_pressure[p][a] * z.pressure[q][i];
        }
      }
    }
  }
  for (std::size_t own = 0; own < nodes * nodes; ++own) {
    for (std::size_t other = 0; other < nodes * nodes; ++other) {
      cell.widened_force[2 * own] +=
          2 * mu * r.inverse[own % nodes][other % nodes] * z.value[own / nodes][other / nodes];
    }
  }
}

// stiffness = shear + lambda coupling coupling^T
int add_pressure(LinearCell* cell) {
  const std::size_t pressures = cell->pressures;
  const double* shear = cell->shear.data();
  double* to = cell->stiffness.data();
  for (std::size_t i = 0; i < cell->dofs; ++i) {
    const double* own = &cell->coupling[i * pressures];
    for (std::size_t j = 0; j <= i; ++j) {
      const double* other = &cell->coupling[j * pressures];
      Four sum{};
      for (std::size_t k = 0; k < pressures; k += 4) sum += four(own + k) * four(other + k);
      *to++ = *shear++ + cell->condensed_lambda * (sum[0] + sum[1] + sum[2] + sum[3]);
    }
  }
  return 0;
}

int volumes_of(const LinearCell* cell, const double* u, double widened, double* volumes) {
  const double* coupling = cell->coupling.data();
  for (std::size_t k = 0; k < cell->pressures; k += 4) {
    four(volumes + k) += four(&cell->widened_volume[k]) * widened;
  }
  for (std::size_t i = 0; i < cell->dofs; ++i, coupling += cell->pressures) {
    for (std::size_t k = 0; k < cell->pressures; k += 4) {
      four(volumes + k) += four(coupling + k) * u[i];
    }
  }
  return 0;
}

// The shear matrix is symmetric, and only its lower triangle is stored.
int forces_of(const LinearCell* cell, const double* u, double widened, const double* pressures,
              double* forces) {
  const double *row = cell->shear.data(), *coupling = cell->coupling.data();
  for (std::size_t i = 0; i < cell->dofs; row += ++i, coupling += cell->pressures) {
    Four sums{};
    std::size_t j = 0;
    for (; j + 4 <= i; j += 4) {
      sums += four(row + j) * four(u + j);
      four(forces + j) += four(row + j) * u[i];
    }
    double sum = row[i] * u[i] + cell->widened_force[i] * widened;
    for (; j < i; ++j) {
      sum += row[j] * u[j];
      forces[j] += row[j] * u[i];
    }
    for (std::size_t k = 0; k < cell->pressures; k += 4) {
      sums += four(coupling + k) * four(pressures + k);
    }
    forces[i] += sum + sums[0] + sums[1] + sums[2] + sums[3];
  }
  return 0;
}

}  // namespace

AxisIntegrals radial_integrals(int degree, double r0, double r1) {
  return integrals(degree, r0, r1, 0, 2 * std::numbers::pi);
}

AxisIntegrals axial_integrals(int degree, double z0, double z1) {
  return integrals(degree, z0, z1, 1, 0);
}

LinearCell make_linear_cell(int degree, const AxisIntegrals& radial, const AxisIntegrals& axial,
                            const ElasticLaw& law) {
  const auto nodes = static_cast<std::size_t>(degree) + 1;
  LinearCell cell;
  cell.dofs = 2 * nodes * nodes;
  cell.pressures = ((nodes - 1) * nodes / 2 + 3) / 4 * 4;
  cell.inverse_lambda = law.inverse_lambda;
  cell.condensed_lambda = 1 / std::max(law.inverse_lambda, kLeastInverseLambda / law.mu);
  cell.shear.resize(cell.dofs * (cell.dofs + 1) / 2);
  cell.stiffness.resize(cell.shear.size());
  cell.coupling.resize(cell.dofs * cell.pressures);
  cell.widened_force.resize(cell.dofs);
  cell.widened_volume.resize(cell.pressures);
  add_widened(nodes, radial, axial, law.mu, cell);
  add_shear(nodes, radial, axial, law.mu, cell);
  add_coupling(nodes, radial, axial, cell);
  run_fast<add_pressure>(&cell);
  return cell;
}

void add_volumes(const LinearCell& cell, const double* u, double widened, double* volumes) {
  run_fast<volumes_of>(&cell, u, widened, volumes);
}

void add_forces(const LinearCell& cell, const double* u, double widened, const double* pressures,
                double* forces) {
  run_fast<forces_of>(&cell, u, widened, pressures, forces);
}

}  // namespace lcrig
