// SPDX-License-Identifier: Apache-2.0
#include "model/fem_linear_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace lcrig {
namespace {

// Stiff thin cells high in the stack move a long way as a whole, and the last digit of their
// displacement is already a force. So it is not the residual that must be small but the work of the
// last step: a step with this share of the load's work moves nothing by more than the square root
// of it, in the energy norm.
constexpr double kLeastWork = 1e-18;
// When the steps stop doing less work than the one before, below this, only rounding is left.
constexpr double kRoundingWork = 1e-13;
constexpr double kSameHeight = 1e-12;  // heights of rows that differ by rounding
constexpr int kMostSolves = 12;
constexpr std::size_t kMostDofs = 2 * kMostNodes * kMostNodes;

double product(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// force += matrix u, for a symmetric matrix by its lower triangle.
void multiply(const std::vector<double>& matrix, std::size_t size, const double* u, double* force) {
  const double* row = matrix.data();
  for (std::size_t i = 0; i < size; row += ++i) {
    double sum = row[i] * u[i];
    for (std::size_t j = 0; j < i; ++j) {
      sum += row[j] * u[j];
      force[j] += row[j] * u[i];
    }
    force[i] += sum;
  }
}

}  // namespace

LinearSystem::LinearSystem(const StackSpace& space) : space_(space) {
  const auto nodes = static_cast<std::size_t>(space.degree()) + 1;
  dofs_ = 2 * nodes * nodes;
  pressures_ = (nodes - 1) * nodes / 2;
  const int columns = space.cells_per_row();
  for (const auto& row : space.rows()) {
    for (int c = 0; c < columns; ++c) {
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < nodes; ++a) {
          const int node = space.degree() * c + static_cast<int>(a);
          equations_.push_back(space.equation(row.line[i], node, 0));
          equations_.push_back(space.equation(row.line[i], node, 1));
        }
      }
    }
  }
  find_kinds();
  p_.assign(pressures_ * kind_.size(), 0);
  solver_.analyze({equations_, dofs_}, static_cast<std::size_t>(columns),
                  static_cast<std::size_t>(space.equations()));
}

void LinearSystem::find_kinds() {
  const auto& rows = space_.rows();
  const auto& r = space_.radii();
  const auto degree = static_cast<std::size_t>(space_.degree());
  const auto columns = static_cast<std::size_t>(space_.cells_per_row());
  std::vector<AxisIntegrals> radial;
  for (std::size_t c = 0; c < columns; ++c) {
    radial.push_back(radial_integrals(space_.degree(), r[degree * c], r[degree * (c + 1)]));
  }
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const double height = rows[row].z1 - rows[row].z0;
    std::size_t twin = 0;
    while (twin < row &&
           !(rows[twin].law == rows[row].law &&
             std::abs(rows[twin].z1 - rows[twin].z0 - height) <= kSameHeight * height)) {
      ++twin;
    }
    const auto axial = axial_integrals(space_.degree(), 0, height);
    for (std::size_t c = 0; c < columns; ++c) {
      kind_.push_back(twin < row ? kind_[twin * columns + c] : kinds_.size());
      if (twin == row) {
        kinds_.push_back(make_linear_cell(space_.degree(), radial[c], axial, rows[row].law));
      }
    }
  }
}

double LinearSystem::gather(const std::vector<double>& u, std::size_t cell, double* local) const {
  const int* equations = &equations_[dofs_ * cell];
  for (std::size_t i = 0; i < dofs_; ++i) {
    local[i] = equations[i] >= 0 ? u[static_cast<std::size_t>(equations[i])] : 0;
  }
  const double radial = local[dofs_ - 2], axial = local[dofs_ - 1];
  for (std::size_t i = 0; i < dofs_; i += 2) {
    local[i] -= radial;
    local[i + 1] -= axial;
  }
  return radial;
}

void LinearSystem::add_volumes(const std::vector<double>& u, std::vector<double>& volumes) const {
  std::array<double, kMostDofs> local;
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    const double widened = gather(u, cell, local.data());
    const LinearCell& kind = kinds_[kind_[cell]];
    const double* coupling = kind.coupling.data();
    double* to = &volumes[pressures_ * cell];
    for (std::size_t k = 0; k < pressures_; ++k) to[k] += kind.widened_volume[k] * widened;
    for (std::size_t i = 0; i < dofs_; ++i, coupling += pressures_) {
      for (std::size_t k = 0; k < pressures_; ++k) to[k] += coupling[k] * local[i];
    }
  }
}

void LinearSystem::evaluate(const std::vector<double>& u) {
  lack_.assign(p_.size(), 0);
  add_volumes(u, lack_);
  residual_ = space_.unit_load();
  std::array<double, kMostDofs> local, force;
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    const LinearCell& kind = kinds_[kind_[cell]];
    const double widened = gather(u, cell, local.data());
    for (std::size_t i = 0; i < dofs_; ++i) force[i] = kind.widened_force[i] * widened;
    multiply(kind.shear, dofs_, local.data(), force.data());
    const double* p = &p_[pressures_ * cell];
    double* lack = &lack_[pressures_ * cell];
    for (std::size_t k = 0; k < pressures_; ++k) lack[k] -= kind.inverse_lambda * p[k];
    const double* coupling = kind.coupling.data();
    for (std::size_t i = 0; i < dofs_; ++i, coupling += pressures_) {
      const int equation = equations_[dofs_ * cell + i];
      if (equation < 0) continue;
      double held = force[i], lacking = 0;
      for (std::size_t k = 0; k < pressures_; ++k) {
        held += coupling[k] * p[k];
        lacking += coupling[k] * lack[k];
      }
      residual_[static_cast<std::size_t>(equation)] -= held + kind.condensed_lambda * lacking;
    }
  }
}

void LinearSystem::take_pressure_step(const std::vector<double>& step) {
  add_volumes(step, lack_);
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    const double lambda = kinds_[kind_[cell]].condensed_lambda;
    for (std::size_t k = pressures_ * cell; k < pressures_ * (cell + 1); ++k) {
      p_[k] += lambda * lack_[k];
    }
  }
}

LinearSystem::Report LinearSystem::solve(std::vector<double>& u) {
  Report report;
  u.assign(static_cast<std::size_t>(space_.equations()), 0);
  std::vector<const double*> stiffness;
  for (const std::size_t kind : kind_) stiffness.push_back(kinds_[kind].stiffness.data());
  if (!solver_.factorize(stiffness)) {
    report.why = "the stiffness is singular";
    return report;
  }
  residual_ = space_.unit_load();
  lack_.assign(p_.size(), 0);
  for (; report.iterations < kMostSolves; ++report.iterations) {
    const auto step = solver_.solve(residual_);
    const double work = std::abs(product(step, residual_));
    for (std::size_t i = 0; i < u.size(); ++i) u[i] += step[i];
    take_pressure_step(step);
    const double before =
        std::exchange(report.work, work / std::abs(product(space_.unit_load(), u)));
    const bool rounding =
        report.iterations > 0 && report.work <= kRoundingWork && report.work > before / 2;
    report.converged = report.work <= kLeastWork || rounding;
    if (report.converged) return report;
    evaluate(u);
  }
  report.why = fmt::format("the work of the last step is still {:.2g} of the load's", report.work);
  return report;
}

}  // namespace lcrig
