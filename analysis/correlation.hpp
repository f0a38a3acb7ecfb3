// SPDX-License-Identifier: Apache-2.0
// Estimates the correlation of each reading with the one before it, from all stretches in which the
// specimen is left alone. A standard error that assumes independent readings is too small by this
// correlation. The model is a first-order process with a mean of its own for each stretch, fitted
// by restricted maximum likelihood. Private to analysis/.
#pragma once

#include <cstdint>
#include <vector>

namespace lcrig {

// Running sums over a stretch of evenly spaced readings. Values are relative to the first one.
struct EvenStretch {
  std::int64_t count = 0;
  double first = 0, last = 0;  // `last` is relative to `first`
  double sum = 0, squares = 0, products = 0;  // `products`: of neighbouring values
  double moments = 0;  // sum of value times index, from 0
  bool trend = false;  // the stretch has its own slope, too: a creep is not a correlation
  void add(double y);
};

struct Correlation {
  double rho = 0;  // correlation of neighbouring readings, at least 0
  double variance = 0;  // of one reading
  double freedom = 0;  // number of values less that of stretches behind rho; 0: rho is not known
  // -2 log of the restricted likelihood, with this correlation and with none.
  double deviance = 0, deviance_of_white = 0;

  // Variance of the mean of `count` readings, if one reading has variance 1.
  double of_mean(double count) const;
  // Expected mean square of `count` readings about their mean, if one reading has variance 1.
  double of_square(double count) const;
  // Degrees of freedom of the variance of a mean, from the error of its scale and that of rho.
  // `scale`: number of values (less their means) that determine the scale.
  double degrees_of_freedom(double scale) const;
  // degrees_of_freedom(scale), or `scale` itself where no correlation is known.
  double freedom_of(double scale) const { return freedom > 0 ? degrees_of_freedom(scale) : scale; }
  // Factor by which a standard error must grow that was computed as if readings were independent.
  double widening() const;
};
Correlation fit_correlation(const std::vector<EvenStretch>& stretches);

// Deviance, on the same scale, of white noise plus a random walk, with a mean and a slope for each
// stretch. It is the smallest over some twenty sizes of the walk.
double deviance_of_walk(const std::vector<std::vector<double>>& stretches);

// Variance of the mean of all values, from the means of `batches` equal parts. It includes noise
// slower than the correlation of neighbours, but has few degrees of freedom. 0: too few values.
double variance_of_batches(const std::vector<double>& values, std::size_t batches);

}  // namespace lcrig
