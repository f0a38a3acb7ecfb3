// SPDX-License-Identifier: Apache-2.0
// What a fit's misfit looks like, and how far the parameters move under what it may mean. Private
// to model/fit.cpp.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "model/fit_place.hpp"

namespace lcrig {

// Changes of the parameters (in the units of FitPlace's) under other assumptions.
struct FitShifts {
  std::vector<Eigen::VectorXd> geometry;  // the file's sizes or permittivity are off, as C0 shows
  std::vector<Eigen::VectorXd> hysteresis;  // the specimen's curve is the mean of its branches
  std::vector<Eigen::VectorXd> all() const;
};
FitShifts find_shifts(const FitPlaces& places, const FitPlace& at,
                      const Eigen::MatrixXd& influence);

FitMisfit find_misfit(const FitPlaces& places, const FitPlace& at, const ScaledProblem& problem,
                      const ScaledAnswer& answer);

}  // namespace lcrig
