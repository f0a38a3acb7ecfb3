// SPDX-License-Identifier: Apache-2.0
#include "model/fem_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lcrig {
namespace {

constexpr double kTolerance = 1e-9;
constexpr double kDefectTolerance = 1e-10;
// A stiff thin cell high in the stack moves far as a whole, and the last digit of its displacement
// already means a force. When the residual stops falling below this limit, only such rounding is
// left.
constexpr double kAcceptable = 1e-7;
// Rounding forces in stiff cells do almost no work. A step whose work has this ratio to the load's
// work moves nothing by more than the square root of the ratio, in the energy norm.
constexpr double kNoWork = 1e-18;
constexpr double kShortestStep = 1.0 / 64;
constexpr double kRise = 2;
constexpr double kSmallResidual = 1e-3;  // below this the residual may rise again

double norm(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

}  // namespace

FemSystem::FemSystem(const StackSpace& space) : space_(space) {
  const int columns = space.cells_per_row();
  for (const auto& row : space.rows()) {
    for (int c = 0; c < columns; ++c) {
      const auto left = 2 * static_cast<std::size_t>(c);
      geometry_.push_back({space.radii()[left], space.radii()[left + 2], row.z0, row.z1});
      laws_.push_back(row.law);
      for (std::size_t a = 0; a < kCellNodes; ++a) {
        const int node = 2 * c + static_cast<int>(a % 3);
        equations_.push_back(space.equation(row.line[a / 3], node, 0));
        equations_.push_back(space.equation(row.line[a / 3], node, 1));
      }
    }
  }
  condensed_.resize(geometry_.size());
  stiffness_.resize(geometry_.size());
  for (const CellStiffness& cell : stiffness_) by_cell_.push_back(cell.data());
  solver_.analyze({equations_, kCellDofs}, static_cast<std::size_t>(columns),
                  static_cast<std::size_t>(space.equations()));
}

FemState FemSystem::rest() const {
  return {std::vector<double>(static_cast<std::size_t>(space_.equations()), 0.0),
          std::vector<double>(static_cast<std::size_t>(kCellPressures) * geometry_.size(), 0.0)};
}

void FemSystem::gather(const FemState& state, std::size_t cell, std::array<double, kCellDofs>& u,
                       std::array<double, kCellPressures>& p) const {
  const int* eq = &equations_[kCellDofs * cell];
  for (std::size_t i = 0; i < kCellDofs; ++i) {
    u[i] = eq[i] >= 0 ? state.u[static_cast<std::size_t>(eq[i])] : 0;
  }
  for (std::size_t k = 0; k < kCellPressures; ++k) p[k] = state.p[kCellPressures * cell + k];
}

FemSystem::Residual FemSystem::assemble(const FemState& state, double pressure_Pa) {
  Residual result;
  residual_ = space_.unit_load();
  for (double& force : residual_) force *= pressure_Pa;
  // residual of the original equations, before the pressures are eliminated
  std::vector<double> plain = residual_;
  const double load = norm(plain);
  CellResult out;
  std::array<double, kCellDofs> u;
  std::array<double, kCellPressures> p;
  double lack = 0, scale = 0;
  for (std::size_t cell = 0; cell < geometry_.size(); ++cell) {
    gather(state, cell, u, p);
    if (!evaluate_cell(geometry_[cell], laws_[cell], u, p, out)) {
      return result;
    }
    condensed_[cell] = {out.coupling, out.lack, out.gain};
    result.min_j = std::min(result.min_j, out.min_j);
    lack += std::abs(out.lack[0]) + std::abs(out.lack[1]) + std::abs(out.lack[2]);
    scale += out.lack_scale;
    for (std::size_t i = 0; i < kCellDofs; ++i) {
      if (const int eq = equations_[kCellDofs * cell + i]; eq >= 0) {
        residual_[static_cast<std::size_t>(eq)] -= out.condensed_force[i];
        plain[static_cast<std::size_t>(eq)] -= out.force[i];
      }
    }
    auto value = stiffness_[cell].begin();
    for (std::size_t i = 0; i < kCellDofs; ++i) {
      value = std::copy_n(out.stiffness[i].begin(), i + 1, value);
    }
  }
  result.valid = true;
  result.force = load > 0 ? norm(plain) / load : norm(plain);
  result.defect = scale > 0 ? lack / scale : 0;
  return result;
}

std::vector<double> FemSystem::pressure_step(const std::vector<double>& du) const {
  std::vector<double> dp(kCellPressures * condensed_.size());
  for (std::size_t c = 0; c < condensed_.size(); ++c) {
    auto volume = condensed_[c].lack;
    for (std::size_t i = 0; i < kCellDofs; ++i) {
      const int eq = equations_[kCellDofs * c + i];
      const double move = eq >= 0 ? du[static_cast<std::size_t>(eq)] : 0;
      for (std::size_t k = 0; k < kCellPressures; ++k) {
        volume[k] += condensed_[c].coupling[i][k] * move;
      }
    }
    for (std::size_t k = 0; k < kCellPressures; ++k) {
      const auto& g = condensed_[c].gain[k];
      dp[kCellPressures * c + k] = g[0] * volume[0] + g[1] * volume[1] + g[2] * volume[2];
    }
  }
  return dp;
}

// Takes the longest of 1, 1/2, 1/4 ... of the step that turns no cell inside out and does not
// increase the residual much. The residual of a mixed method may rise a little before it falls.
FemSystem::Residual FemSystem::line_search(double pressure_Pa, const Step& step, double start,
                                           FemState& state) {
  const double allowed = kRise * std::max(start, kSmallResidual);
  for (double length = 1; length >= kShortestStep; length /= 2) {
    FemState next = state;
    for (std::size_t i = 0; i < next.u.size(); ++i) next.u[i] += length * step.du[i];
    for (std::size_t i = 0; i < next.p.size(); ++i) next.p[i] += length * step.dp[i];
    const Residual residual = assemble(next, pressure_Pa);
    if (residual.valid && residual.force <= allowed) {
      state = std::move(next);
      return residual;
    }
  }
  return {};
}

std::optional<FemSystem::Step> FemSystem::direction() {
  if (!solver_.factorize(by_cell_)) return std::nullopt;
  Step step{solver_.solve(residual_), {}};
  step.dp = pressure_step(step.du);
  return std::isfinite(norm(step.du)) ? std::optional(std::move(step)) : std::nullopt;
}

FemSystem::Newton FemSystem::solve(double pressure_Pa, FemState& state, int most) {
  Newton report;
  FemState at = state;
  Residual residual = assemble(at, pressure_Pa);
  double previous = 1e300;
  for (;; ++report.iterations) {
    if (!residual.valid) {
      report.why = report.iterations == 0
                       ? "the starting point has a cell turned inside out"
                       : "no step along Newton's direction keeps the residual down";
      return report;
    }
    report.residual = residual.force;
    report.defect = residual.defect;
    report.min_j = residual.min_j;
    report.history.push_back(residual.force);
    const bool small = residual.force <= kTolerance && residual.defect <= kDefectTolerance;
    const bool stalled = residual.force > previous / 2;
    const bool rounding = stalled && residual.force <= kAcceptable;
    previous = residual.force;
    if (small || (rounding && residual.defect <= kDefectTolerance)) {
      report.converged = true;
      state = std::move(at);
      return report;
    }
    if (report.iterations == most) {
      report.why =
          fmt::format("Newton's method did not converge in {} iterations (residual {:.2g})", most,
                      residual.force);
      return report;
    }
    const auto step = direction();
    if (!step) {
      report.why = "the tangent stiffness is singular";
      return report;
    }
    const double work = std::abs(dot(step->du, residual_)) /
                        (pressure_Pa * std::abs(dot(space_.unit_load(), at.u)));
    if (stalled && work <= kNoWork && residual.defect <= kDefectTolerance) {
      report.converged = true;
      state = std::move(at);
      return report;
    }
    const double start = report.iterations == 0 ? 1e300 : residual.force;
    residual = line_search(pressure_Pa, *step, start, at);
  }
}

}  // namespace lcrig
