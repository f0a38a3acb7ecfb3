// SPDX-License-Identifier: Apache-2.0
#include "analysis/least_squares.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace lcrig {

LeastSquares::LeastSquares(std::size_t columns)
    : columns_(columns), normal_(columns * columns, 0.0), right_(columns, 0.0) {}

// The first column must be 1. Subtracting the first y from all y then changes only the first value.
void LeastSquares::add(const double* row, double y) {
  if (rows_++ == 0) y0_ = y;
  const double d = y - y0_;
  for (std::size_t i = 0; i < columns_; ++i) {
    for (std::size_t k = 0; k < columns_; ++k) normal_[i * columns_ + k] += row[i] * row[k];
    right_[i] += row[i] * d;
  }
  yy_ += d * d;
}

std::optional<LeastSquares::Solution> LeastSquares::solve() const {
  const auto n = static_cast<Eigen::Index>(columns_);
  if (rows_ < static_cast<std::int64_t>(columns_)) return std::nullopt;
  const Eigen::Map<const Eigen::MatrixXd> normal(normal_.data(), n, n);
  const Eigen::Map<const Eigen::VectorXd> right(right_.data(), n);
  // Scales the columns to unit length, so that the rank does not depend on units.
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt();
  if ((scale.array() <= 0).any()) return std::nullopt;
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const Eigen::MatrixXd scaled = inverse.asDiagonal() * normal * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  if (eigen.eigenvalues().minCoeff() < 1e-11) return std::nullopt;
  const Eigen::MatrixXd covariance =
      inverse.asDiagonal() *
      (eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
       eigen.eigenvectors().transpose()) *
      inverse.asDiagonal();
  const Eigen::VectorXd value = covariance * right;
  Solution out;
  out.value.assign(value.data(), value.data() + n);
  out.value[0] += y0_;
  out.unit_covariance.assign(covariance.data(), covariance.data() + n * n);
  out.residual_ss = std::max(0.0, yy_ - value.dot(right));
  out.freedom = static_cast<double>(rows_) - static_cast<double>(columns_);
  return out;
}

double LeastSquares::Solution::unit_variance(const std::vector<double>& factor) const {
  const std::size_t n = value.size();
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) sum += factor[i] * unit_covariance[i * n + k] * factor[k];
  }
  return sum;
}

}  // namespace lcrig
