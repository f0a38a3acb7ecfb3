// SPDX-License-Identifier: Apache-2.0
// Which slope it is where the specimen creeps or has a hysteresis, and how far the slope of the
// other choice lies from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

constexpr double kReached = 0.02;  // of the load: this near, it is reached
constexpr double kShows = 2.6;  // standard errors: one creep in a hundred by chance

bool in_range(const LevelResult& l, const PressureRange& range, Direction direction) {
  return l.direction == direction && is_inside(range, l.target_kPa.value_or(l.pressure_kPa));
}

// Since when the load of the reading is there.
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
  RunningMean from_s, to_s;  // after the load was reached
};

Window window_of(const Scene& scene, const LevelResults& levels, const PressureRange& range) {
  std::vector<bool> wanted(scene.data.levels.size() + 1, false);
  for (const LevelResult& l : levels.levels) {
    if (in_range(l, range, levels.line_direction)) wanted[static_cast<std::size_t>(l.level)] = true;
  }
  Window w;
  std::int32_t level = 0;
  double reached = 0, last = 0;
  const auto close = [&] {
    if (level > 0) w.to_s.add(last - reached);
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
      w.from_s.add(r.t_s - reached);
    }
    last = r.t_s;
  }
  close();
  return w;
}

// Runs that are compared make the same choice.
UncertaintyPart other_choice(std::string name, double difference, std::string basis) {
  return shared(part(std::move(name), rectangular(difference), std::move(basis)));
}

// Slope against pressure of unloading less loading, from the levels of the other direction.
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

// The same from the branches of the loadings.
std::optional<double> gap_of_loop(const SlopeBasis& basis, const RangeResult& r) {
  if (!basis.hysteresis.in_readings) return std::nullopt;
  std::vector<LinePoint> points;
  for (const LoopPoint& p : basis.hysteresis.loop) {
    const double kPa = basis.scene.kPa(p.force_N).value_or(-1);
    if (is_inside(r.range, kPa)) points.push_back({kPa, p.down_fF - p.up_fF, 1});
  }
  const auto line = fit_line(points);
  return line ? std::optional(line->slope) : std::nullopt;
}

void add_branch(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b) {
  auto gap = gap_of_levels(basis.levels, r);
  const char* from = "levels";
  if (!gap) gap = gap_of_loop(basis, r), from = "ramps";
  if (!gap) {
    b.parts.push_back(other_choice("other branch", 0,
                                   "the unloading was not measured, or does not stand out: a "
                                   "hysteresis is not in the uncertainty"));
    return;
  }
  b.parts.push_back(other_choice(
      "other branch", *gap,
      fmt::format("the slope of the other branch differs by {:.3g} ({}): limits", *gap, from)));
}

void add_time(const Metric& creep, const RangeResult& r, Uncertainty& b) {
  if (!creep.estimate || !creep.estimate->standard_error) {
    b.parts.push_back(other_choice("another time", 0, "creep is not known: no steady load"));
    return;
  }
  const double rate = creep.value() / 100, error = *creep.estimate->standard_error / 100;
  const bool shows = std::abs(rate) > kShows * error;
  b.parts.push_back(other_choice(
      "another time", (shows ? rate : 0) * r.sensitivity.value(),
      fmt::format("creep of {:.2g} % per decade of time{}", rate * 100,
                  shows ? ": limits of a decade sooner or later" : " does not stand out")));
}

}  // namespace

std::string name_estimand(const Scene& scene, const LevelResults& levels,
                          const PressureRange& range) {
  const bool up = levels.line_direction == Direction::up;
  std::string name = up ? "loading branch" : "unloading branch";
  if (levels.levels.empty()) return name + ", while the load grows";
  const Window w = window_of(scene, levels, range);
  if (w.from_s.count == 0 || w.to_s.count == 0) return name;
  return fmt::format("{}, from {:.1f} to {:.1f} s after the load was reached", name, w.from_s.mean,
                     w.to_s.mean);
}

void add_other_choices(const SlopeBasis& basis, const RangeResult& r, Uncertainty& b) {
  add_branch(basis, r, b);
  add_time(basis.holds.creep, r, b);
}

}  // namespace lcrig
