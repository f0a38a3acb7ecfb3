// SPDX-License-Identifier: Apache-2.0
// Small linear least squares with a covariance. The analysis and the budget use it.
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
  void add(const double* row, double y);  // `row` has `columns` values
  std::size_t columns() const { return columns_; }
  std::int64_t rows() const { return rows_; }

  struct Solution {
    std::vector<double> value;
    std::vector<double> unit_covariance;  // row by row; multiply by the variance of a row
    double residual_ss = 0;
    double freedom = 0;  // rows - columns
    // Variance of the sum of factor[i] value[i], if a row has variance 1.
    double unit_variance(const std::vector<double>& factor) const;
  };
  // Empty when the columns do not determine the values (too few rows, or dependent columns).
  std::optional<Solution> solve() const;

 private:
  std::size_t columns_;
  std::int64_t rows_ = 0;
  std::vector<double> normal_, right_;
  double yy_ = 0, y0_ = 0;  // relative to the first y, so that a large mean costs no digits
};

}  // namespace lcrig
