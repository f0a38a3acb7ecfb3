// SPDX-License-Identifier: Apache-2.0
#include "analysis/slow_noise.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <limits>

#include "analysis/line_fit.hpp"

namespace lcrig {

namespace {

// 1/f noise is a sum of first-order processes, one for each octave of time up to this many times
// the length of the run. A slower process moves all readings alike and cannot be seen in the run.
constexpr double kSlowest = 10;
// Powers of two for the sizes that are tried: the variance of an octave over that of a block's
// white noise, and likewise what the walk adds in the time of a block.
constexpr int kFlickerFrom = -8, kFlickerTo = 8, kWalkFrom = -11, kWalkTo = 7;
// Prior weights: of no slow noise at all, and of each size of one kind alone. Each pair of sizes
// has weight 1. The single kinds together weigh three times as much as all pairs.
constexpr double kNone = 150, kOneKind = 30;
// Prior weight of the walk alone for the rate of a drift. Five rests hardly distinguish a walk from
// 1/f noise, and 1/f noise would make the rate look better known.
constexpr double kWalkOfDrift = 480;
constexpr double kLeastFreedom = 6;
constexpr double kNegligible = 1e-5;
constexpr std::uintmax_t kHalvings = 30;  // of a bracket around a quantile

using Matrix = Eigen::MatrixXd;

// Mean of exp(-t/tau) over a block of this length, with t counted from the block's end.
double fading(double length_s, double tau_s) {
  const double x = length_s / tau_s;
  return x > 1e-6 ? -std::expm1(-x) / x : 1 - x / 2;
}
// Variance of the block's mean under a first-order process of unit variance.
double octave(const QuietBlock& a, double tau_s) {
  const double x = a.length_s / tau_s;
  return x > 1e-4 ? 2 / x * (1 - fading(a.length_s, tau_s)) : 1 - x / 3;
}

// Adds the covariance of the blocks under a first-order process of unit variance.
void add_octave(const std::vector<QuietBlock>& blocks, double tau_s, Matrix& out) {
  std::vector<double> fades(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) fades[i] = fading(blocks[i].length_s, tau_s);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const QuietBlock& a = blocks[i];
    out(row, row) += octave(a, tau_s);
    for (std::size_t j = i + 1; j < blocks.size(); ++j) {
      const double apart = blocks[j].t_s - a.t_s - (a.length_s + blocks[j].length_s) / 2;
      if (apart > 40 * tau_s) break;
      const double c = std::exp(-std::max(0.0, apart) / tau_s) * fades[i] * fades[j];
      const auto column = static_cast<Eigen::Index>(j);
      out(row, column) += c;
      out(column, row) += c;
    }
  }
}

Matrix flicker_of(const std::vector<QuietBlock>& blocks, double slowest_s) {
  const auto n = static_cast<Eigen::Index>(blocks.size());
  Matrix out = Matrix::Zero(n, n);
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& b : blocks) shortest = std::min(shortest, b.length_s);
  // Noise that is much faster than a block looks white.
  const double fastest_s = std::max(shortest / 8, slowest_s * 1e-7);
  for (double tau = slowest_s; tau > fastest_s; tau /= 2) {
    add_octave(blocks, tau, out);
  }
  return out;
}

Matrix walk_of(const std::vector<QuietBlock>& blocks) {
  const auto n = static_cast<Eigen::Index>(blocks.size());
  Matrix out(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& a = blocks[static_cast<std::size_t>(i)];
    out(i, i) = a.t_s - a.length_s / 6;
    for (Eigen::Index j = i + 1; j < n; ++j) out(i, j) = out(j, i) = a.t_s;
  }
  return out;
}

Eigen::VectorXd shares_of(const std::vector<QuietBlock>& blocks) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    out(static_cast<Eigen::Index>(i)) = blocks[i].share;
  }
  return out;
}

Matrix columns_of(const std::vector<QuietBlock>& blocks, AfterLoad after_load) {
  const auto n = static_cast<Eigen::Index>(blocks.size());
  int loaded = 0;
  for (const auto& b : blocks) loaded += b.loaded_before ? 1 : 0;
  const bool step = after_load == AfterLoad::shifted && loaded > 0 && loaded < n;
  const bool drift = loaded > 0;
  Matrix x = Matrix::Zero(n, 1 + (drift ? 1 : 0) + (step ? 1 : 0));
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& b = blocks[static_cast<std::size_t>(i)];
    x(i, 0) = 1;
    if (drift) x(i, 1) = (b.t_s - blocks.front().t_s) / (blocks.back().t_s - blocks.front().t_s);
    if (step) x(i, 2) = b.loaded_before ? 1 : 0;
  }
  return x;
}

struct Restricted {
  double log_likelihood = 0, scale = 0;  // fF2
};

// Coordinates in which everything but the walk is white with unit variance and the parts of the
// walk are independent. Each size of the walk then costs only one sum over the blocks.
class Whitened {
 public:
  Whitened(const Matrix& fixed, const Matrix& walk, const Matrix& x, const Eigen::VectorXd& y) {
    const Eigen::LLT<Matrix> root(fixed);
    const Matrix half = root.matrixL().solve(walk);
    const Eigen::SelfAdjointEigenSolver<Matrix> apart(
        Matrix(root.matrixL().solve(half.transpose())));
    walk_ = apart.eigenvalues().cwiseMax(0.0);
    x_ = apart.eigenvectors().transpose() * root.matrixL().solve(x);
    y_ = apart.eigenvectors().transpose() * root.matrixL().solve(y);
    log_fixed_ = 2 * root.matrixLLT().diagonal().array().log().sum();
  }

  Restricted at(double walk) const {
    const Eigen::VectorXd variance = (1 + walk * walk_.array()).matrix();
    const Eigen::VectorXd weight = variance.cwiseInverse();
    const Matrix weighted = weight.asDiagonal() * x_;
    const Eigen::LLT<Matrix> normal(Matrix(x_.transpose() * weighted));
    const Eigen::VectorXd right = weighted.transpose() * y_;
    const double ss =
        std::max(0.0, y_.dot(weight.cwiseProduct(y_)) - right.dot(normal.solve(right)));
    const auto freedom = static_cast<double>(y_.size() - x_.cols());
    const double logs = log_fixed_ + variance.array().log().sum() +
                        2 * normal.matrixLLT().diagonal().array().log().sum();
    return {-0.5 * (logs + freedom * std::log(std::max(ss, 1e-300))), ss / freedom};
  }

 private:
  Matrix x_;
  Eigen::VectorXd walk_, y_;
  double log_fixed_ = 0;
};

std::vector<double> sizes(double unit, int from, int to) {
  std::vector<double> out{0};
  for (int e = from; e <= to; ++e) out.push_back(unit * std::exp2(e));
  return out;
}

// Converts logarithms of likelihoods to shares of 1.
template <class Candidates>
void make_shares(Candidates& candidates) {
  double best = -std::numeric_limits<double>::infinity(), sum = 0;
  for (const auto& c : candidates) best = std::max(best, c.likelihood);
  for (auto& c : candidates) sum += c.likelihood = std::exp(c.likelihood - best);
  std::erase_if(candidates, [sum](const auto& c) { return c.likelihood < kNegligible * sum; });
  sum = 0;
  for (const auto& c : candidates) sum += c.likelihood;
  for (auto& c : candidates) c.likelihood /= sum;
}

}  // namespace

SlowNoise::SlowNoise(const std::vector<QuietBlock>& blocks, double run_s, AfterLoad after_load)
    : blocks_(blocks), slowest_s_(kSlowest * run_s) {
  weigh(after_load);
}

void SlowNoise::weigh(AfterLoad after_load) {
  const Matrix x = columns_of(blocks_, after_load);
  freedom_ = static_cast<double>(blocks_.size()) - static_cast<double>(x.cols());
  if (freedom_ < kLeastFreedom) return;
  flicker_ = flicker_of(blocks_, slowest_s_);
  walk_ = walk_of(blocks_);
  shares_ = shares_of(blocks_);
  Eigen::VectorXd y(shares_.size());
  double length = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    y(static_cast<Eigen::Index>(i)) = blocks_[i].fF - blocks_[0].fF;
    length += blocks_[i].length_s / static_cast<double>(blocks_.size());
  }
  if (!(length > 0)) return;
  const auto flickers = sizes(shares_.mean(), kFlickerFrom, kFlickerTo);
  const auto walks = sizes(shares_.mean() / length, kWalkFrom, kWalkTo);
  const double walk_alone = after_load == AfterLoad::alike ? kWalkOfDrift : kOneKind;
  for (const double f : flickers) {
    Matrix fixed = f * flicker_;
    fixed.diagonal() += shares_;
    const Whitened whitened(fixed, walk_, x, y);
    for (const double w : walks) {
      const Restricted r = whitened.at(w);
      const double before = f > 0 && w > 0 ? 1 : f > 0 ? kOneKind : w > 0 ? walk_alone : kNone;
      candidates_.push_back(
          {r.log_likelihood + std::log(before), r.scale, f * r.scale, w * r.scale});
    }
  }
  make_shares(candidates_);
}

double SlowNoise::quantile(const std::vector<double>& variance, double confidence) const {
  double high = 0;
  for (const double v : variance) high = std::max(high, std::sqrt(v));
  high *= 2 * coverage_factor(confidence, 1e6);
  const auto too_many_outside = [&](double limit) {
    double outside = 0;
    for (std::size_t k = 0; k < variance.size(); ++k) {
      if (variance[k] > 0) {
        outside += candidates_[k].likelihood * std::erfc(limit / std::sqrt(2 * variance[k]));
      }
    }
    return outside - (1 - confidence);
  };
  const auto never = [](double, double) { return false; };
  std::uintmax_t steps = kHalvings + 3;  // three are counted before the first
  return boost::math::tools::bisect(too_many_outside, 0.0, high, never, steps).second;
}

SlopePart SlowNoise::error_of(const std::vector<double>& factor, double least_white,
                              double confidence) const {
  const Eigen::Map<const Eigen::VectorXd> a(factor.data(),
                                            static_cast<Eigen::Index>(factor.size()));
  const double white = a.dot(shares_.cwiseProduct(a));
  const double flicker = a.dot(flicker_ * a);
  const double walk = a.dot(walk_ * a);
  std::vector<double> variance;
  double mean = 0;
  for (const Candidate& c : candidates_) {
    variance.push_back(std::max(least_white, c.white * white) + c.flicker * flicker +
                       c.walk * walk);
    mean += c.likelihood * variance.back();
  }
  const double se = std::sqrt(mean);
  if (!(se > 0)) return {0, freedom_};
  return {se, freedom_of_factor(quantile(variance, confidence) / se, confidence)};
}

}  // namespace lcrig
