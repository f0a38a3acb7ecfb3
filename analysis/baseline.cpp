// SPDX-License-Identifier: Apache-2.0
// C0, the noise of a reading, and how the unloaded capacitance moves during the run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

constexpr const char* kC0 =
    "mean capacitance before anything touched the specimen; standard error from the scatter of the "
    "readings, with their correlation in time";
constexpr const char* kNoise =
    "standard deviation of one reading of the baseline, from the differences of neighbours (drift "
    "cancels)";
constexpr const char* kDrift =
    "slope of the unloaded capacitance over the run (the baseline and every rest between loadings)";

struct Baseline {
  Sample capacitance;  // F
  double square_differences = 0;  // of neighbours, F2
  std::vector<double> values;  // the first ones, for the correlation
};
constexpr std::size_t kForCorrelation = 100000;

void take(Baseline& b, double capacitance_F, std::optional<double>& before) {
  b.capacitance.add(capacitance_F);
  if (before) b.square_differences += (capacitance_F - *before) * (capacitance_F - *before);
  before = capacitance_F;
  if (b.values.size() < kForCorrelation) b.values.push_back(capacitance_F);
}

// Before contact; a run that tells none: the unloaded readings before the first loading.
Baseline collect(const Scene& scene, const RunAnalysis& out) {
  const RunData& data = scene.data;
  Baseline b;
  std::optional<double> before;
  const double end = !out.cycles.empty() ? out.cycles.front().begin_s : data.duration_s;
  for (const RunReading& r : data.readings) {
    if (data.contact_s ? r.t_s >= *data.contact_s : r.t_s >= end) break;
    if (!scene.uses(r)) continue;
    if (!data.contact_s && !scene.is_unloaded(r)) continue;
    take(b, r.capacitance_F, before);
  }
  return b;
}

// By what the variance of the mean is larger than for readings that know nothing of each other:
// (1 + rho)/(1 - rho) of a first-order process, when the correlation stands out of its own noise.
double correlation_factor(const Baseline& b) {
  const auto n = b.values.size();
  if (n < 20) return 1;
  double products = 0, squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double d = b.values[i] - b.capacitance.mean;
    squares += d * d;
    if (i > 0) products += d * (b.values[i - 1] - b.capacitance.mean);
  }
  if (squares <= 0) return 1;
  const double rho = std::min(products / squares, 0.99);
  return rho > 3 / std::sqrt(static_cast<double>(n)) ? (1 + rho) / (1 - rho) : 1;
}

void calc_c0(const Scene& scene, const Baseline& b, RunAnalysis& out) {
  const auto n = static_cast<double>(b.capacitance.count);
  out.c0.rows = b.capacitance.count;
  Estimate e;
  e.value = b.capacitance.mean * 1e12;
  if (b.capacitance.count >= 2) {
    const double se = std::sqrt(b.capacitance.variance() / n * correlation_factor(b)) * 1e12;
    e = estimate(e.value, se, n - 1, scene.options.confidence);
  } else {
    out.c0.reason = "one reading: no scatter";
  }
  out.c0.estimate = e;
}

// The scatter within the levels, when there is no baseline to tell it.
void calc_noise(const Scene& scene, const Baseline& b, RunAnalysis& out) {
  double variance = 0, freedom = 0;
  if (b.capacitance.count >= 10) {
    const auto n = static_cast<double>(b.capacitance.count);
    variance = b.square_differences / (2 * (n - 1));
    freedom = (n - 1) / 1.5;  // of mean squared differences (von Neumann 1941)
    out.noise.rows = b.capacitance.count;
  } else {
    for (const LevelResult& l : out.levels) {
      if (!l.scatter_fF) continue;
      const double f = l.readings - 1;
      variance += f * *l.scatter_fF * *l.scatter_fF * 1e-30;
      freedom += f;
      out.noise.rows += l.readings;
    }
    if (freedom < 3) {
      out.noise.reason = "fewer than ten readings before contact, and no scatter within levels";
      return;
    }
    variance /= freedom;
    out.noise.reason = "from the scatter within the levels: there is no baseline";
  }
  const double sigma = std::sqrt(variance) * 1e15;
  out.noise.estimate =
      estimate(sigma, sigma / std::sqrt(2 * freedom), freedom, scene.options.confidence);
}

void calc_drift(const Scene& scene, RunAnalysis& out) {
  std::vector<LinePoint> rests;
  const auto add = [&rests](double t_s, double pF, std::optional<double> se_fF) {
    if (se_fF && *se_fF > 0) rests.push_back({t_s, pF * 1e3, 1 / (*se_fF * *se_fF)});
  };
  for (const CycleResult& c : out.cycles) add(c.rest_s, c.rest_pF, c.rest_se_fF);
  for (std::size_t i = 0; i < scene.rest_end_s.size(); ++i) {
    add(scene.rest_end_s[i], scene.rest_end_pF[i], scene.rest_end_se_fF[i]);
  }
  const auto line = fit_line(rests);
  if (!line) {
    out.drift.reason = "it takes two stretches without load, before and after a loading";
    return;
  }
  out.drift_of_baseline_fF = rests.back().y - rests.front().y;
  out.drift.rows = static_cast<std::int64_t>(rests.size());
  // Weights are 1/variance, so noise alone gives 1; what the specimen adds shows in the residuals.
  const int freedom = line->points - 2;
  double variance = 1, dof = std::numeric_limits<double>::infinity();
  if (freedom >= 3) {
    variance = line->residual_ss / freedom;
    dof = freedom;
  }
  out.drift.estimate =
      estimate(line->slope * 3600, line->slope_se(variance) * 3600, dof, scene.options.confidence);
}

}  // namespace

void calc_baseline(const Scene& scene, RunAnalysis& out) {
  const Baseline b = collect(scene, out);
  out.c0 = metric("C0_pF", kC0);
  out.noise = metric("noise_fF", kNoise);
  out.drift = metric("baseline_drift_fF_per_h", kDrift);
  if (b.capacitance.count > 0) {
    calc_c0(scene, b, out);
  } else {
    out.c0.reason = scene.data.contact_s
                        ? "no reading was taken before contact under the settings of the run"
                        : "no reading without load comes before the first loading";
  }
  calc_noise(scene, b, out);
  calc_drift(scene, out);
}

}  // namespace lcrig
