// SPDX-License-Identifier: Apache-2.0
#include "model/fit_cells.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace lcrig {
namespace {

// Pressures that differ by less count as one: the force of a level repeats to about a percent.
constexpr double kSamePressure = 0.02;
constexpr std::size_t kLeastPressures = 3;  // modulus, offset and the shape that tests them
// Rounding and interpolation are above this share of the span.
constexpr double kLeastNoise = 1e-7;

Result<> check_points(const std::vector<FitPoint>& points) {
  std::vector<double> pressures;
  for (const FitPoint& p : points) {
    if (!std::isfinite(p.pressure_Pa) || !std::isfinite(p.delta_capacitance_F)) {
      return fail(Errc::invalid_request, "fit: a point is not a number");
    }
    if (p.pressure_Pa > 0) pressures.push_back(p.pressure_Pa);
  }
  std::sort(pressures.begin(), pressures.end());
  std::vector<double> different;
  for (const double Pa : pressures) {
    if (different.empty() || Pa > different.back() * (1 + kSamePressure)) different.push_back(Pa);
  }
  if (different.size() >= kLeastPressures) return {};
  if (different.empty()) {
    return fail(Errc::invalid_request, "fit: no level was measured under load");
  }
  return fail(Errc::invalid_request,
              "fit: the levels have {} different pressure{} (up to {:.4g} kPa); modulus and "
              "contact offset, and the test of the fit, need levels at {} pressures or more",
              different.size(), different.size() == 1 ? "" : "s", different.back() * 1e-3,
              kLeastPressures);
}

// Points by cell and repeat.
using CellTable = std::map<std::int32_t, std::map<std::int32_t, const FitPoint*>>;

CellTable cell_table_of(const std::vector<FitPoint>& points) {
  CellTable table;
  std::map<std::int32_t, std::int32_t> count;
  for (const FitPoint& p : points) {
    const std::int32_t cell = p.cell != 0 ? p.cell : ++count[p.repeat];
    table[cell].emplace(p.repeat, &p);
  }
  return table;
}

FitPoint mean_of(const std::map<std::int32_t, const FitPoint*>& row) {
  FitPoint mean;
  const auto n = static_cast<double>(row.size());
  mean.memory_Pa.assign(row.begin()->second->memory_Pa.size(), 0.0);
  for (const auto& [repeat, p] : row) {
    mean.pressure_Pa += p->pressure_Pa / n;
    mean.delta_capacitance_F += p->delta_capacitance_F / n;
    mean.time_s += p->time_s / n;
    mean.held_decades += p->held_decades / n;
    mean.gap_F += p->gap_F / n;
    for (std::size_t k = 0; k < mean.memory_Pa.size(); ++k) {
      mean.memory_Pa[k] += p->memory_Pa[k] / n;
    }
  }
  return mean;
}

// A repeat's own pressure is not quite the mean one; the difference is moved along the mean curve.
double slope_near(const std::vector<FitPoint>& means, std::size_t i) {
  if (means[i].pressure_Pa <= 0) return 0;
  return means[i].delta_capacitance_F / means[i].pressure_Pa;
}

void fill_deviations(const CellTable& table, FitCells& out) {
  std::map<std::int32_t, Eigen::Index> column;
  for (const auto& [cell, row] : table) {
    for (const auto& [repeat, p] : row) column.try_emplace(repeat, std::ssize(column));
  }
  out.repeat_count = static_cast<int>(column.size());
  out.deviations = Eigen::MatrixXd::Zero(out.size(), std::ssize(column));
  out.memory_deviations.assign(out.mean.front().memory_Pa.size() + 1, out.deviations);
  std::size_t i = 0;
  for (const auto& [cell, row] : table) {
    const double slope = slope_near(out.mean, i);
    for (const auto& [repeat, p] : row) {
      const auto at = static_cast<Eigen::Index>(i);
      const FitPoint& mean = out.mean[i];
      out.deviations(at, column[repeat]) = p->delta_capacitance_F - mean.delta_capacitance_F -
                                           slope * (p->pressure_Pa - mean.pressure_Pa);
      for (std::size_t k = 0; k < mean.memory_Pa.size(); ++k) {
        out.memory_deviations[k](at, column[repeat]) = p->memory_Pa[k] - mean.memory_Pa[k];
      }
      out.memory_deviations.back()(at, column[repeat]) =
          mean.pressure_Pa * (p->held_decades - mean.held_decades);
    }
    ++i;
  }
}

// Noise of the means as the readings tell it.
void fill_noise(const CellTable& table, FitCells& out) {
  out.told_noise = Eigen::VectorXd::Zero(out.size());
  Eigen::Index i = 0;
  for (const auto& [cell, row] : table) {
    const auto n = static_cast<double>(row.size());
    for (const auto& [repeat, p] : row) {
      out.told_noise(i) += std::pow(p->standard_error_F / n, 2);
    }
    ++i;
  }
  out.told = out.told_noise.minCoeff() > 0;
  if (!out.told) out.told_noise.setConstant(std::pow(1e-3 * out.span_F, 2));
  const double least_F = kLeastNoise * out.span_F;
  out.told_noise = out.told_noise.cwiseMax(least_F * least_F);
}

}  // namespace

void FitCells::judge_repeats(const Eigen::MatrixXd& without_creep) {
  const Eigen::Index n = size(), r = without_creep.cols();
  noise = told_noise;
  repeats = Eigen::MatrixXd::Zero(n, n);
  if (r < 2) return;
  // An offset and a gain of every repeat. Their covariance is that of the means; what is left
  // beyond the noise of the readings scales the noise (Birge's ratio).
  Eigen::MatrixXd shape = Eigen::MatrixXd::Zero(n, 2);  // 0 at rest, where nothing touches
  for (Eigen::Index i = 0; i < n; ++i) {
    const FitPoint& p = mean[static_cast<std::size_t>(i)];
    if (p.pressure_Pa > 0) shape.row(i) << 1, p.delta_capacitance_F / span_F;
  }
  const Eigen::MatrixXd effects = shape.colPivHouseholderQr().solve(without_creep);  // 2 x r
  const auto count = static_cast<double>(r);
  repeats = shape * (effects * effects.transpose()) * shape.transpose() / (count * (count - 1));
  const Eigen::MatrixXd left = without_creep - shape * effects;
  const double freedom = (count - 1) * static_cast<double>(n - 2);
  double ratio = 0;  // of squares, seen over expected; the noise is that of the mean
  for (Eigen::Index i = 0; i < n; ++i) {
    ratio += left.row(i).squaredNorm() / (told_noise(i) * count) / freedom;
  }
  noise *= told ? std::max(1.0, ratio) : ratio;
  const double least_F = kLeastNoise * span_F;
  noise = noise.cwiseMax(least_F * least_F);
}

Result<FitCells> cells_of(const FitData& data) {
  if (auto ok = check_points(data.points); !ok) return fail(ok.error());
  const CellTable table = cell_table_of(data.points);
  FitCells out;
  for (const auto& [cell, row] : table) {
    const FitPoint& p = out.mean.emplace_back(mean_of(row));
    out.highest_Pa = std::max(out.highest_Pa, p.pressure_Pa);
    out.span_F = std::max(out.span_F, std::abs(p.delta_capacitance_F));
  }
  if (!(out.span_F > 0)) {
    return fail(Errc::invalid_request, "fit: the capacitance does not change with the load");
  }
  fill_deviations(table, out);
  fill_noise(table, out);
  out.judge_repeats(out.deviations);
  return out;
}

}  // namespace lcrig
