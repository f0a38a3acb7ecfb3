// SPDX-License-Identifier: Apache-2.0
// Finds the stretches without load. They give the minimum of each cycle, the drift of the run and
// the correlation of neighbouring readings.
#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

// Rest k lies before cycle k; the last rest comes after all cycles.
struct Rest {
  double from_s = 0, to_s = 0;
  std::size_t first = 0, last = 0;  // of the readings
  RunningMean capacitance, time;  // pF and s, of the readings that count
  bool any = false;
  bool by_force = true;  // only readings with a resting force count; else all of the stretch

  void add(const RunReading& r, std::size_t i) {
    if (capacitance.count == 0) first = i;
    last = i + 1;
    capacitance.add(r.capacitance_F * 1e12);
    time.add(r.t_s);
  }
};

template <class Visit>
void each_resting(const RunView& view, const std::vector<Loading>& loadings, Visit visit) {
  const auto& readings = view.data.readings;
  std::size_t k = 0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    while (k < loadings.size() && i >= loadings[k].last) ++k;
    if (k < loadings.size() && i >= loadings[k].first) continue;
    if (view.uses(readings[i]) && view.is_at_rest(i)) visit(k, i);
  }
}

// After a load the capacitance recovers, which is not drift. Of a rest that follows a load only the
// later half counts.
std::vector<Rest> collect_rests(const RunView& view, const std::vector<Loading>& loadings) {
  const auto& readings = view.data.readings;
  std::vector<Rest> rests(loadings.size() + 1);
  each_resting(view, loadings, [&](std::size_t k, std::size_t i) {
    Rest& r = rests[k];
    if (!r.any) r.from_s = readings[i].t_s;
    r.any = true;
    r.to_s = readings[i].t_s;
  });
  for (std::size_t k = 1; k < rests.size(); ++k) {
    rests[k].from_s = (rests[k].from_s + rests[k].to_s) / 2;
  }
  each_resting(view, loadings, [&](std::size_t k, std::size_t i) {
    if (readings[i].t_s >= rests[k].from_s) rests[k].add(readings[i], i);
  });
  return rests;
}

// Readings before the first touch; without a recorded contact, the rest before the first loading.
Rest baseline_of(const RunView& view, const std::vector<Rest>& rests) {
  if (!view.touch_s) return rests.front();
  Rest out;
  const auto& readings = view.data.readings;
  for (std::size_t i = 0; i < readings.size() && readings[i].t_s < *view.touch_s; ++i) {
    if (view.uses(readings[i])) out.add(readings[i], i);
  }
  out.by_force = false;
  return out;
}

// The rate of the line through the rests, to be taken out: a drift is not a correlation.
double rate_of(const Rest& baseline, const std::vector<Rest>& rests) {
  std::vector<LinePoint> points;
  const auto add = [&points](const Rest& r) {
    const auto n = static_cast<double>(r.capacitance.count);
    if (n >= kLeastOfRest) points.push_back({r.time.mean, r.capacitance.mean * 1e3, n});
  };
  add(baseline);
  for (std::size_t k = 1; k < rests.size(); ++k) add(rests[k]);
  const auto line = fit_line(points);
  return line ? line->slope : 0;
}

EvenStretch stretch_of(const RunView& view, const Rest& rest, double rate_fF_s) {
  EvenStretch s;
  for (std::size_t i = rest.first; i < rest.last; ++i) {
    const RunReading& r = view.data.readings[i];
    if (view.uses(r)) s.add(r.capacitance_F * 1e15 - rate_fF_s * r.t_s);
  }
  return s;
}

// Finds the correlation from the stretches in which the readings ought to be equal.
void find_correlation(const RunView& view, const Rest& baseline, const std::vector<Rest>& rests,
                      Rests& out) {
  const double rate = rate_of(baseline, rests);
  std::vector<EvenStretch> stretches{stretch_of(view, baseline, rate)};
  for (std::size_t k = 1; k < rests.size(); ++k) {
    stretches.push_back(stretch_of(view, rests[k], rate));
  }
  out.rest_correlation = fit_correlation(stretches);
  std::vector<EvenStretch> levels(view.data.levels.size());
  for (EvenStretch& level : levels) level.trend = true;
  for (const RunReading& r : view.data.readings) {
    const auto k = static_cast<std::size_t>(r.level) - 1;
    if (r.index > 0 && r.level > 0 && k < levels.size() && view.uses(r)) {
      levels[k].add(r.capacitance_F * 1e15);
    }
  }
  out.correlation = fit_correlation(levels);
  if (out.correlation.freedom <= 0) out.correlation = out.rest_correlation;
}

bool counts(const RunView& view, const Rest& rest, std::size_t i) {
  return view.uses(view.data.readings[i]) && (!rest.by_force || view.is_at_rest(i));
}

struct Spread {
  std::vector<double> middle_F, sigma_F;  // of each rest; sigma 0: outliers cannot be recognised
  double limit = 0;  // in units of sigma
};

// Spread of the readings about the median of their rest, as robust standard deviations. All rests
// share one, except those in which the specimen still moves.
Spread spread_of(const RunView& view, const std::vector<const Rest*>& rests) {
  Spread out;
  std::vector<double> all, values;
  for (const Rest* r : rests) {
    values.clear();
    for (std::size_t i = r->first; i < r->last; ++i) {
      if (counts(view, *r, i)) values.push_back(view.data.readings[i].capacitance_F);
    }
    out.middle_F.push_back(values.empty() ? 0 : median(values));
    out.sigma_F.push_back(robust_sigma(values));
    for (const double v : values) all.push_back(v - out.middle_F.back());
  }
  const double pooled = robust_sigma(all);
  for (double& sigma : out.sigma_F) sigma = std::max(sigma, pooled);
  constexpr double kFewReadings = 3;  // factor, because few readings tell their scatter badly
  if (!all.empty()) out.limit = kFewReadings * limit_of_outliers(all.size());
  return out;
}

// Makes the nodes of the drift. Outliers are left out, because one among the few readings of a rest
// would tilt the line through all rests.
std::vector<RestNode> nodes_of(const RunView& view, const Correlation& correlation,
                               const Rest& baseline, const std::vector<Rest>& rests,
                               std::vector<Outlier>& outliers) {
  std::vector<const Rest*> all{&baseline};
  for (std::size_t k = 1; k < rests.size(); ++k) all.push_back(&rests[k]);
  const Spread spread = spread_of(view, all);
  double ss = 0, freedom = 0;  // one scatter for all: a rest has too few readings
  std::vector<RestNode> nodes;
  for (std::size_t k = 0; k < all.size(); ++k) {
    RunningMean capacitance, time;
    for (std::size_t i = all[k]->first; i < all[k]->last; ++i) {
      if (!counts(view, *all[k], i)) continue;
      const RunReading& r = view.data.readings[i];
      const double off_F = std::abs(r.capacitance_F - spread.middle_F[k]);
      if (spread.sigma_F[k] > 0 && off_F > spread.limit * spread.sigma_F[k]) {
        outliers.push_back(outlier_of(r, spread.middle_F[k], spread.sigma_F[k]));
        continue;
      }
      capacitance.add(r.capacitance_F * 1e12);
      time.add(r.t_s);
    }
    if (capacitance.count < kLeastOfRest) continue;
    const auto n = static_cast<double>(capacitance.count);
    ss += capacitance.sum_squares * 1e6;
    freedom += (n - 1) * correlation.of_square(n);
    nodes.push_back({time.mean, capacitance.mean * 1e3, 0, n, all[k]->first, all[k]->last});
  }
  for (RestNode& n : nodes) {
    n.se_fF = std::sqrt(ss / freedom * correlation.of_mean(n.readings));
  }
  return nodes;
}

RestedLoading mark(const RunView& view, const Loading& loading, const Rest& rest,
                   const Correlation& correlation) {
  RestedLoading out(loading);
  const RunningMean& s = rest.capacitance;
  out.rest_pF = s.mean;
  out.rest_s = s.count > 0 ? rest.time.mean : loading.begin_s;
  if (s.count >= 2) {
    const auto n = static_cast<double>(s.count);
    const double square = correlation.of_square(n);
    out.rest_se_fF = std::sqrt(s.variance() / square * correlation.of_mean(n)) * 1e3;
  }
  // Without any resting reading (a run that begins loaded): the first loaded one.
  if (s.count == 0) out.rest_pF = view.data.readings[loading.first].capacitance_F * 1e12;
  return out;
}

}  // namespace

Rests find_rests(const RunView& view, const std::vector<Loading>& loadings) {
  const auto rests = collect_rests(view, loadings);
  const Rest baseline = baseline_of(view, rests);
  Rests out;
  find_correlation(view, baseline, rests, out);
  out.drift = Drift(nodes_of(view, out.rest_correlation, baseline, rests, out.outliers_of_rests));
  for (std::size_t k = 0; k < loadings.size(); ++k) {
    out.loadings.push_back(mark(view, loadings[k], rests[k], out.rest_correlation));
  }
  return out;
}

}  // namespace lcrig
