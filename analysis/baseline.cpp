// SPDX-License-Identifier: Apache-2.0
// C0, the noise of a reading, and how the unloaded capacitance moves during the run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/metrics.hpp"
#include "analysis/quiet_blocks.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr const char* kC0 =
    "mean capacitance before anything touched the specimen, at the middle of that time; standard "
    "error from the scatter of the readings and from the noise that is slower, as far as all "
    "readings without a load tell it";
constexpr const char* kNoise =
    "standard deviation of one reading of the baseline, from the differences of neighbours (drift "
    "cancels) without those of outliers";
constexpr const char* kDrift =
    "slope of the unloaded capacitance over the run: the baseline, and of every rest after a "
    "loading "
    "the later half, because recovery is no drift; it is subtracted from every result under load";
constexpr std::size_t kBatches = 10;
constexpr std::int64_t kTells = 10;  // readings: fewer do not tell their own noise

struct Unloaded {
  RunningMean capacitance, steady;  // F; the second without the drift
  std::vector<double> differences;  // of neighbours, F
  std::vector<double> values;  // the first ones, for the batches
};
constexpr std::size_t kForBatches = 100000;

// The drift of the run takes part in the mean, which is that of the middle, and not in the scatter.
void take(Unloaded& b, double capacitance_F, double drift_F, std::optional<double>& before) {
  b.capacitance.add(capacitance_F);
  b.steady.add(capacitance_F - drift_F);
  if (before) b.differences.push_back(capacitance_F - *before);
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
    if (scene.touch_s ? r.t_s >= *scene.touch_s : r.t_s >= end) break;
    if (!scene.uses(r)) continue;
    if (!scene.touch_s && !scene.is_unloaded(r)) continue;
    const double drift_F = scene.drift.known() ? scene.drift.rate_fF_s() * r.t_s * 1e-15 : 0;
    take(b, r.capacitance_F, drift_F, before);
  }
  return b;
}

struct MeanVariance {
  double variance = 0, freedom = 0;
  std::string basis;
};

MeanVariance of_readings(const Scene& scene, const Unloaded& b) {
  const auto n = static_cast<double>(b.capacitance.count);
  const Correlation& c = scene.rest_correlation;
  MeanVariance out{b.steady.variance() / c.of_square(n) * c.of_mean(n),
                   std::min(n - 1, c.degrees_of_freedom(n - 1)), "scatter of the baseline"};
  if (c.freedom <= 0) out.freedom = n - 1;
  return out;
}

// Takes the variance from batches when it is larger: noise that is slower than the correlation of
// neighbours shows in batches only.
void add_batches(const Unloaded& b, MeanVariance& out) {
  const double batches = variance_of_batches(b.values, kBatches);
  if (batches <= out.variance) return;
  out = {batches, kBatches - 1.0, fmt::format("scatter of {} parts of the baseline", kBatches)};
}

// Error of the sum of the nodes' means, each times its `of_node`. nullopt: too few readings.
std::optional<SlopePart> slow_error(const Scene& scene, const std::vector<double>& of_node,
                                    double white, AfterLoad after_load) {
  const QuietBlocks quiet = cut_quiet_blocks(scene);
  const auto& nodes = scene.drift.nodes();
  std::vector<double> factor(quiet.blocks.size(), 0.0);
  for (std::size_t b = 0; b < factor.size(); ++b) {
    for (const auto& part : quiet.of_node[b]) {
      factor[b] += of_node[part.node] * part.readings / nodes[part.node].readings;
    }
  }
  const SlowNoise noise(quiet.blocks, scene.data.duration_s, after_load);
  if (!noise.known()) return std::nullopt;
  const SlopePart error = noise.error_of(factor, white, scene.options.confidence);
  return error.se > 0 ? std::optional(error) : std::nullopt;
}

// A specimen that has not recovered yet shifts the rests after the first load: that is not noise of
// the baseline.
MeanVariance error_of_c0(const Scene& scene, const Unloaded& b) {
  MeanVariance out = of_readings(scene, b);
  const auto& nodes = scene.drift.nodes();
  const bool first_is_baseline =
      !nodes.empty() &&
      (scene.loadings.empty() || nodes.front().t_s < scene.loadings.front().begin_s);
  if (first_is_baseline) {
    std::vector<double> of_node(nodes.size(), 0.0);
    of_node[0] = 1;
    if (const auto slow = slow_error(scene, of_node, out.variance * 1e30, AfterLoad::shifted)) {
      return {slow->se * slow->se * 1e-30, slow->degrees_of_freedom,
              "scatter of the baseline, and slower noise as all readings without a load tell it"};
    }
  }
  add_batches(b, out);
  return out;
}

void calc_c0(const Scene& scene, const Unloaded& b, const Outliers& outliers, BaselineResult& out) {
  out.c0.rows = b.capacitance.count;
  Estimate e(b.capacitance.mean * 1e12);
  if (b.capacitance.count >= 2) {
    const MeanVariance v = error_of_c0(scene, b);
    e = estimate(e.value, std::sqrt(v.variance) * 1e12, v.freedom, scene.options.confidence);
    out.c0_basis = v.basis;
  } else {
    out.c0.reason = "one reading: no scatter";
  }
  out.c0.estimate = e;
  if (b.capacitance.count >= 2 && b.capacitance.count < kTells) {
    out.c0.reason = fmt::format(
        "{} readings before contact: an outlier among them, or a movement while they were taken, "
        "would not show",
        b.capacitance.count);
  }
  const double robust = huber_location(b.values) * 1e12, se = e.standard_error.value_or(0);
  if (outliers.outlier_count > 0 && std::abs(e.value - robust) > 3 * se && se > 0) {
    add_remark(out.c0.reason, fmt::format("outliers move it: without their weight (robust) it is "
                                          "{:.6g} pF",
                                          robust));
  }
}

struct Noise {
  double variance = 0, freedom = 0;
  std::int64_t left_out = 0;  // differences that no normal noise makes
};

// Few differences tell their own spread badly, so the limit is wider for them.
Noise noise_of(const std::vector<double>& differences) {
  const auto all = static_cast<double>(differences.size());
  std::vector<double> sizes;
  sizes.reserve(differences.size());
  for (const double d : differences) sizes.push_back(std::abs(d));
  const double sigma = 1.4826 * median(std::move(sizes));  // about 0, not about their own median
  const double limit = limit_of_outliers(differences.size()) * (1 + 3 / std::sqrt(all)) * sigma;
  Noise out;
  double squares = 0, n = 0;
  for (const double d : differences) {
    if (sigma > 0 && std::abs(d) > limit) {
      ++out.left_out;
    } else {
      squares += d * d;
      n += 1;
    }
  }
  out.variance = squares / (2 * n);
  out.freedom = n / 1.5;  // of mean squared differences (von Neumann 1941)
  return out;
}

// The scatter within the levels, when there is no baseline to tell it; without the levels that have
// outliers.
void calc_noise(const Unloaded& b, const MeasuredLevels& measured, double confidence,
                BaselineResult& out) {
  double variance = 0, freedom = 0;
  if (b.capacitance.count >= kTells) {
    const Noise noise = noise_of(b.differences);
    variance = noise.variance;
    freedom = noise.freedom;
    out.noise.rows = b.capacitance.count;
    if (noise.left_out > 0) {
      out.noise.reason = fmt::format(
          "{} differences that no normal noise makes are left out: of outliers", noise.left_out);
    }
  } else {
    for (const MeasuredLevel& l : measured.levels) {
      if (!l.scatter_fF || l.outliers > 0) continue;
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
  out.noise.estimate = estimate_of_deviation(sigma, freedom, confidence);
}

void calc_drift(const Scene& scene, double confidence, BaselineResult& out) {
  const Drift& d = scene.drift;
  if (!d.known()) {
    out.drift.reason = "it takes two stretches without load, before and after a loading";
    return;
  }
  out.drift_of_baseline_fF = d.nodes().back().fF - d.nodes().front().fF;
  out.drift.rows = static_cast<std::int64_t>(d.nodes().size());
  SlopePart error{d.rate_se_fF_s(), d.rate_freedom()};
  const double white = d.rate_white_se_fF_s() * d.rate_white_se_fF_s();
  if (const auto slow = slow_error(scene, d.rate_influence(), white, AfterLoad::alike)) {
    error = *slow;
  }
  out.drift.estimate =
      estimate(d.rate_fF_s() * 3600, error.se * 3600, error.degrees_of_freedom, confidence);
}

}  // namespace

BaselineResult calc_baseline(const Scene& scene, const MeasuredLevels& measured) {
  const Unloaded b = collect(scene);
  BaselineResult out;
  out.c0 = metric("C0", "pF", kC0);
  out.noise = metric("noise", "fF", kNoise);
  out.drift = metric("baseline_drift", "fF/h", kDrift);
  if (b.capacitance.count > 0) {
    calc_c0(scene, b, measured.outliers, out);
  } else {
    out.c0.reason = scene.touch_s
                        ? "no reading was taken before contact under the settings of the run"
                        : "no reading without load comes before the first loading";
  }
  calc_noise(b, measured, scene.options.confidence, out);
  calc_drift(scene, scene.options.confidence, out);
  return out;
}

}  // namespace lcrig
