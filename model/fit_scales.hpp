// SPDX-License-Identifier: Apache-2.0
// Generalized least squares for data whose errors have unknown scales: how much the specimen
// creeps, how far its curve departs from the law, how noisy it is. The restricted likelihood weighs
// every combination of scales, and all of them together give the answer. For model/fit.cpp;
// docs/decisions/0009 has the reasons.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace lcrig {

// value = slopes * parameters + creep * amplitudes + misfit + errors. Every row is a datum.
struct ScaledProblem {
  Eigen::VectorXd values;
  Eigen::MatrixXd slopes;
  Eigen::MatrixXd creep;  // response to a unit of each amplitude
  Eigen::MatrixXd misfit;  // covariance of the misfit at scale 1
  Eigen::VectorXd noise;  // variance of each datum; `scatter` multiplies that of the readings
  Eigen::MatrixXd known;  // covariance of errors that data share, of known size
  Eigen::Index readings = 0;  // the first rows; the others are not multiplied by `scatter`
};

struct ScaleGrid {
  std::vector<double> creep, misfit, scatter;
};

// Variances of the parameters by their source, each the mean over the scales.
struct ScaledAnswer {
  Eigen::VectorXd parameters, amplitudes;
  Eigen::MatrixXd influence;  // of every datum on the parameters
  Eigen::MatrixXd of_noise, of_known, of_creep, of_misfit, of_scales;
  Eigen::MatrixXd amplitudes_covariance;
  Eigen::VectorXd misfit;  // expected, of each datum
  double creep_scale = 0, misfit_scale = 0, scatter = 1;  // means
};

// Precondition: the slopes determine the parameters.
ScaledAnswer solve_scales(const ScaledProblem& problem, const ScaleGrid& grid);

// Ordinary generalized least squares without creep and misfit.
struct PlainAnswer {
  Eigen::VectorXd parameters, residuals;
  Eigen::VectorXd residual_sd;  // known standard deviation of each residual
  double chi2 = 0;
};
PlainAnswer solve_plain(const ScaledProblem& problem);

}  // namespace lcrig
