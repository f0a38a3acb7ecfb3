// SPDX-License-Identifier: Apache-2.0
// Small linear least squares with a covariance. Used by the passes of the analysis and the budget.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace lcrig {

// Rows are added one by one; memory does not grow with them. Columns should be of similar size.
class LeastSquares {
 public:
  explicit LeastSquares(std::size_t columns);
  void add(const double* row, double y);  // `columns` values
  std::size_t columns() const { return columns_; }
  std::int64_t rows() const { return rows_; }

  struct Solution {
    std::vector<double> value;
    std::vector<double> unit_covariance;  // row by row; times the variance of a row
    double residual_ss = 0;
    double freedom = 0;  // rows - columns
    // Variance, for unit variance of a row, of the sum of factor[i] value[i].
    double unit_variance(const std::vector<double>& factor) const;
  };
  // Nothing when the columns do not determine the values (fewer rows, or columns alike).
  std::optional<Solution> solve() const;

 private:
  std::size_t columns_;
  std::int64_t rows_ = 0;
  std::vector<double> normal_, right_;
  double yy_ = 0, y0_ = 0;  // about the first y, so that a large mean costs no digits
};

}  // namespace lcrig
