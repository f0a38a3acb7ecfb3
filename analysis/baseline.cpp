// SPDX-License-Identifier: Apache-2.0
// C0, the noise of a reading, and how the unloaded capacitance moves during the run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

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
    "cancels) without those of outliers, and from the correlation of neighbours";
constexpr const char* kDrift =
    "slope of the unloaded capacitance over the run: the baseline, and of every rest after a "
    "loading "
    "the later half, because recovery is no drift; it is subtracted from every result under load";
constexpr std::size_t kBatches = 10;
constexpr std::int64_t kTells = 10;  // readings; fewer do not reveal their own noise

struct Unloaded {
  RunningMean capacitance, steady;  // F; `steady` without the drift
  std::vector<double> differences;  // between neighbouring readings, F
  std::vector<double> values;  // the first readings, for the estimate from batches
};
constexpr std::size_t kForBatches = 100000;

// Adds a reading. The mean keeps the drift of the run, because C0 is the mean in the middle of the
// baseline. The scatter excludes it.
void take(Unloaded& b, double capacitance_F, double drift_F, std::optional<double>& before) {
  b.capacitance.add(capacitance_F);
  b.steady.add(capacitance_F - drift_F);
  if (before) b.differences.push_back(capacitance_F - *before);
  before = capacitance_F;
  if (b.values.size() < kForBatches) b.values.push_back(capacitance_F - drift_F);
}

// Readings before contact; without a recorded contact, unloaded ones before the first loading.
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

// Takes the variance between batches when it is larger than that from the correlation of
// neighbours. Only batches reveal noise that is slower than this correlation.
void add_batches(const Unloaded& b, MeanVariance& out) {
  const double batches = variance_of_batches(b.values, kBatches);
  if (batches <= out.variance) return;
  out = {batches, kBatches - 1.0, fmt::format("scatter of {} parts of the baseline", kBatches)};
}

// Error from slow noise in the sum of the nodes' means times `of_node`. nullopt: too few readings.
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

// A specimen that has not recovered yet shifts the rests after the first load. This shift must not
// count as noise of the baseline.
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
  std::int64_t left_out = 0;  // differences too large for normal noise
  double rho = 0;  // correlation of neighbours; it is included in the variance
  bool correlated = false,
       slower = false;  // `rho` is beyond chance; noise that is slower than such a correlation
};

// Deviance that white noise alone exceeds in one run of 200.
constexpr double kCorrelated = 6.6;

// Correlated readings tell their variance with fewer degrees of freedom; this is the factor.
double share_of_freedom(double rho) {
  return (1 - rho * rho) / (1 + rho * rho);
}

// Readings that are correlated differ less from their neighbours than the noise of one reading
// suggests; the variance is corrected for this. A random walk is recognised and not corrected: it
// has no variance, and the white noise beside it shows fully in the differences.
void add_correlation(const Unloaded& b, double limit, Noise& out) {
  std::vector<std::vector<double>> stretches(1);  // between outliers
  for (std::size_t i = 0; i < b.values.size(); ++i) {
    if (i > 0 && std::abs(b.differences[i - 1]) > limit) stretches.emplace_back();
    stretches.back().push_back((b.values[i] - b.values[0]) * 1e15);
  }
  std::vector<EvenStretch> even(stretches.size());
  for (std::size_t k = 0; k < even.size(); ++k) {
    even[k].trend = true;
    for (const double v : stretches[k]) even[k].add(v);
  }
  const Correlation c = fit_correlation(even);
  if (c.freedom <= 0 || out.variance <= 0) return;
  const double walk = deviance_of_walk(stretches);
  out.slower = walk < c.deviance && c.deviance_of_white - walk > kCorrelated;
  if (walk < c.deviance) return;
  out.rho = c.rho;
  out.correlated = c.deviance_of_white - c.deviance > kCorrelated;
  out.variance /= 1 - c.rho;
  // Variance from a likelihood has more degrees of freedom where there is a correlation. The
  // factors come from our own simulation (docs/analysis.md).
  const double more = 1.5 / (1.5 - 0.25 * std::min(1.0, c.rho / 0.3));
  out.freedom = std::max(1.0, out.freedom * more * share_of_freedom(c.rho) - 4 * c.rho);
}

// The noise of one reading from the differences of neighbours. The limit for outliers is wider when
// there are few differences, because few tell their own spread badly.
Noise noise_of(const Unloaded& b) {
  const std::vector<double>& differences = b.differences;
  const auto all = static_cast<double>(differences.size());
  std::vector<double> sizes;
  sizes.reserve(differences.size());
  for (const double d : differences) sizes.push_back(std::abs(d));
  const double sigma = 1.4826 * median(std::move(sizes));  // about 0, not about their own median
  const double limit =
      sigma > 0 ? limit_of_outliers(differences.size()) * (1 + 3 / std::sqrt(all)) * sigma
                : std::numeric_limits<double>::infinity();
  Noise out;
  double squares = 0, n = 0;
  for (const double d : differences) {
    if (std::abs(d) > limit) {
      ++out.left_out;
    } else {
      squares += d * d;
      n += 1;
    }
  }
  out.variance = squares / (2 * n);
  out.freedom = n / 1.5;  // of a mean of squared differences (von Neumann 1941)
  add_correlation(b, limit, out);
  return out;
}

// The scatter within the levels, for a run whose baseline is too short to tell the noise. Levels
// with outliers are left out.
Noise noise_within(const Scene& scene, const MeasuredLevels& measured, std::int64_t& rows) {
  const Correlation& c = scene.correlation;
  Noise out;
  double shown = 0;  // degrees of freedom, less what the levels' means take of them
  for (const MeasuredLevel& l : measured.levels) {
    if (!l.scatter_fF || l.outliers > 0) continue;
    const double f = l.readings - 1;
    out.variance += f * *l.scatter_fF * *l.scatter_fF * 1e-30;
    out.freedom += f;
    shown += f * c.of_square(l.readings);
    rows += l.readings;
  }
  if (out.freedom < 3) return {};
  out.rho = c.rho;
  out.correlated = c.deviance_of_white - c.deviance > kCorrelated;
  out.variance /= shown;
  out.freedom = std::max(1.0, out.freedom * share_of_freedom(c.rho));
  return out;
}

void calc_noise(const Scene& scene, const Unloaded& b, const MeasuredLevels& measured,
                BaselineResult& out) {
  Noise noise;
  if (b.capacitance.count >= kTells) {
    noise = noise_of(b);
    out.noise.rows = b.capacitance.count;
    if (noise.left_out > 0) {
      out.noise.reason = fmt::format(
          "{} differences that no normal noise makes are left out: of outliers", noise.left_out);
    }
  } else {
    noise = noise_within(scene, measured, out.noise.rows);
    if (noise.freedom <= 0) {
      out.noise.reason = "fewer than ten readings before contact, and no scatter within levels";
      return;
    }
    out.noise.reason = "from the scatter within the levels: there is no baseline";
  }
  if (noise.correlated) {
    add_remark(
        out.noise.reason,
        fmt::format("neighbouring readings are correlated ({:.2g}), which is in it", noise.rho));
  }
  if (noise.slower) {
    add_remark(out.noise.reason, "there is noise slower than a reading, which is not in it");
  }
  const double sigma = std::sqrt(noise.variance) * 1e15;
  out.noise.estimate = estimate_of_deviation(sigma, noise.freedom, scene.options.confidence);
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
  calc_noise(scene, b, measured, out);
  calc_drift(scene, scene.options.confidence, out);
  return out;
}

}  // namespace lcrig
