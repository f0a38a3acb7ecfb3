// SPDX-License-Identifier: Apache-2.0
// The points of a run as means over its repeats, and what the repeats tell of their own scatter.
// Private to model/fit.cpp.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "model/fit.hpp"

namespace lcrig {

struct FitCells {
  std::vector<FitPoint> mean;  // of each cell; standard_error_F is not used
  Eigen::MatrixXd deviations;  // cells x repeats, F; 0 where a repeat lacks the cell
  // The same of the pressure that each element of creep adds for an amplitude of 1, Pa; the last
  // one is FitPoint::held_decades times the pressure.
  std::vector<Eigen::MatrixXd> memory_deviations;
  Eigen::VectorXd told_noise;  // variance of each mean as the readings tell it, F^2
  Eigen::VectorXd noise;  // the same, and what the repeats show beyond it
  Eigen::MatrixXd repeats;  // covariance of the means from offsets and gains of the repeats
  int repeat_count = 0;
  bool told = false;  // the points have standard errors
  double span_F = 0, highest_Pa = 0;

  Eigen::Index size() const { return static_cast<Eigen::Index>(mean.size()); }
  // Finds `noise` and `repeats` from deviations that do not contain creep.
  void judge_repeats(const Eigen::MatrixXd& without_creep);
};

// Errors: a point is not a number; fewer than three different pressures.
Result<FitCells> cells_of(const FitData& data);

}  // namespace lcrig
