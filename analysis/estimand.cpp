// SPDX-License-Identifier: Apache-2.0
// Says to which branch and to which time under load a result refers, where the specimen creeps or
// has a hysteresis. Also estimates how far the result of the other choice would lie from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

constexpr double kReached = 0.02;  // relative distance within which a load counts as reached
constexpr double kShows = 2.6;  // standard errors: chance exceeds it for one creep in a hundred

bool in_range(const LevelResult& l, const PressureRange& range, Direction direction) {
  return l.direction == direction && is_inside(range, l.target_kPa.value_or(l.pressure_kPa));
}

// Time at which the load of the reading was reached.
double reached_s(const Scene& scene, std::size_t reading) {
  const auto& all = scene.data.readings;
  const double load = scene.above_rest_N(all[reading]);
  const double band = std::max(kReached * std::abs(load), 6 * scene.force_noise_N);
  std::size_t i = reading;
  while (i > 0 && all[i - 1].has_force() &&
         std::abs(scene.above_rest_N(all[i - 1]) - load) <= band) {
    --i;
  }
  return all[i].t_s;
}

struct Window {
  RunningMean from_s, to_s;  // times since the load was reached
  RunningMean log10_s;  // of the times from one to the other

  void add(double from, double to) {
    from_s.add(from);
    to_s.add(to);
    if (!(to > 0)) return;
    // Mean of ln t between the two: (b ln b - a ln a)/(b - a) - 1.
    const double a_ln_a = from > 0 ? from * std::log(from) : 0;
    const double ln = to > from ? (to * std::log(to) - a_ln_a) / (to - from) - 1 : std::log(to);
    log10_s.add(ln / std::numbers::ln10);
  }
  std::optional<double> mean_log10_s() const {
    return log10_s.count > 0 ? std::optional(log10_s.mean) : std::nullopt;
  }
};

template <class Wanted>
Window window_of(const Scene& scene, const LevelResults& levels, Wanted is_wanted) {
  std::vector<bool> wanted(scene.data.levels.size() + 1, false);
  for (const LevelResult& l : levels.levels) {
    if (is_wanted(l)) wanted[static_cast<std::size_t>(l.level)] = true;
  }
  Window w;
  std::int32_t level = 0;
  double reached = 0, first = 0, last = 0;
  const auto close = [&] {
    if (level > 0) w.add(first - reached, last - reached);
  };
  const auto& readings = scene.data.readings;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const RunReading& r = readings[i];
    if (r.index <= 0 || r.level <= 0 || static_cast<std::size_t>(r.level) >= wanted.size()) {
      continue;
    }
    if (!wanted[static_cast<std::size_t>(r.level)] || !r.has_force()) continue;
    if (r.level != level) {
      close();
      level = r.level;
      reached = reached_s(scene, i);
      first = r.t_s;
    }
    last = r.t_s;
  }
  close();
  return w;
}

std::string with_window(std::string name, const Window& w) {
  if (w.from_s.count == 0 || w.to_s.count == 0) return name;
  return fmt::format("{}, from {:.1f} to {:.1f} s after the load was reached", name, w.from_s.mean,
                     w.to_s.mean);
}

const char* name_of(Direction direction) {
  return direction == Direction::up ? "loading branch" : "unloading branch";
}

// Mean times under load at which the readings of the plateaus begin and end.
Window window_of_plateaus(const Scene& scene, const std::vector<CycleResult>& cycles) {
  Window w;
  for (const CycleResult& c : cycles) {
    const double reached = reached_s(scene, c.plateau_first);
    w.add(scene.data.readings[c.plateau_first].t_s - reached,
          scene.data.readings[c.plateau_last].t_s - reached);
  }
  return w;
}

// At a peak where the load turns. The time is that of the loading.
LoadState load_at_peak(const Scene& scene, const std::vector<CycleResult>& cycles, double peak_N) {
  LoadState load;
  load.kind = LoadKind::turning;
  load.peak_N = peak_N;
  load.peak_kPa = scene.kPa(peak_N);
  RunningMean delta_fF, log10_s;
  for (const CycleResult& c : cycles) {
    delta_fF.add(c.delta_C_fF);
    if (c.peak_s > c.begin_s) log10_s.add(std::log10(c.peak_s - c.begin_s));
  }
  if (delta_fF.mean != 0) {
    load.per_peak = slope_at_peak_fF_per_N(scene, cycles) * peak_N / delta_fF.mean;
  }
  if (log10_s.count > 0) load.log10_s = log10_s.mean;
  return load;
}

UncertaintyPart other_branch(double difference, std::string basis) {
  return of(ErrorSource::branch, part("other branch", rectangular(difference), std::move(basis)));
}

UncertaintyPart another_time(double difference, std::string basis) {
  return of(ErrorSource::time, part("another time", rectangular(difference), std::move(basis)));
}

// Slope against pressure of unloading less that of loading, from the levels of the other direction.
std::optional<double> gap_of_levels(const LevelResults& levels, const RangeResult& r) {
  const Direction other = levels.line_direction == Direction::up ? Direction::down : Direction::up;
  std::vector<LinePoint> points;
  for (const LevelResult& l : levels.levels) {
    if (in_range(l, r.range, other)) points.push_back(point_of(l).at);
  }
  const auto line = fit_line(points);
  if (!line || points.size() < 2) return std::nullopt;
  return line->slope - r.sensitivity.value();
}

// The same difference from the branches of the loadings, against `x_of` a force.
template <class XOf>
std::optional<double> gap_of_loop(const SlopeBasis& basis, XOf x_of) {
  if (!basis.hysteresis.in_readings) return std::nullopt;
  std::vector<LinePoint> points;
  for (const LoopPoint& p : basis.hysteresis.loop) {
    if (const std::optional<double> x = x_of(p.force_N)) {
      points.push_back({*x, p.down_fF - p.up_fF, 1});
    }
  }
  const auto line = fit_line(points);
  return line ? std::optional(line->slope) : std::nullopt;
}

constexpr const char* kMeet = "both branches meet at the largest load";
constexpr const char* kNoUnloading =
    "the unloading was not measured, or does not stand out: a hysteresis is not in the uncertainty";

void add_branch(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b) {
  auto gap = gap_of_levels(basis.levels, r);
  const char* from = "levels";
  if (!gap) {
    from = "ramps";
    gap = gap_of_loop(basis, [&](double force_N) {
      const auto kPa = basis.scene.kPa(force_N);
      return kPa && is_inside(r.range, *kPa) ? kPa : std::nullopt;
    });
  }
  if (!gap) {
    b.parts.push_back(other_branch(0, kNoUnloading));
    return;
  }
  b.parts.push_back(other_branch(
      *gap,
      fmt::format("the slope of the other branch differs by {:.3g} ({}): limits", *gap, from)));
}

void add_time(const Metric& creep, Uncertainty& b) {
  if (!creep.estimate || !creep.estimate->standard_error) {
    b.parts.push_back(another_time(0, "creep is not known: no steady load"));
    return;
  }
  const double rate = creep.value() / 100, error = *creep.estimate->standard_error / 100;
  const bool shows = std::abs(rate) > kShows * error;
  b.parts.push_back(another_time(
      (shows ? rate : 0) * b.value,
      fmt::format("creep of {:.2g} % per decade of time{}", rate * 100,
                  shows ? ": limits of a decade sooner or later" : " does not stand out")));
}

}  // namespace

void name_estimand(const Scene& scene, const LevelResults& levels, const PressureRange& range,
                   Metric& slope) {
  const Direction direction = levels.line_direction;
  const std::string branch = name_of(direction);
  LoadState& load = slope.load.emplace();
  load.direction = direction;
  if (levels.levels.empty()) {
    load.kind = LoadKind::rising;
    slope.estimand = branch + ", while the load grows";
    return;
  }
  const Window w =
      window_of(scene, levels, [&](const LevelResult& l) { return in_range(l, range, direction); });
  load.log10_s = w.mean_log10_s();
  slope.estimand = with_window(branch, w);
}

std::string name_estimand(const Scene& scene, const LevelResults& levels, const CurvePoint& level) {
  const auto is_it = [&](const LevelResult& l) {
    return l.direction == level.direction && is_near(l.pressure_kPa, level.pressure_kPa);
  };
  return with_window(fmt::format("at {:.4g} kPa, {}", level.pressure_kPa, name_of(level.direction)),
                     window_of(scene, levels, is_it)) +
         ", less C0";
}

// Names what results against force refer to: slopes to ramps, peaks to holds or turns.
void name_estimands(const Scene& scene, CycleResults& out) {
  RunningMean peak_N;
  for (const CycleResult& c : out.cycles) peak_N.add(c.peak_force_N);
  if (out.force_sensitivity) {
    out.force_sensitivity.estimand = fmt::format(
        "loading branch, while the load grows, from {:.3g} N ({:g} % of the largest force) up to "
        "the peak of {:.3g} N",
        kCycleEdge * peak_N.mean, kCycleEdge * 100, peak_N.mean);
  }
  if (!out.dynamic_range) return;
  const PeakMethod method = out.cycles.front().peak_method;
  const bool alike = std::ranges::all_of(
      out.cycles, [&](const CycleResult& c) { return c.peak_method == method; });
  std::string name = fmt::format("at the peak of {:.3g} N", peak_N.mean);
  LoadState& load = out.dynamic_range.load.emplace(load_at_peak(scene, out.cycles, peak_N.mean));
  if (!alike) {
    name += ", which some cycles hold and others pass";
    load.kind = LoadKind::mixed;
  } else if (method == PeakMethod::plateau) {
    const Window w = window_of_plateaus(scene, out.cycles);
    name = with_window(std::move(name), w);
    load.kind = LoadKind::held;
    load.log10_s = w.mean_log10_s();
  } else {
    name += ", where the load turns";
  }
  out.dynamic_range.estimand = name + ", less the rest before the cycle";
}

void add_other_choices(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b) {
  add_branch(basis, r, b);
  add_time(basis.holds.creep, b);
}

void add_other_choices_of_force_sensitivity(const SlopeBasis& basis, Uncertainty& b) {
  const auto gap = gap_of_loop(basis, [](double force_N) { return std::optional(force_N); });
  b.parts.push_back(
      gap ? other_branch(*gap,
                         fmt::format("the slope of the other branch differs by {:.3g} (ramps): "
                                     "limits",
                                     *gap))
          : other_branch(0, kNoUnloading));
  add_time(basis.holds.creep, b);
}

void add_other_choices_of_dynamic_range(const SlopeBasis& basis, Uncertainty& b) {
  b.parts.push_back(other_branch(0, kMeet));
  add_time(basis.holds.creep, b);
}

void add_other_choices_of_highest_level(const SlopeBasis& basis, Uncertainty& b) {
  UncertaintyPart branch = other_branch(0, kMeet);
  const double top_kPa = basis.highest.top_kPa;
  for (const CurvePoint& c : basis.curve.curve) {
    if (c.direction == basis.levels.line_direction || !c.delta_C_fF) continue;
    if (!is_near(c.pressure_kPa, top_kPa)) continue;
    const double gap = *c.delta_C_fF - b.value;
    branch = other_branch(
        gap, fmt::format("the level of the other branch differs by {:.3g}: limits", gap));
  }
  b.parts.push_back(std::move(branch));
  add_time(basis.holds.creep, b);
}

}  // namespace lcrig
