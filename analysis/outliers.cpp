// SPDX-License-Identifier: Apache-2.0
#include "analysis/outliers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/level_drift.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kListedOutliers = 1000;
// Share of runs without outliers in which one is found by mistake. It sets the limit for outliers.
constexpr double kFalseOutliers = 0.01;

// Corrects the robust standard deviation of few readings. Readings lie nearer to the median of
// their own few than to the true middle. The factor is their standard deviation over 1.4826 times
// the median of their distances. It comes from 400,000 sets of normal numbers for each size; from
// ten readings on the formula holds within 1.2 %.
double robust_sigma_factor(std::int32_t readings) {
  constexpr std::array kOfFew = {1.390, 1.375, 1.277, 1.223, 1.197, 1.158};  // for 4 to 9 readings
  const auto k = static_cast<std::size_t>(readings - 4);
  return k < kOfFew.size() ? kOfFew[k] : readings / (readings - 1.3);
}

// Factor on `limit_of_outliers` for `all` readings, `each` in a level: the farthest one exceeds the
// product in one run of a hundred. The median of few may be off, and their scatter is badly known.
// From 1500 to 20,000 runs of normal numbers for 4 to 50 readings of 3 to 80 levels; within 5 %.
double limit_of_few(double all, double each) {
  return 1 + (0.7 + 4 / each) / std::sqrt(all) + (2 + 33 / each) / all;
}

std::vector<LevelSeries> series_of(const RunView& view, const std::vector<MeasuredLevel>& levels) {
  std::vector<LevelSeries> out;
  for (const MeasuredLevel& l : levels) {
    LevelSeries& s = out.emplace_back();
    s.direction = l.direction;
    for (std::size_t i = l.first; i < l.last; ++i) {
      const RunReading& r = view.data.readings[i];
      if (counts_in_level(view, r)) s.fF.push_back(r.capacitance_F * 1e15);
    }
  }
  return out;
}

// The readings of the levels less their drift, each beside the median of its level.
struct Steady {
  Steady(const RunView& view, const Rests& rests, const std::vector<MeasuredLevel>& levels)
      : drift(series_of(view, levels), rests.rest_correlation.widening()) {
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const MeasuredLevel& l = levels[k];
      std::size_t reading = 0;
      for (std::size_t i = l.first; i < l.last; ++i) {
        const RunReading& r = view.data.readings[i];
        if (!counts_in_level(view, r)) continue;
        const double drift_fF = drift.drifts(k) ? drift.at(k, reading) : 0;
        values_F.push_back(r.capacitance_F - drift_fF * 1e-15);
        ++reading;
      }
      ends.push_back(values_F.size());
      const auto begin = values_F.end() - static_cast<std::ptrdiff_t>(reading);
      medians_F.push_back(reading == 0 ? 0 : median(std::vector<double>(begin, values_F.end())));
    }
  }
  // Readings of a level that tell its scatter: a drift that is fitted takes one.
  std::int32_t free(std::size_t level, const MeasuredLevel& l) const {
    return l.readings - (drift.drifts(level) ? 1 : 0);
  }
  LevelDrift drift;
  std::vector<double> values_F, medians_F;  // of all levels; of each level
  std::vector<std::size_t> ends;  // of each level in values_F
};

constexpr std::int32_t kLeastToJudge = 4;
// Factor on the limit where a drift was fitted, whose own noise adds to that of a reading. With it
// 1 to 2 % of drawn runs of creep without spikes show one (tests/unit/analysis/creep_words_test).
constexpr double kFitted = 1.3;

// The largest drift within a level, and how much it is of the change that the load made.
void report_drift(const Rests& rests, const LevelDrift& drift, MeasuredLevels& out) {
  for (std::size_t k = 0; k < out.levels.size(); ++k) {
    if (!drift.drifts(k)) continue;
    const double change_fF = drift.change_fF(k);
    DriftInLevels& d = out.drift_in_levels ? *out.drift_in_levels : out.drift_in_levels.emplace();
    ++d.levels;
    if (std::abs(change_fF) < std::abs(d.largest_fF)) continue;
    d.largest_fF = change_fF;
    d.kPa = out.levels[k].target_kPa.value_or(out.levels[k].pressure_kPa);
    if (rests.loadings.empty()) continue;
    const double of_load_fF = (out.levels[k].mean_pF - rests.loadings.front().rest_pF) * 1e3;
    if (of_load_fF != 0) d.percent = change_fF / of_load_fF * 100;
  }
}

std::vector<std::size_t> used_in(const RunView& view, const Loading& c) {
  std::vector<std::size_t> out;
  for (std::size_t i = c.first; i < c.last; ++i) {
    if (view.uses(view.data.readings[i])) out.push_back(i);
  }
  return out;
}

// Noise of one reading during a loading, from second differences, in which an even loading cancels.
double noise_of_loadings(const RunView& view, const Rests& rests) {
  std::vector<double> bends;
  for (const RestedLoading& c : rests.loadings) {
    const auto used = used_in(view, c);
    for (std::size_t k = 1; k + 1 < used.size(); ++k) {
      const auto at = [&](std::size_t i) { return view.data.readings[used[i]].capacitance_F; };
      bends.push_back(at(k - 1) - 2 * at(k) + at(k + 1));
    }
  }
  return robust_sigma(bends) / std::sqrt(6.0);
}

constexpr std::size_t kWindow = 7, kMost = 5;  // kMost: the closest together, whose spread counts
using Seven = std::array<double, kWindow>;

bool is_steady(const RunView& view, const std::vector<std::size_t>& used, std::size_t begin) {
  constexpr double kForceBand = 0.02;  // of the force, as for a hold
  double low = 0, high = 0;
  for (std::size_t i = 0; i < kWindow; ++i) {
    const RunReading& r = view.data.readings[used[begin + i]];
    if (!r.has_force()) return false;
    const double force_N = view.above_rest_N(r);
    low = i == 0 ? force_N : std::min(low, force_N);
    high = i == 0 ? force_N : std::max(high, force_N);
  }
  return high - low <= std::max(kForceBand * std::abs(high), 6 * view.force_noise_N);
}

// Readings about the line of their median slope (Theil, Sen): a creep is not far from it.
Seven about_line(Seven y) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < kWindow; ++i) {
    for (std::size_t k = i + 1; k < kWindow; ++k) {
      slopes.push_back((y[k] - y[i]) / static_cast<double>(k - i));
    }
  }
  const double slope = median(std::move(slopes));
  for (std::size_t i = 0; i < kWindow; ++i) y[i] -= slope * static_cast<double>(i);
  return y;
}

// Of the values that are closest together.
double spread_of(Seven y) {
  std::ranges::sort(y);
  double out = y[kMost - 1] - y[0];
  for (std::size_t i = 1; i + kMost <= kWindow; ++i) out = std::min(out, y[i + kMost - 1] - y[i]);
  return out;
}

// A reading beside its neighbours: around it, or on one side of it if only there the load is
// steady. Under a steady load a line through them is taken out.
struct Neighbours {
  Neighbours(const RunView& view, const std::vector<std::size_t>& used, std::size_t k) {
    const std::size_t last = used.size() - kWindow;
    std::size_t begin = std::min(k - std::min(k, kWindow / 2), last);
    bool steady = false;
    for (const std::size_t from : {begin, std::min(k, last), k - std::min(k, kWindow - 1)}) {
      if (from > last || !is_steady(view, used, from)) continue;
      steady = true;
      begin = from;
      break;
    }
    Seven near{};
    for (std::size_t i = 0; i < kWindow; ++i) {
      near[i] = view.data.readings[used[begin + i]].capacitance_F;
    }
    // Where a load has just become steady, a creep bends the most.
    if (steady && begin == k) least_F = spread_of(near);
    if (steady) near = about_line(near);
    off_F = near[k - begin] - median(std::vector<double>(near.begin(), near.end()));
    spread_F = spread_of(near);
  }
  bool stands_out() const {
    constexpr double kStandsOut = 5;
    return std::abs(off_F) > std::max(kStandsOut * spread_F, least_F);
  }
  double off_F = 0, spread_F = 0, least_F = 0;
};

// Finds readings far from the median of their neighbours in a loading. Such a reading is off by
// `limit` standard deviations, and by more than five times the spread of its neighbours. A turn of
// the force or a bend of the curve does not do that.
void find_outliers_of_loading(const RunView& view, const Loading& c, double sigma, double limit,
                              std::vector<Outlier>& out) {
  const auto used = used_in(view, c);
  if (used.size() < kWindow) return;
  for (std::size_t k = 0; k < used.size(); ++k) {
    const Neighbours neighbours(view, used, k);
    if (std::abs(neighbours.off_F) <= limit * sigma || !neighbours.stands_out()) continue;
    const RunReading& r = view.data.readings[used[k]];
    out.push_back(outlier_of(r, r.capacitance_F - neighbours.off_F, sigma));
  }
}

}  // namespace

bool counts_in_level(const RunView& view, const RunReading& r) {
  return r.index > 0 && r.level > 0 && view.uses(r) && (r.has_force() || !view.data.has_frame());
}

double limit_of_outliers(std::size_t readings) {
  const double tail = kFalseOutliers / (2 * static_cast<double>(readings));
  return std::max(3.5, -normal_quantile(tail));
}

Outlier outlier_of(const RunReading& r, double middle_F, double sigma_F) {
  const double off = r.capacitance_F - middle_F;
  return {r.t_s, 0, 0, r.capacitance_F * 1e12, off * 1e15, off / sigma_F};
}

// Compares every reading, less the drift of its level, with the median of the level, in pooled
// robust standard deviations.
void find_outliers_of_levels(const RunView& view, const Rests& rests, MeasuredLevels& out) {
  const auto& readings = view.data.readings;
  const Steady steady(view, rests, out.levels);
  report_drift(rests, steady.drift, out);
  std::vector<double> all;
  double judged = 0;  // number of levels with enough readings
  for (std::size_t k = 0; k < out.levels.size(); ++k) {
    const MeasuredLevel& l = out.levels[k];
    if (steady.free(k, l) < kLeastToJudge) continue;
    const double factor = robust_sigma_factor(steady.free(k, l));
    for (std::size_t i = k == 0 ? 0 : steady.ends[k - 1]; i < steady.ends[k]; ++i) {
      all.push_back(factor * (steady.values_F[i] - steady.medians_F[k]));
    }
    judged += 1;
  }
  const double sigma = robust_sigma(all);
  if (sigma <= 0) return;
  const auto count = static_cast<double>(all.size());
  const double limit = limit_of_outliers(all.size()) * limit_of_few(count, count / judged);
  for (std::size_t k = 0; k < out.levels.size(); ++k) {
    MeasuredLevel& l = out.levels[k];
    std::size_t at = k == 0 ? 0 : steady.ends[k - 1];
    for (std::size_t i = l.first; i < l.last; ++i) {
      if (!counts_in_level(view, readings[i])) continue;
      const double off_F = steady.values_F[at++] - steady.medians_F[k];
      const double allowed_F = (steady.drift.drifts(k) ? kFitted : 1) * limit * sigma;
      if (steady.free(k, l) < kLeastToJudge || std::abs(off_F) <= allowed_F) continue;
      Outlier found = outlier_of(readings[i], readings[i].capacitance_F - off_F, sigma);
      found.level = l.level;
      found.index = readings[i].index;
      ++l.outliers;
      out.outliers.outliers.push_back(found);
    }
  }
}

void find_outliers_of_loadings(const RunView& view, const Rests& rests, Outliers& out) {
  const double sigma = noise_of_loadings(view, rests);
  if (sigma <= 0) return;
  const double limit = limit_of_outliers(view.data.readings.size());
  for (const RestedLoading& c : rests.loadings) {
    find_outliers_of_loading(view, c, sigma, limit, out.outliers);
  }
}

void keep_largest_outliers(std::vector<Outlier>& outliers) {
  std::sort(outliers.begin(), outliers.end(), [](const Outlier& a, const Outlier& b) {
    return std::abs(a.deviations) > std::abs(b.deviations);
  });
  if (outliers.size() > kListedOutliers) outliers.resize(kListedOutliers);
}

}  // namespace lcrig
