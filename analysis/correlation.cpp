// SPDX-License-Identifier: Apache-2.0
#include "analysis/correlation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lcrig {

namespace {

constexpr double kMostRho = 0.995;  // largest rho tried; nearer to 1 a stretch's mean says nothing
constexpr int kSteps = 40;  // of the golden section

std::int64_t parameters(const EvenStretch& s) {
  return s.trend ? 2 : 1;
}
bool tells(const EvenStretch& s) {
  return s.count >= 2 + parameters(s);
}

// What remains of a stretch after its mean (and slope) are fitted. Whitening: the first value is
// multiplied by sqrt(1 - rho2), each later one becomes y_t - rho y_{t-1}. The first value is 0
// here, because values are relative to it.
struct Left {
  double ss = 0, log_determinant = 0;
};
Left left_of(const EvenStretch& s, double rho) {
  const auto n = static_cast<double>(s.count);
  const double one = 1 - rho, before = s.sum - s.last;  // `before`: sum of all values but the last
  const double z2 =
      s.squares * (1 + rho * rho) - 2 * rho * s.products - rho * rho * s.last * s.last;
  const double zw = one * (s.sum - rho * before);
  const double w2 = (1 - rho * rho) + (n - 1) * one * one;
  if (!s.trend) return {z2 - zw * zw / w2, std::log(w2)};
  // Whitened regressor of the slope: 0 at first, then (1 - rho) t + rho for t = 1, 2, ..., n - 1.
  const double t1 = n * (n - 1) / 2, t2 = t1 * (2 * n - 1) / 3;
  const double later = s.moments - (n - 1) * s.last + before;  // sum of t y_{t-1}
  const double zu = one * (s.moments - rho * later) + rho * (s.sum - rho * before);
  const double wu = one * (one * t1 + rho * (n - 1));
  const double u2 = one * one * t2 + 2 * one * rho * t1 + rho * rho * (n - 1);
  const double determinant = w2 * u2 - wu * wu;
  const double explained = (zw * zw * u2 - 2 * zw * zu * wu + zu * zu * w2) / determinant;
  return {z2 - explained, std::log(determinant)};
}

struct Likelihood {
  double deviance = 0;  // -2 log of the restricted likelihood, maximised over the scale
  double variance = 0;  // of one reading
};
Likelihood likelihood(const std::vector<EvenStretch>& stretches, double rho) {
  double ss = 0, terms = 0, freedom = 0;
  for (const EvenStretch& s : stretches) {
    if (!tells(s)) continue;
    const Left left = left_of(s, rho);
    ss += left.ss;
    terms += left.log_determinant - std::log(1 - rho * rho);
    freedom += static_cast<double>(s.count - parameters(s));
  }
  return {freedom * std::log(std::max(ss, 1e-300)) + terms, ss / freedom / (1 - rho * rho)};
}
double deviance(const std::vector<EvenStretch>& stretches, double rho) {
  return likelihood(stretches, rho).deviance;
}

// Steps of the random walk that are tried, in standard deviations of the white noise per reading.
constexpr double kLeastStep = 1e-3, kMostStep = 32, kStepRatio = 1.7;

// Kalman filter for white noise of variance 1 plus a random walk with variance `step2` a reading,
// whose first level is unknown. It whitens both the values and the regressor of the slope.
double walk_deviance(const std::vector<std::vector<double>>& stretches, double step2) {
  double ss = 0, terms = 0, freedom = 0;
  for (const auto& y : stretches) {
    if (y.size() < 4) continue;
    double level = y[0], slope_level = 0, variance = 1, yy = 0, yt = 0, tt = 0, product = 1;
    for (std::size_t i = 1; i < y.size(); ++i) {
      const double before = variance + step2, all = before + 1, gain = before / all;
      const double v = y[i] - level, u = static_cast<double>(i) - slope_level;
      yy += v * v / all;
      yt += v * u / all;
      tt += u * u / all;
      product *= all;
      if (product > 1e200) terms += std::log(product), product = 1;
      level += gain * v;
      slope_level += gain * u;
      variance = gain;
    }
    ss += yy - yt * yt / tt;
    terms += std::log(product) + std::log(tt);
    freedom += static_cast<double>(y.size() - 2);
  }
  return freedom * std::log(std::max(ss, 1e-300)) + terms;
}

}  // namespace

void EvenStretch::add(double y) {
  if (count++ == 0) {
    first = y;
    return;  // relative to itself the first value is 0
  }
  const double d = y - first;
  products += d * last;
  moments += static_cast<double>(count - 1) * d;
  sum += d;
  squares += d * d;
  last = d;
}

double Correlation::of_mean(double n) const {
  const double one = 1 - rho;
  return ((1 + rho) / one - 2 * rho * (1 - std::pow(rho, n)) / (n * one * one)) / n;
}

double Correlation::of_square(double n) const {
  return n > 1 ? (1 - of_mean(n)) * n / (n - 1) : 0;
}

// Adds the two contributions to the variance of the logarithm of the variance: 2 (1 + rho2)/(n (1 -
// rho2)) from the scale, and 4 (1 + rho)/(N (1 - rho)) from rho.
double Correlation::degrees_of_freedom(double scale) const {
  if (freedom <= 0 || scale <= 0) return 1;
  const double of_scale = 2 * (1 + rho * rho) / (scale * (1 - rho * rho));
  const double of_rho = 4 * (1 + rho) / (freedom * (1 - rho));
  return std::max(1.0, 2 / (of_scale + of_rho));
}

double Correlation::widening() const {
  return std::sqrt((1 + rho) / (1 - rho));
}

Correlation fit_correlation(const std::vector<EvenStretch>& stretches) {
  Correlation out;
  double freedom = 0, squares = 0;
  for (const EvenStretch& s : stretches) {
    if (!tells(s)) continue;
    freedom += static_cast<double>(s.count - parameters(s));
    squares += s.squares;
  }
  if (freedom < 2) return out;
  out.freedom = freedom;
  if (squares <= 0) return out;
  double low = 0, high = kMostRho;
  const double ratio = 1 / std::numbers::phi;
  double a = high - ratio * (high - low), b = low + ratio * (high - low);
  double at_a = deviance(stretches, a), at_b = deviance(stretches, b);
  for (int i = 0; i < kSteps; ++i) {
    if (at_a <= at_b) {
      high = b, b = a, at_b = at_a;
      a = high - ratio * (high - low);
      at_a = deviance(stretches, a);
    } else {
      low = a, a = b, at_a = at_b;
      b = low + ratio * (high - low);
      at_b = deviance(stretches, b);
    }
  }
  out.rho = (low + high) / 2;
  out.deviance_of_white = deviance(stretches, 0);
  if (out.deviance_of_white <= deviance(stretches, out.rho)) out.rho = 0;
  const Likelihood best = likelihood(stretches, out.rho);
  out.variance = best.variance;
  out.deviance = best.deviance;
  return out;
}

double deviance_of_walk(const std::vector<std::vector<double>>& stretches) {
  double best = walk_deviance(stretches, 0);
  for (double step = kLeastStep; step <= kMostStep; step *= kStepRatio) {
    best = std::min(best, walk_deviance(stretches, step * step));
  }
  return best;
}

double variance_of_batches(const std::vector<double>& values, std::size_t batches) {
  if (batches < 2 || values.size() < 2 * batches) return 0;
  const std::size_t each = values.size() / batches;
  double mean = 0, ss = 0;
  for (std::size_t k = 0; k < batches; ++k) {
    double batch = 0;
    for (std::size_t i = 0; i < each; ++i) batch += values[k * each + i] - values[0];
    batch /= static_cast<double>(each);
    const double d = batch - mean;
    mean += d / static_cast<double>(k + 1);
    ss += d * (batch - mean);
  }
  const auto n = static_cast<double>(batches);
  return ss / (n - 1) / n;
}

}  // namespace lcrig
