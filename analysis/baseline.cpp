// SPDX-License-Identifier: Apache-2.0
// C0, the noise of a reading, and how the unloaded capacitance moves during the run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"

namespace lcrig {

namespace {

constexpr const char* kC0 =
    "mean capacitance before anything touched the specimen, at the middle of that time; standard "
    "error from the scatter of the readings with their correlation in time, of parts of the "
    "baseline "
    "or of the rests, whichever says most";
constexpr const char* kNoise =
    "standard deviation of one reading of the baseline, from the differences of neighbours (drift "
    "cancels)";
constexpr const char* kDrift =
    "slope of the unloaded capacitance over the run: the baseline, and of every rest after a "
    "loading "
    "the later half, because recovery is no drift; it is subtracted from every result under load";
constexpr std::size_t kBatches = 10;
constexpr double kPlain = 0.2;  // probability that noise alone does it

struct Unloaded {
  RunningMean capacitance, steady;  // F; the second without the drift
  double square_differences = 0;  // of neighbours, F2
  std::vector<double> values;  // the first ones, for the batches
};
constexpr std::size_t kForBatches = 100000;

// The drift of the run takes part in the mean, which is that of the middle, and not in the scatter.
void take(Unloaded& b, double capacitance_F, double drift_F, std::optional<double>& before) {
  b.capacitance.add(capacitance_F);
  b.steady.add(capacitance_F - drift_F);
  if (before) b.square_differences += (capacitance_F - *before) * (capacitance_F - *before);
  before = capacitance_F;
  if (b.values.size() < kForBatches) b.values.push_back(capacitance_F - drift_F);
}

// Before contact; a run that tells none: the unloaded readings before the first loading.
Unloaded collect(const Scene& scene) {
  const RunData& data = scene.data;
  Unloaded b;
  std::optional<double> before;
  const double end = !scene.loadings.empty() ? scene.loadings.front().begin_s : data.duration_s;
  for (const RunReading& r : data.readings) {
    if (data.contact_s ? r.t_s >= *data.contact_s : r.t_s >= end) break;
    if (!scene.uses(r)) continue;
    if (!data.contact_s && !scene.is_unloaded(r)) continue;
    const double drift_F = scene.drift.known() ? scene.drift.rate_fF_s() * r.t_s * 1e-15 : 0;
    take(b, r.capacitance_F, drift_F, before);
  }
  return b;
}

struct MeanVariance {
  double variance = 0, freedom = 0;
  std::string basis;
};

// From the readings and the correlation of neighbours; from batches where those say more: what is
// slower than the neighbours know shows in them only.
MeanVariance within_baseline(const Scene& scene, const Unloaded& b) {
  const auto n = static_cast<double>(b.capacitance.count);
  const Correlation& c = scene.rest_correlation;
  MeanVariance out{b.steady.variance() / c.of_square(n) * c.of_mean(n),
                   std::min(n - 1, c.degrees_of_freedom(n - 1)), "scatter of the baseline"};
  if (c.freedom <= 0) out.freedom = n - 1;
  const double batches = variance_of_batches(b.values, kBatches);
  if (batches > out.variance) {
    out = {batches, kBatches - 1.0, fmt::format("scatter of {} parts of the baseline", kBatches)};
  }
  return out;
}

// The rests after loads, about their own line: slower still. Only where it is plain, because they
// are few.
void add_rests(const Scene& scene, MeanVariance& out) {
  std::vector<LinePoint> rests;
  const auto& nodes = scene.drift.nodes();
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    if (nodes[k].se_fF > 0) {
      rests.push_back({nodes[k].t_s, nodes[k].fF, 1 / (nodes[k].se_fF * nodes[k].se_fF)});
    }
  }
  const auto line = fit_line(rests);
  if (!line || line->points < 3) return;
  const double freedom = line->points - 2, excess = line->residual_ss / freedom;
  if (f_tail(excess, freedom, 1e6) > kPlain) return;
  const double variance = line->residual_ss / freedom / (line->sum_weights / line->points) * 1e-30;
  if (variance <= out.variance) return;
  out = {variance, freedom, "scatter of the rests, which exceeds that within the baseline"};
}

void calc_c0(const Scene& scene, const Unloaded& b, const Outliers& outliers, BaselineResult& out) {
  out.c0.rows = b.capacitance.count;
  Estimate e(b.capacitance.mean * 1e12);
  if (b.capacitance.count >= 2) {
    MeanVariance v = within_baseline(scene, b);
    add_rests(scene, v);
    e = estimate(e.value, std::sqrt(v.variance) * 1e12, v.freedom, scene.options.confidence);
    out.c0_basis = v.basis;
  } else {
    out.c0.reason = "one reading: no scatter";
  }
  out.c0.estimate = e;
  const double robust = huber_location(b.values) * 1e12, se = e.standard_error.value_or(0);
  if (outliers.outlier_count > 0 && std::abs(e.value - robust) > 3 * se && se > 0) {
    out.c0.reason =
        fmt::format("outliers move it: without their weight (robust) it is {:.6g} pF", robust);
  }
}

// The scatter within the levels, when there is no baseline to tell it.
void calc_noise(const Unloaded& b, const MeasuredLevels& measured, double confidence,
                BaselineResult& out) {
  double variance = 0, freedom = 0;
  if (b.capacitance.count >= 10) {
    const auto n = static_cast<double>(b.capacitance.count);
    variance = b.square_differences / (2 * (n - 1));
    freedom = (n - 1) / 1.5;  // of mean squared differences (von Neumann 1941)
    out.noise.rows = b.capacitance.count;
  } else {
    for (const MeasuredLevel& l : measured.levels) {
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
  out.noise.estimate = estimate(sigma, sigma / std::sqrt(2 * freedom), freedom, confidence);
}

void calc_drift(const Drift& d, double confidence, BaselineResult& out) {
  if (!d.known()) {
    out.drift.reason = "it takes two stretches without load, before and after a loading";
    return;
  }
  out.drift_of_baseline_fF = d.nodes().back().fF - d.nodes().front().fF;
  out.drift.rows = static_cast<std::int64_t>(d.nodes().size());
  out.drift.estimate =
      estimate(d.rate_fF_s() * 3600, d.rate_se_fF_s() * 3600, d.rate_freedom(), confidence);
}

}  // namespace

BaselineResult calc_baseline(const Scene& scene, const MeasuredLevels& measured) {
  const Unloaded b = collect(scene);
  BaselineResult out;
  out.c0 = metric("C0_pF", kC0);
  out.noise = metric("noise_fF", kNoise);
  out.drift = metric("baseline_drift_fF_per_h", kDrift);
  if (b.capacitance.count > 0) {
    calc_c0(scene, b, measured.outliers, out);
  } else {
    out.c0.reason = scene.data.contact_s
                        ? "no reading was taken before contact under the settings of the run"
                        : "no reading without load comes before the first loading";
  }
  calc_noise(b, measured, scene.options.confidence, out);
  calc_drift(scene.drift, scene.options.confidence, out);
  return out;
}

}  // namespace lcrig
