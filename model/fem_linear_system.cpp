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

// A stiff thin cell high in the stack moves far as a whole, and the last digit of its displacement
// already means a force. Convergence is therefore judged by the work of the last step and not by
// the residual. A step with this share of the load's work moves nothing by more than the square
// root of it, in the energy norm.
constexpr double kLeastWork = 1e-18;
// Below this work only rounding is left once a step does not do less work than the one before.
constexpr double kRoundingWork = 1e-13;
constexpr double kSameHeight = 1e-12;  // heights of rows that differ by rounding
constexpr int kMostSolves = 12;
constexpr std::size_t kMostDofs = 2 * kMostNodes * kMostNodes;
constexpr std::size_t kPaddedPressures = (kMostDegree * (kMostDegree + 1) / 2 + 3) / 4 * 4;
constexpr std::size_t kMostPadded = (kMostDofs + kTileRows - 1) / kTileRows * kTileRows;

double product(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

}  // namespace

LinearSystem::LinearSystem(const StackSpace& space) : space_(space) {
  const auto nodes = static_cast<std::size_t>(space.degree()) + 1;
  dofs_ = 2 * nodes * nodes;
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
  order_ = inner_nodes_first(space.degree());
  find_kinds();
  pressures_ = kinds_.front().pressures;
  p_.assign(pressures_ * kind_.size(), 0);
  number_outer();
  solver_.analyze({outer_numbers_, dofs_ - order_.inner}, static_cast<std::size_t>(columns),
                  outer_.size());
}

void LinearSystem::number_outer() {
  std::vector<int> numbers(static_cast<std::size_t>(space_.equations()), -1);
  outer_numbers_.reserve((dofs_ - order_.inner) * kind_.size());
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    for (std::size_t i = order_.inner; i < dofs_; ++i) {
      const int equation = equations_[dofs_ * cell + order_.all[i]];
      if (equation < 0) {
        outer_numbers_.push_back(-1);
        continue;
      }
      int& number = numbers[static_cast<std::size_t>(equation)];
      if (number < 0) {
        number = static_cast<int>(outer_.size());
        outer_.push_back(static_cast<std::size_t>(equation));
      }
      outer_numbers_.push_back(number);
    }
  }
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
        condensed_.emplace_back(kinds_.back(), order_);
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
    lcrig::add_volumes(kinds_[kind_[cell]], local.data(), widened, &volumes[pressures_ * cell]);
  }
}

void LinearSystem::evaluate(const std::vector<double>& u) {
  lack_.assign(p_.size(), 0);
  add_volumes(u, lack_);
  residual_ = space_.unit_load();
  std::array<double, kMostDofs> local, force;
  std::array<double, kPaddedPressures> pressure;
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    const LinearCell& kind = kinds_[kind_[cell]];
    const double widened = gather(u, cell, local.data());
    const double* p = &p_[pressures_ * cell];
    double* lack = &lack_[pressures_ * cell];
    for (std::size_t k = 0; k < pressures_; ++k) {
      lack[k] -= kind.inverse_lambda * p[k];
      pressure[k] = p[k] + kind.condensed_lambda * lack[k];
    }
    force.fill(0);
    add_forces(kind, local.data(), widened, pressure.data(), force.data());
    for (std::size_t i = 0; i < dofs_; ++i) {
      const int equation = equations_[dofs_ * cell + i];
      if (equation >= 0) residual_[static_cast<std::size_t>(equation)] -= force[i];
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

std::vector<double> LinearSystem::answer(const std::vector<double>& forces) {
  std::vector<double> x = forces;
  std::array<double, kMostPadded> local;
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    local.fill(0);
    const int* equations = &equations_[dofs_ * cell];
    for (std::size_t i = 0; i < order_.inner; ++i) {
      local[i] = x[static_cast<std::size_t>(equations[order_.all[i]])];
    }
    condensed_[kind_[cell]].forward(local.data());
    for (std::size_t i = 0; i < dofs_; ++i) {
      const int equation = equations[order_.all[i]];
      if (equation < 0) continue;
      double& to = x[static_cast<std::size_t>(equation)];
      to = i < order_.inner ? local[i] : to + local[i];
    }
  }
  std::vector<double> outer;
  outer.reserve(outer_.size());
  for (const std::size_t equation : outer_) outer.push_back(x[equation]);
  outer = solver_.solve(outer);
  for (std::size_t i = 0; i < outer_.size(); ++i) x[outer_[i]] = outer[i];
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    local.fill(0);
    const int* equations = &equations_[dofs_ * cell];
    for (std::size_t i = 0; i < dofs_; ++i) {
      const int equation = equations[order_.all[i]];
      if (equation >= 0) local[i] = x[static_cast<std::size_t>(equation)];
    }
    condensed_[kind_[cell]].backward(local.data());
    for (std::size_t i = 0; i < order_.inner; ++i) {
      x[static_cast<std::size_t>(equations[order_.all[i]])] = local[i];
    }
  }
  return x;
}

LinearSystem::Report LinearSystem::solve(std::vector<double>& u) {
  Report report;
  u.assign(static_cast<std::size_t>(space_.equations()), 0);
  std::vector<const double*> stiffness;
  stiffness.reserve(kind_.size());
  for (const std::size_t kind : kind_) stiffness.push_back(condensed_[kind].stiffness());
  const bool inner =
      std::all_of(condensed_.begin(), condensed_.end(), [](const auto& c) { return c.valid(); });
  if (!inner || !solver_.factorize(stiffness)) {
    report.why = "the stiffness is singular";
    return report;
  }
  residual_ = space_.unit_load();
  lack_.assign(p_.size(), 0);
  for (; report.iterations < kMostSolves; ++report.iterations) {
    const auto step = answer(residual_);
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

LinearSystem::Balance LinearSystem::balance(const std::vector<double>& u) {
  evaluate(u);
  double lack = 0, scale = 0;
  std::array<double, kMostDofs> local, force;
  std::array<double, kPaddedPressures> missing;
  const std::array<double, kMostDofs> still{};
  for (std::size_t cell = 0; cell < kind_.size(); ++cell) {
    const LinearCell& kind = kinds_[kind_[cell]];
    const double widened = gather(u, cell, local.data());
    for (std::size_t k = 0; k < pressures_; ++k) {
      missing[k] = kind.condensed_lambda * lack_[pressures_ * cell + k];
      lack += std::abs(lack_[pressures_ * cell + k]);
      scale += std::abs(kind.widened_volume[k] * widened);
      for (std::size_t i = 0; i < dofs_; ++i) {
        scale += std::abs(kind.coupling[pressures_ * i + k] * local[i]);
      }
    }
    // evaluate() has taken the pressures for the residual that the lack of volume will make
    force.fill(0);
    add_forces(kind, still.data(), 0, missing.data(), force.data());
    for (std::size_t i = 0; i < dofs_; ++i) {
      const int equation = equations_[dofs_ * cell + i];
      if (equation >= 0) residual_[static_cast<std::size_t>(equation)] += force[i];
    }
  }
  const auto& load = space_.unit_load();
  return {std::sqrt(product(residual_, residual_) / product(load, load)), lack / scale};
}

}  // namespace lcrig
