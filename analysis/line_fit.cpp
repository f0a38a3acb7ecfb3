// SPDX-License-Identifier: Apache-2.0
#include "analysis/line_fit.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>
#include <ranges>

#include "base/online.hpp"

namespace lcrig {

namespace {

constexpr double kHuber = 1.345;  // 95 % efficiency for normal errors (Huber 1981)
constexpr double kMadToSigma = 1.482602218505602;

Result<> check(std::span<const LinePoint> points) {
  if (points.size() < 2) {
    return fail(Errc::invalid_request, "a straight line needs two points, here {} are",
                points.size());
  }
  for (const LinePoint& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !(p.weight > 0) || !std::isfinite(p.weight)) {
      return fail(Errc::invalid_request, "a point that is not finite, or without a weight");
    }
  }
  return {};
}

int count_distinct(std::span<const LinePoint> points) {
  std::vector<double> x;
  x.reserve(points.size());
  for (const LinePoint& p : points) x.push_back(p.x);
  std::sort(x.begin(), x.end());
  return static_cast<int>(std::unique(x.begin(), x.end()) - x.begin());
}

// Weighted mean in two passes: the second one corrects the rounding of the first.
double mean_of(std::span<const LinePoint> points, double LinePoint::* what, double sum_weights) {
  double sum = 0;
  for (const LinePoint& p : points) sum += p.weight * (p.*what - points[0].*what);
  const double first = points[0].*what + sum / sum_weights;
  double rest = 0;
  for (const LinePoint& p : points) rest += p.weight * (p.*what - first);
  return first + rest / sum_weights;
}

// Sums of squared residuals of the line through the first 1, 2, ... points of the range.
template <class Range>
std::vector<double> growing_residuals(const Range& points, const LineFit& centre) {
  RunningLine line;
  std::vector<double> out;
  out.reserve(points.size());
  for (const LinePoint& p : points) {
    line.add(p.x - centre.x_mean, p.y - centre.y_mean, p.weight);
    out.push_back(line.residual_ss());
  }
  return out;
}

// Number of points below the limit that gives the least sum of squares; 0: there is no limit. Takes
// one pass from either end, with sums about the means of all points.
std::size_t best_cut(const std::vector<LinePoint>& sorted, const LineFit& one, int least) {
  const auto low = growing_residuals(sorted, one);
  const auto high = growing_residuals(std::views::reverse(sorted), one);
  std::size_t best = 0;
  double best_ss = 0;
  int distinct = 1;
  for (std::size_t cut = 1; cut < sorted.size(); ++cut) {
    if (sorted[cut].x == sorted[cut - 1].x) continue;
    const int below = distinct++;
    if (below < least || one.distinct_x - below < least) continue;
    const double ss = low[cut - 1] + high[sorted.size() - cut - 1];
    if (best != 0 && ss >= best_ss) continue;
    best = cut;
    best_ss = ss;
  }
  return best;
}

double p_of_z(double z) {
  return 2 * boost::math::cdf(boost::math::complement(boost::math::normal(), std::abs(z)));
}

}  // namespace

double LineFit::slope_se(double variance) const {
  return std::sqrt(variance / sxx);
}

double LineFit::slope_se() const {
  return slope_se(residual_ss / (points - 2));
}

Result<LineFit> fit_line(std::span<const LinePoint> points) {
  if (auto ok = check(points); !ok) return fail(ok.error());
  LineFit fit;
  fit.points = static_cast<int>(points.size());
  fit.distinct_x = count_distinct(points);
  if (fit.distinct_x < 2) {
    return fail(Errc::invalid_request, "all {} points lie at the same x = {}", points.size(),
                points[0].x);
  }
  for (const LinePoint& p : points) fit.sum_weights += p.weight;
  fit.x_mean = mean_of(points, &LinePoint::x, fit.sum_weights);
  fit.y_mean = mean_of(points, &LinePoint::y, fit.sum_weights);
  for (const LinePoint& p : points) {
    const double dx = p.x - fit.x_mean, dy = p.y - fit.y_mean;
    fit.sxx += p.weight * dx * dx;
    fit.sxy += p.weight * dx * dy;
    fit.syy += p.weight * dy * dy;
  }
  fit.slope = fit.sxy / fit.sxx;
  for (const LinePoint& p : points) {
    const double r = (p.y - fit.y_mean) - fit.slope * (p.x - fit.x_mean);
    fit.residual_ss += p.weight * r * r;
  }
  fit.r_squared = fit.syy > 0 ? std::max(0.0, 1 - fit.residual_ss / fit.syy) : 1;
  return fit;
}

double huber_location(const std::vector<double>& values) {
  double at = median(values);
  const double scale = robust_sigma(values);
  if (scale <= 0) return at;
  for (int i = 0; i < 100; ++i) {
    double sum = 0, weights = 0;
    for (const double v : values) {
      const double z = std::abs(v - at) / scale;
      const double w = z > kHuber ? kHuber / z : 1;
      sum += w * (v - at);
      weights += w;
    }
    at += sum / weights;
    if (std::abs(sum / weights) <= 1e-9 * scale) break;
  }
  return at;
}

double student_t_quantile(double probability, double degrees_of_freedom) {
  if (!std::isfinite(degrees_of_freedom)) return normal_quantile(probability);
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
}

double coverage_factor(double confidence, double degrees_of_freedom) {
  return student_t_quantile((1 + confidence) / 2, degrees_of_freedom);
}

double freedom_of_factor(double factor, double confidence) {
  double low = 1, high = 1e6;
  while (high / low > 1.0001) {
    const double middle = std::sqrt(low * high);
    (coverage_factor(confidence, middle) > factor ? low : high) = middle;
  }
  return high;
}

double f_tail(double f, double dof1, double dof2) {
  if (!(f > 0)) return 1;
  if (!std::isfinite(f)) return 0;
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(dof1, dof2), f));
}

double chi_square_quantile(double probability, double degrees_of_freedom) {
  return boost::math::quantile(boost::math::chi_squared(degrees_of_freedom), probability);
}

double normal_quantile(double probability) {
  return boost::math::quantile(boost::math::normal(), probability);
}

double median(std::vector<double> values) {
  return boost::math::statistics::median(values);
}

double robust_sigma(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double middle = median(values);
  std::vector<double> deviations;  // Boost 1.81 ignores the middle in median_absolute_deviation
  deviations.reserve(values.size());
  for (const double v : values) deviations.push_back(std::abs(v - middle));
  return kMadToSigma * median(std::move(deviations));
}

RunsTest runs_test(std::span<const double> residuals) {
  RunsTest out;
  int before = 0;
  for (const double r : residuals) {
    if (r == 0) continue;
    const int sign = r > 0 ? 1 : -1;
    (sign > 0 ? out.above : out.below) += 1;
    if (sign != before) ++out.runs;
    before = sign;
  }
  const double a = out.above, b = out.below, n = a + b;
  if (a < 2 || b < 2 || n < 6) return out;
  const double expected = 1 + 2 * a * b / n;
  const double variance = 2 * a * b * (2 * a * b - n) / (n * n * (n - 1));
  if (variance <= 0) return out;
  const double distance = std::max(0.0, std::abs(out.runs - expected) - 0.5);
  out.p = std::min(1.0, p_of_z(distance / std::sqrt(variance)));
  return out;
}

Result<TwoRegions> find_two_regions(std::span<const LinePoint> points, int least) {
  std::vector<LinePoint> sorted(points.begin(), points.end());
  std::ranges::sort(sorted, {}, &LinePoint::x);
  auto one = fit_line(sorted);
  if (!one) return fail(one.error());
  const std::size_t cut = best_cut(sorted, *one, least);
  if (cut == 0) {
    return fail(Errc::invalid_request, "two regions need {} different pressures each, here {} are",
                least, one->distinct_x);
  }
  const std::span<const LinePoint> all(sorted);
  const auto low = fit_line(all.first(cut));
  const auto high = fit_line(all.subspan(cut));
  if (!low) return fail(low.error());
  if (!high) return fail(high.error());
  TwoRegions best{all[cut - 1].x, all[cut].x, *low, *high, 1};
  const double ss = low->residual_ss + high->residual_ss;
  const int freedom = one->points - 4;
  if (freedom >= 1 && ss > 0) {
    best.p_one_line = f_tail((one->residual_ss - ss) / 2 / (ss / freedom), 2, freedom);
  }
  return best;
}

}  // namespace lcrig
