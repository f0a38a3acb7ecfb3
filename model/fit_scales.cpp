// SPDX-License-Identifier: Apache-2.0
#include "model/fit_scales.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Scales of the half-Cauchy priors, flat below: of each element of creep, relative to the pressure,
// and of the misfit, relative to the span. Elastomers creep by some percent, and laws for them err
// by about one at the strains of this project (docs/decisions/0009).
constexpr double kPriorCreep = 0.02, kPriorMisfit = 0.01;

struct Scales {
  double creep = 0, misfit = 0, scatter = 1;
};

double log_prior(const Scales& s) {
  const double c = s.creep / kPriorCreep, m = s.misfit / kPriorMisfit;
  return -std::log1p(c * c) - std::log1p(m * m);
}

MatrixXd noise_of(const ScaledProblem& p, double scatter) {
  VectorXd noise = p.noise;
  noise.head(p.readings) *= scatter * scatter;
  return noise.asDiagonal();
}

// The answer for one combination of scales.
struct Solved {
  Scales scales;
  double log_likelihood = 0;
  VectorXd parameters, amplitudes, misfit;
  MatrixXd influence, amplitudes_covariance;
};

Solved solve_with(const ScaledProblem& p, const MatrixXd& creep2, const Scales& s) {
  MatrixXd variance = noise_of(p, s.scatter) + p.known;
  variance += s.creep * s.creep * creep2 + s.misfit * s.misfit * p.misfit;
  const Eigen::LLT<MatrixXd> llt(variance);
  const MatrixXd weighted = llt.solve(p.slopes);
  const Eigen::LDLT<MatrixXd> normal(p.slopes.transpose() * weighted);
  Solved out;
  out.scales = s;
  out.influence = normal.solve(weighted.transpose());
  out.parameters = out.influence * p.values;
  const VectorXd residuals = p.values - p.slopes * out.parameters;
  const VectorXd whitened = llt.solve(residuals);
  out.amplitudes = s.creep * s.creep * p.creep.transpose() * whitened;
  out.misfit = s.misfit * s.misfit * p.misfit * whitened;
  const MatrixXd of_creep = llt.solve(p.creep);
  const MatrixXd shared = p.slopes.transpose() * of_creep;
  const MatrixXd seen = p.creep.transpose() * of_creep - shared.transpose() * normal.solve(shared);
  const double s2 = s.creep * s.creep;
  out.amplitudes_covariance = s2 * MatrixXd::Identity(seen.rows(), seen.cols()) - s2 * s2 * seen;
  double log_determinant = normal.vectorD().array().abs().log().sum();
  const MatrixXd& root = llt.matrixLLT();
  for (Eigen::Index i = 0; i < root.rows(); ++i) log_determinant += 2 * std::log(root(i, i));
  out.log_likelihood = -0.5 * (log_determinant + residuals.dot(whitened)) + log_prior(s);
  return out;
}

std::vector<Solved> solve_all(const ScaledProblem& p, const ScaleGrid& grid) {
  const MatrixXd creep2 = p.creep * p.creep.transpose();
  std::vector<Solved> out;
  for (const double creep : grid.creep) {
    for (const double misfit : grid.misfit) {
      for (const double scatter : grid.scatter) {
        out.push_back(solve_with(p, creep2, {creep, misfit, scatter}));
      }
    }
  }
  return out;
}

MatrixXd outer_square(const VectorXd& v) {
  return v * v.transpose();
}

void add_solved(const ScaledProblem& p, const MatrixXd& creep2, const Solved& s, double weight,
                ScaledAnswer& out) {
  const MatrixXd& a = s.influence;
  const auto carried = [&](const MatrixXd& variance) -> MatrixXd {
    return weight * (a * variance * a.transpose());
  };
  out.influence += weight * a;
  out.of_noise += carried(noise_of(p, s.scales.scatter));
  out.of_known += carried(p.known);
  out.of_creep += carried(s.scales.creep * s.scales.creep * creep2);
  out.of_misfit += carried(s.scales.misfit * s.scales.misfit * p.misfit);
  out.of_scales += weight * outer_square(s.parameters - out.parameters);
  out.misfit += weight * s.misfit;
  out.amplitudes_covariance +=
      weight * (s.amplitudes_covariance + outer_square(s.amplitudes - out.amplitudes));
  out.creep_scale += weight * s.scales.creep;
  out.misfit_scale += weight * s.scales.misfit;
  out.scatter += weight * s.scales.scatter;
}

}  // namespace

ScaledAnswer solve_scales(const ScaledProblem& p, const ScaleGrid& grid) {
  const std::vector<Solved> all = solve_all(p, grid);
  double best = all.front().log_likelihood, sum = 0;
  for (const Solved& s : all) best = std::max(best, s.log_likelihood);
  std::vector<double> weights;
  for (const Solved& s : all) sum += weights.emplace_back(std::exp(s.log_likelihood - best));
  const Eigen::Index n = p.values.size(), m = p.slopes.cols(), k = p.creep.cols();
  ScaledAnswer out;
  out.parameters = VectorXd::Zero(m);
  out.amplitudes = VectorXd::Zero(k);
  out.misfit = VectorXd::Zero(n);
  out.influence = MatrixXd::Zero(m, n);
  out.of_noise = out.of_known = out.of_creep = out.of_misfit = out.of_scales = MatrixXd::Zero(m, m);
  out.amplitudes_covariance = MatrixXd::Zero(k, k);
  out.scatter = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    weights[i] /= sum;
    out.parameters += weights[i] * all[i].parameters;
    out.amplitudes += weights[i] * all[i].amplitudes;
  }
  const MatrixXd creep2 = p.creep * p.creep.transpose();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (weights[i] > 1e-6) add_solved(p, creep2, all[i], weights[i], out);
  }
  return out;
}

PlainAnswer solve_plain(const ScaledProblem& p) {
  const MatrixXd variance = MatrixXd(p.noise.asDiagonal()) + p.known;
  const Eigen::LLT<MatrixXd> llt(variance);
  const MatrixXd weighted = llt.solve(p.slopes);
  const Eigen::LDLT<MatrixXd> normal(p.slopes.transpose() * weighted);
  PlainAnswer out;
  out.parameters = normal.solve(weighted.transpose() * p.values);
  out.residuals = p.values - p.slopes * out.parameters;
  out.chi2 = out.residuals.dot(llt.solve(out.residuals));
  const MatrixXd left = variance - p.slopes * normal.solve(p.slopes.transpose());
  out.residual_sd = left.diagonal().cwiseMax(0.0).cwiseSqrt();
  return out;
}

}  // namespace lcrig
