// SPDX-License-Identifier: Apache-2.0
// How much a reading resembles the one before it, from all stretches in which the specimen is left
// alone: a standard error that takes readings as independent is too small by that. Each stretch has
// a mean of its own (a first-order process, restricted maximum likelihood). Private to analysis/.
#pragma once

#include <cstdint>
#include <vector>

namespace lcrig {

// Sums of a stretch of evenly spaced readings, about its first value.
struct EvenStretch {
  std::int64_t count = 0;
  double first = 0, last = 0;  // `last` about `first`
  double sum = 0, squares = 0, products = 0;  // the last of neighbours
  double moments = 0;  // values times their number, from 0
  bool trend = false;  // each such stretch has a slope of its own, too: a creep is no correlation
  void add(double y);
};

struct Correlation {
  double rho = 0;  // of neighbours, 0 or more
  double variance = 0;  // of one reading
  double freedom = 0;  // values less stretches that rho is from; 0: nothing is known
  // -2 log of the restricted likelihood, and what it would be without a correlation.
  double deviance = 0, deviance_of_white = 0;

  // Variance of the mean of `count` readings, for unit variance of one.
  double of_mean(double count) const;
  // Expected mean square about the mean of `count` readings, for unit variance of one.
  double of_square(double count) const;
  // Degrees of freedom of the variance of a mean, whose scale comes from `scale` values (less their
  // means): the scale's own error and that of rho.
  double degrees_of_freedom(double scale) const;
  // The same; `scale` where nothing is known of a correlation.
  double freedom_of(double scale) const { return freedom > 0 ? degrees_of_freedom(scale) : scale; }
  // How much wider a standard error is that was made as if readings knew nothing of each other.
  double widening() const;
};
Correlation fit_correlation(const std::vector<EvenStretch>& stretches);

// The same deviance, on the same scale, of white noise beside a random walk, for stretches that
// have a mean and a slope each. The most likely walk of some twenty sizes is taken.
double deviance_of_walk(const std::vector<std::vector<double>>& stretches);

// Variance of the mean from the means of `batches` equal parts: sees what is slower than one
// reading to the next. Nothing is assumed, so it has few degrees of freedom. 0: too few values.
double variance_of_batches(const std::vector<double>& values, std::size_t batches);

}  // namespace lcrig
