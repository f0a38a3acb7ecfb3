// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/force_bound.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcrig {

namespace {

// Cells of a geometric grid of forces, fine enough that a contact hardly stiffens within one.
constexpr double kFirst_N = 1e-3;  // no tolerance
constexpr double kRatio = 1.05;  // no tolerance
constexpr std::size_t kCells = 400;  // no tolerance: reaches 3e5 N

double edge_N(std::size_t i) {  // lower end of cell i
  return i == 0 ? 0 : kFirst_N * std::pow(kRatio, static_cast<double>(i - 1));
}

std::size_t cell_of(double force_N) {
  if (!(force_N > kFirst_N)) return 0;
  // Also caps an infinite force before the conversion to an integer.
  const double i = std::floor(std::log(force_N / kFirst_N) / std::log(kRatio)) + 1;
  return static_cast<std::size_t>(std::min(i, static_cast<double>(kCells - 1)));
}

const std::vector<double>& edges() {
  static const std::vector<double> all = [] {
    std::vector<double> out;
    for (std::size_t i = 0; i <= kCells; ++i) out.push_back(edge_N(i));
    return out;
  }();
  return all;
}

}  // namespace

ForceBound::ForceBound(const Compression& specimen_m, double frame_stiffness_N_m) {
  const auto& edge = edges();
  std::vector<double> at(kCells + 1, 0.0);
  for (std::size_t i = 1; i <= kCells; ++i) {
    at[i] = edge[i] / frame_stiffness_N_m + (specimen_m ? specimen_m(edge[i]) : 0);
  }
  for (std::size_t i = 0; i < kCells; ++i) {
    const double way = at[i + 1] - at[i];
    // A specimen that gives way no further is infinitely stiff.
    stiffness_.push_back(way > 0 ? (edge[i + 1] - edge[i]) / way
                                 : std::numeric_limits<double>::infinity());
  }
  // The mean stiffness of a cell is too small at its stiffer end. That of the next cell is large
  // enough there.
  for (std::size_t i = 0; i + 1 < kCells; ++i) {
    stiffness_[i] = std::max(stiffness_[i], stiffness_[i + 1]);
  }
}

ForceBound ForceBound::from_table(std::vector<double> stiffness_N_m) {
  ForceBound out;
  out.stiffness_ = std::move(stiffness_N_m);
  out.stiffness_.resize(kCells, std::numeric_limits<double>::infinity());
  return out;
}

void ForceBound::limit_to(double stiffness_N_m,
                          const std::function<double(double force_N)>& growth) {
  for (std::size_t i = 0; i < kCells; ++i) {
    stiffness_[i] = std::min(stiffness_[i], stiffness_N_m * growth(edges()[i + 1]));
  }
}

void ForceBound::at_least(const ForceBound& other) {
  for (std::size_t i = 0; i < kCells; ++i) {
    stiffness_[i] = std::max(stiffness_[i], other.stiffness_[i]);
  }
}

bool ForceBound::is_bounded() const {
  return std::isfinite(stiffness_.front());
}

double ForceBound::stiffness_N_m(double force_N) const {
  return stiffness_[cell_of(force_N)];
}

double ForceBound::force_after_N(double force_N, double way_m) const {
  double force = std::max(force_N, 0.0);
  for (std::size_t i = cell_of(force); way_m > 0 && i < kCells; ++i) {
    const double k = stiffness_[i];
    const double cell_m = (edges()[i + 1] - force) / k;
    if (std::isinf(k)) return k;
    if (cell_m >= way_m) return force + k * way_m;
    way_m -= cell_m;
    force = edges()[i + 1];
  }
  return way_m > 0 ? std::numeric_limits<double>::infinity() : force;
}

double ForceBound::force_before_N(double force_N, double way_m) const {
  double force = std::max(force_N, 0.0);
  for (std::size_t i = cell_of(force) + 1; way_m > 0 && i-- > 0;) {
    const double k = stiffness_[i];
    const double cell_m = (force - edges()[i]) / k;
    if (std::isfinite(k) && cell_m >= way_m) return force - k * way_m;
    way_m -= cell_m;
    force = edges()[i];
  }
  return force;
}

double ForceBound::way_m(double from_N, double to_N) const {
  double way = 0, force = std::max(from_N, 0.0);
  for (std::size_t i = cell_of(force); force < to_N && i < kCells; ++i) {
    const double end = std::min(to_N, edges()[i + 1]);
    way += (end - force) / stiffness_[i];
    force = end;
  }
  return way;
}

}  // namespace lcrig
