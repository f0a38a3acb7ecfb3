// SPDX-License-Identifier: Apache-2.0
#include "bench/worlds.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "analysis/line_fit.hpp"

namespace lcrig::worlds {

namespace {

constexpr double kDiameter_mm = 4;
constexpr double kArea_m2 = std::numbers::pi / 4 * kDiameter_mm * kDiameter_mm * 1e-6;

double newton_of(double kPa) {
  return kPa * 1e3 * kArea_m2;
}

// Builds a run reading by reading.
class Maker {
 public:
  Maker(RunData& out, double reading_s) : out_(out), reading_s_(reading_s) {
    out_.run = 1;
    out_.row.protocol_name = "world";
    out_.listing.exit_status = ExitStatus::success;
    out_.area_m2 = kArea_m2;
    out_.probe_diameter_m = kDiameter_mm * 1e-3;
    out_.function = "Cp-D";
    MeterSetting meter;
    meter.frequency_Hz = 100e3;
    out_.settings.push_back({-1e9, meter});
    out_.steps = {"s"};
  }
  void reading(double from_N, double to_N, std::int32_t level = 0, std::int32_t index = 0) {
    RunReading r;
    r.t_s = t_s + reading_s_ / 2;
    r.force_N = static_cast<float>((from_N + to_N) / 2);
    r.travel_m = static_cast<float>(3e-3 + 1e-5 * r.force_N);
    r.alignment_s = static_cast<float>(reading_s_ / std::sqrt(12.0));
    r.force_rate_N_s = static_cast<float>((to_N - from_N) / reading_s_);
    r.level = level;
    r.index = index;
    r.repeat = repeat;
    r.present = 3;
    out_.readings.push_back(r);
    ++out_.fresh_readings;
    for (const double part : {0.0, 0.5}) {
      FramePoint p;
      p.t_s = t_s + part * reading_s_;
      p.force_N = static_cast<float>(from_N + part * (to_N - from_N));
      p.travel_m = static_cast<float>(3e-3 + 1e-5 * p.force_N);
      out_.frame.push_back(p);
      ++out_.frame_samples;
    }
    t_s += reading_s_;
    out_.duration_s = t_s;
  }
  void stay(double force_N, double seconds) {
    for (double until = t_s + seconds; t_s + reading_s_ / 2 < until;) reading(force_N, force_N);
  }
  void ramp(double from_N, double to_N, double seconds) {
    const int n = std::max(1, static_cast<int>(std::lround(seconds / reading_s_)));
    for (int i = 0; i < n; ++i) {
      reading(from_N + (to_N - from_N) * i / n, from_N + (to_N - from_N) * (i + 1) / n);
    }
  }
  void contact() {
    out_.contact_s = t_s - 1;
    out_.rest_force_N = 0;
  }
  double t_s = 0;
  std::int32_t repeat = 0;

 private:
  RunData& out_;
  double reading_s_;
};

// A sum of first-order processes, one per octave, which gives 1/f noise between the slowest and the
// fastest.
class Flicker {
 public:
  Flicker(double sigma, std::mt19937_64& random) : sigma_(sigma), random_(random) {
    for (double tau = 0.2; tau < 1600; tau *= 2) taus_.push_back(tau);
    for (std::size_t i = 0; i < taus_.size(); ++i) state_.push_back(sigma_ * normal_(random_));
  }
  double step(double dt_s) {
    double sum = 0;
    for (std::size_t i = 0; i < taus_.size(); ++i) {
      const double keep = std::exp(-dt_s / taus_[i]);
      state_[i] = keep * state_[i] + sigma_ * std::sqrt(1 - keep * keep) * normal_(random_);
      sum += state_[i];
    }
    return sum;
  }

 private:
  double sigma_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  std::vector<double> taus_, state_;
};

// Disturbances that depend on time and not on the load.
class Background {
 public:
  Background(const World& w, std::mt19937_64& random)
      : w_(w), random_(random), flicker_(w.flicker_fF, random) {}
  double step(double t_s, double kPa) {
    const double dt = first_ ? 0 : t_s - t_s_;
    t_s_ = t_s;
    walk_ += w_.walk_fF_sqrt_s * std::sqrt(dt) * normal_(random_);
    const double fresh = normal_(random_);
    noise_ = first_ ? fresh : w_.ar1 * noise_ + std::sqrt(1 - w_.ar1 * w_.ar1) * fresh;
    first_ = false;
    double out = walk_ + w_.drift_fF_h * t_s / 3600;
    out += w_.noise_fF * (1 + w_.noise_per_kPa * kPa) * noise_;
    if (w_.flicker_fF > 0) out += flicker_.step(dt);
    if (w_.hum_fF > 0) {
      out += w_.hum_fF * std::sin(2 * std::numbers::pi * (t_s / period_s_ + phase_));
    }
    if (uniform_(random_) < w_.outlier_share) {
      out += w_.outlier_fF * (normal_(random_) > 0 ? 1 : -1);
    }
    return out;
  }

 private:
  const World& w_;
  std::mt19937_64& random_;
  Flicker flicker_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  double period_s_ = 5 + 5 * uniform_(random_), phase_ = uniform_(random_);
  bool first_ = true;
  double t_s_ = 0, walk_ = 0, noise_ = 0;
};

double creep_factor(const World& w, double under_load_s) {
  return 1 + w.creep_per_decade * std::log10(std::max(under_load_s, 0.1));
}

// For each reading, the time since its level was reached. A ramp resets it.
std::vector<double> under_load(const RunData& data) {
  std::vector<double> out;
  double since = 0;
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    const RunReading& r = data.readings[i];
    const double rate = std::abs(static_cast<double>(r.force_rate_N_s));
    if (rate > 0.01 || i == 0) since = r.t_s;
    out.push_back(r.t_s - since);
  }
  return out;
}

double level_kPa(const RunData& data, std::int32_t level) {
  return *data.levels[static_cast<std::size_t>(level - 1)].target_pressure_Pa * 1e-3;
}

// The mean creep factor over the readings of a level, as the estimand defines it.
double mean_creep(const MadeRun& run, const World& w, std::int32_t level) {
  const auto time = under_load(run.data);
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < run.data.readings.size(); ++i) {
    const RunReading& r = run.data.readings[i];
    if (r.level != level || r.index < 1) continue;
    sum += creep_factor(w, time[i]);
    n += 1;
  }
  return n > 0 ? sum / n : 1;
}

// The least-squares slopes of the true curves over the levels of a range: that of the rig and the
// specimen's own.
std::optional<Judged> judge_slope(const MadeRun& run, const TrueSpecimen& specimen, const World& w,
                                  const RangeResult& r) {
  if (!r.sensitivity || !r.sensitivity.estimate->interval) return std::nullopt;
  std::vector<LinePoint> rig, own;
  for (const LevelRow& l : run.data.levels) {
    const double kPa = level_kPa(run.data, l.level);
    if (kPa < r.range.from_kPa - 1e-6 || kPa > r.range.to_kPa + 1e-6) continue;
    const double creep = w.creep_per_decade > 0 ? mean_creep(run, w, l.level) : 1;
    const double delta = specimen.delta_fF(kPa) * creep;
    // The specimen's own slope is that of the mean of loading and unloading.
    const double u = kPa / 100;
    const double half_gap = 2 * w.hysteresis * specimen.delta_fF(100) * u * (1 - u);
    const double shared =
        run.truth.shared_fF.empty() ? 0 : run.truth.shared_fF[static_cast<std::size_t>(l.index)];
    rig.push_back({kPa * (1 + run.truth.force), (1 + run.truth.gain) * (delta + shared), 1});
    // The true pressure is the true force over the true area.
    const double area = std::pow(1 + run.truth.diameter_mm / kDiameter_mm, 2);
    own.push_back({kPa / area, delta + half_gap, 1});
  }
  Judged out;
  out.result = "slope " + std::string(r.range.from_kPa < 1 ? "low" : "high");
  out.estimate = *r.sensitivity.estimate;
  if (!r.uncertainty.parts.empty()) out.expanded = r.uncertainty.expanded;
  out.of_rig = fit_line(rig)->slope;
  out.own = fit_line(own)->slope;
  return out;
}

std::optional<double> expanded_of(const RunAnalysis& a, const std::string& quantity) {
  for (const Uncertainty& b : a.uncertainties) {
    if (b.quantity == quantity) return b.expanded;
  }
  return std::nullopt;
}

void add(std::vector<Judged>& out, const std::string& name, const Metric& m,
         std::optional<double> expanded, double of_rig, double own) {
  if (!m || !m.estimate->interval) return;
  out.push_back({name, *m.estimate, expanded, of_rig, own});
}

}  // namespace

TrueSpecimen straight_and_bent() {
  TrueSpecimen s;
  s.delta_fF = [](double kPa) { return 5 * kPa + 160 * (1 - std::exp(-kPa / 40)); };
  return s;
}

RunData static_run(const StaticShape& shape) {
  RunData out;
  Maker make(out, shape.reading_s);
  make.stay(0, shape.baseline * shape.reading_s);
  make.stay(0, 1.2);
  make.contact();
  std::int32_t level = 0;
  for (int repeat = 1; repeat <= shape.repeats; ++repeat) {
    make.repeat = repeat;
    double at_N = 0;
    for (int i = 1; i <= shape.levels; ++i) {
      const double kPa = shape.levels > 1 ? 10 + 90.0 * (i - 1) / (shape.levels - 1) : 10;
      make.ramp(at_N, newton_of(kPa), 1.2);
      at_N = newton_of(kPa);
      make.stay(at_N, shape.settle_s);
      LevelRow row;
      row.level = ++level;
      row.repeat = repeat;
      row.index = i;
      row.target_force_N = at_N;
      row.target_pressure_Pa = kPa * 1e3;
      row.planned_readings = shape.readings;
      row.begin_s = make.t_s;
      out.levels.push_back(row);
      for (int k = 1; k <= shape.readings; ++k) make.reading(at_N, at_N, level, k);
    }
    make.ramp(at_N, 0, 3);
    make.stay(0, shape.rest_s);
  }
  return out;
}

RunData dynamic_run(const DynamicShape& shape) {
  RunData out;
  Maker make(out, shape.reading_s);
  make.stay(0, shape.baseline_s);
  make.contact();
  for (int k = 1; k <= shape.cycles; ++k) {
    make.repeat = k;
    make.ramp(0, shape.peak_N, shape.branch_s);
    make.ramp(shape.peak_N, 0, shape.branch_s);
    make.stay(0, shape.rest_s);
  }
  return out;
}

MadeRun rewrite(const RunData& shape, const TrueSpecimen& specimen, const World& w,
                std::uint64_t seed) {
  MadeRun out{shape, {}};
  std::mt19937_64 random(seed * 7919 + 17);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> within(-1, 1);
  Truth& t = out.truth;
  t.gain = w.gain_limit * within(random);
  t.force = w.force_limit * within(random);
  t.diameter_mm = w.diameter_limit_mm * within(random);
  t.offset_fF = w.offset_limit_fF * within(random);
  const double zero_N = w.force_zero_limit_N * within(random);
  for (int i = 0; w.shared_sd_fF > 0 && i < 1000; ++i) {
    t.shared_fF.push_back(w.shared_sd_fF * normal(random));
  }
  std::map<std::int32_t, std::pair<double, double>> repeats;  // factor of the slope, offset
  for (const RunReading& r : shape.readings) {
    if (repeats.contains(r.repeat)) continue;
    const double factor = 1 + w.slope_sd * normal(random);
    repeats[r.repeat] = {factor, w.offset_sd_fF * normal(random)};
  }
  const auto time = under_load(shape);
  const double rest_N = shape.rest_force_N.value_or(0);
  double top = 0;
  for (const FramePoint& p : shape.frame) top = std::max(top, static_cast<double>(p.force_N));
  const double span = specimen.delta_fF((top - rest_N) / kArea_m2 * 1e-3);
  Background background(w, random);
  for (std::size_t i = 0; i < out.data.readings.size(); ++i) {
    RunReading& r = out.data.readings[i];
    const auto [factor, offset] = repeats[r.repeat];
    // The force loop holds the force that the cell shows.
    const double kPa = r.level > 0 ? level_kPa(shape, r.level)
                                   : std::max(0.0, (r.force_N - rest_N) / kArea_m2 * 1e-3);
    double delta = specimen.delta_fF(kPa) * factor;
    if (w.creep_per_decade > 0) delta *= creep_factor(w, time[i]);
    if (w.hysteresis > 0 && r.force_rate_N_s < 0) {
      const double u = kPa / ((top - rest_N) / kArea_m2 * 1e-3);
      delta += 4 * w.hysteresis * span * u * (1 - u);
    }
    const bool loaded = kPa > 1;
    if (loaded) delta += offset;
    if (!t.shared_fF.empty() && r.level > 0) {
      const auto index = out.data.levels[static_cast<std::size_t>(r.level - 1)].index;
      delta += t.shared_fF[static_cast<std::size_t>(index)];
    }
    const double fF = (1 + t.gain) * (specimen.c0_fF + delta) + t.offset_fF;
    r.capacitance_F = (fF + background.step(r.t_s, kPa)) * 1e-15;
    r.force_N = static_cast<float>(rest_N + (r.force_N - rest_N) * (1 + t.force) + zero_N +
                                   w.force_noise_N * normal(random));
  }
  for (FramePoint& p : out.data.frame) {
    p.force_N = static_cast<float>(rest_N + (p.force_N - rest_N) * (1 + t.force) + zero_N +
                                   w.force_noise_N * normal(random));
  }
  if (out.data.rest_force_N) *out.data.rest_force_N += zero_N;
  return out;
}

std::vector<Judged> judge(const MadeRun& run, const TrueSpecimen& specimen, const World& world,
                          const AnalysisOptions& options) {
  const RunAnalysis a = analyse(run.data, options).value();
  std::vector<Judged> out;
  for (const RangeResult& r : a.ranges) {
    if (a.levels.empty()) break;
    if (auto slope = judge_slope(run, specimen, world, r)) out.push_back(std::move(*slope));
  }
  const Truth& t = run.truth;
  const double c0 = (1 + t.gain) * specimen.c0_fF + t.offset_fF;
  // C0 refers to the middle of the baseline.
  const double drifted = world.drift_fF_h * run.data.contact_s.value_or(0) / 2 / 3600;
  add(out, "C0", a.c0, expanded_of(a, "C0"), (c0 + drifted) * 1e-3,
      (specimen.c0_fF + drifted) * 1e-3);
  add(out, "drift", a.drift, std::nullopt, world.drift_fF_h, world.drift_fF_h);
  if (a.levels.empty() && !a.cycles.empty()) {
    double shown = 0, own = 0;
    for (const CycleResult& c : a.cycles) {
      const double meant_N = std::round(c.peak_force_N / (1 + t.force) * 20) / 20;
      shown += (1 + t.gain) * specimen.delta_fF(meant_N / kArea_m2 * 1e-3) / (c0 + drifted);
      own += specimen.delta_fF(meant_N / kArea_m2 * 1e-3 * (1 + t.force)) / specimen.c0_fF;
    }
    const double n = static_cast<double>(a.cycles.size());
    add(out, "dynamic range", a.dynamic_range, expanded_of(a, "dynamic range"), shown / n * 100,
        own / n * 100);
    if (world.hysteresis > 0) {
      add(out, "hysteresis", a.hysteresis.largest_gap, expanded_of(a, "hysteresis"),
          world.hysteresis * 100, world.hysteresis * 100);
    }
  }
  if (!a.levels.empty() && a.ranges[0].sensitivity) {
    const auto slope = judge_slope(run, specimen, world, a.ranges[0]);
    if (slope && world.noise_per_kPa <= 0 && world.ar1 <= 0 && world.flicker_fF <= 0 &&
        world.outlier_share <= 0 && world.hum_fF <= 0) {
      add(out, "limit of detection", a.limit_of_detection, std::nullopt,
          3 * world.noise_fF / slope->of_rig, 3 * world.noise_fF / slope->own);
    }
  }
  return out;
}

}  // namespace lcrig::worlds
