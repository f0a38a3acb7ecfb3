// SPDX-License-Identifier: Apache-2.0
#include "analysis/level_drift.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/line_fit.hpp"
#include "base/online.hpp"

namespace lcrig {

namespace {

using Values = std::vector<double>;

constexpr std::size_t kLeastInLevel = 4;
// Chance exceeds it in one direction of a thousand runs.
constexpr double kSure = 3.3;
constexpr double kSameInAll = 0.9995;  // one-sided, that the levels drift the same way
constexpr std::size_t kFewLevels = 3;  // from so many levels their common shape is known
constexpr std::size_t kMostPairs = 40;  // readings, or means of neighbours, that are paired

// Medians of neighbours, at most kMostPairs of them. Few values are kept as they are.
Values condensed(const Values& y) {
  if (y.size() <= kMostPairs) return y;
  Values out;
  for (std::size_t k = 0; k < kMostPairs; ++k) {
    const auto at = [&](std::size_t i) {
      return y.begin() + static_cast<std::ptrdiff_t>(i * y.size() / kMostPairs);
    };
    out.push_back(median(Values(at(k), at(k + 1))));
  }
  return out;
}

double weighted_median(std::vector<std::pair<double, double>> values) {  // value, weight
  std::ranges::sort(values);
  double half = 0, sum = 0;
  for (const auto& v : values) half += v.second / 2;
  for (const auto& v : values) {
    sum += v.second;
    if (sum >= half) return v.first;
  }
  return 0;
}

// Values less their median. `y` must not be empty.
Values centred(Values y) {
  const double middle = median(y);
  for (double& v : y) v -= middle;
  return y;
}

// Size of the shape in the values: least squares without the values that are far from it. It starts
// from a median of ratios.
double size_of(const Values& shape, const Values& y) {
  constexpr double kFar = 5;  // robust standard deviations
  std::vector<std::pair<double, double>> ratios;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (shape[i] != 0) ratios.emplace_back(y[i] / shape[i], std::abs(shape[i]));
  }
  double size = weighted_median(std::move(ratios));
  for (int pass = 0; pass < 2; ++pass) {
    Values left(y.size());
    for (std::size_t i = 0; i < y.size(); ++i) left[i] = y[i] - size * shape[i];
    const double middle = median(left), far = kFar * robust_sigma(left);
    RunningLine line;
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (std::abs(left[i] - middle) <= far) line.add(shape[i], y[i]);
    }
    if (line.sxx() > 0) size = line.slope();
  }
  return size;
}

Values logarithmic(std::size_t readings) {
  Values out(readings);
  for (std::size_t i = 0; i < readings; ++i) out[i] = std::log1p(static_cast<double>(i));
  return centred(std::move(out));
}

Values exponential(std::size_t readings, double time) {
  Values out(readings);
  for (std::size_t i = 0; i < readings; ++i) out[i] = -std::exp(-static_cast<double>(i) / time);
  return centred(std::move(out));
}

// Shape that fits one level best: logarithmic, or exponential with a time from half a reading to
// twice the level.
Values shape_of_one(const Values& y) {
  const auto misfit = [&y](const Values& shape) {
    const double size = size_of(shape, y);
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) sum += std::sqrt(std::abs(y[i] - size * shape[i]));
    return sum;
  };
  Values best = logarithmic(y.size());
  double least = misfit(best);
  for (double time = 0.5; time <= 2 * static_cast<double>(y.size()); time *= 1.5) {
    Values shape = exponential(y.size(), time);
    const double sum = misfit(shape);
    if (sum < least) least = sum, best = std::move(shape);
  }
  return best;
}

// Shape that all levels have in common, reading by reading, and the size of each level's.
Values common_shape(const std::vector<const Values*>& levels) {
  std::size_t longest = 0;
  for (const Values* y : levels) longest = std::max(longest, y->size());
  Values shape = logarithmic(longest);
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<std::vector<std::pair<double, double>>> at(longest);
    for (const Values* y : levels) {
      const double size = size_of(shape, *y);
      for (std::size_t i = 0; i < y->size() && size != 0; ++i) {
        at[i].emplace_back((*y)[i] / size, std::abs(size));
      }
    }
    for (std::size_t i = 0; i < longest; ++i) {
      if (!at[i].empty()) shape[i] = weighted_median(std::move(at[i]));
    }
    shape = centred(std::move(shape));
  }
  return shape;
}

// Many levels show by themselves how much of a trend correlated readings make by chance. (Their
// correlation cannot tell: a creep makes readings look correlated.)
bool is_sure(const Values& trends, double widening) {
  const auto n = static_cast<double>(trends.size());
  const double mean = std::accumulate(trends.begin(), trends.end(), 0.0) / n;
  const bool few = trends.size() <= kFewLevels;
  if (std::abs(mean) * std::sqrt(n) <= kSure * (few ? std::max(1.0, widening) : 1)) return false;
  if (few) return true;
  double squares = 0;
  for (const double t : trends) squares += (t - mean) * (t - mean);
  const double error = std::sqrt(squares / (n - 1) / n);
  return std::abs(mean) > student_t_quantile(kSameInAll, n - 1) * error;
}

}  // namespace

double rank_trend(const std::vector<double>& values) {
  const Values y = condensed(values);
  const auto n = static_cast<double>(y.size());
  double sum = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    for (std::size_t k = i + 1; k < y.size(); ++k) sum += (y[k] > y[i]) - (y[k] < y[i]);
  }
  return sum / std::sqrt(n * (n - 1) * (2 * n + 5) / 18);
}

LevelDrift::LevelDrift(const std::vector<LevelSeries>& levels, double widening)
    : drift_fF_(levels.size()) {
  for (const Direction direction : {Direction::up, Direction::down}) {
    std::vector<std::size_t> which;
    std::vector<Values> values;
    Values trends;
    for (std::size_t k = 0; k < levels.size(); ++k) {
      if (levels[k].direction != direction || levels[k].fF.size() < kLeastInLevel) continue;
      which.push_back(k);
      values.push_back(centred(levels[k].fF));
      trends.push_back(rank_trend(levels[k].fF));
    }
    if (which.empty() || !is_sure(trends, widening)) continue;
    std::vector<const Values*> all;
    for (const Values& y : values) all.push_back(&y);
    const bool few = which.size() < kFewLevels;
    const Values common = few ? Values() : common_shape(all);
    for (std::size_t k = 0; k < which.size(); ++k) {
      Values shape = few ? shape_of_one(values[k]) : common;
      shape.resize(values[k].size());
      const double size = size_of(shape, values[k]);
      for (double& v : shape) v *= size;
      drift_fF_[which[k]] = std::move(shape);
    }
  }
}

double LevelDrift::change_fF(std::size_t level) const {
  const Values& drift = drift_fF_[level];
  return drift.empty() ? 0 : drift.back() - drift.front();
}

}  // namespace lcrig
