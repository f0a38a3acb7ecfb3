// SPDX-License-Identifier: Apache-2.0
// Which scatter a slope has: between repeats, or within the only one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

// Fewer degrees of freedom make an interval needlessly wide: the next source is asked.
constexpr double kEnough = 5;

// Of what each repeat deviates from the mean of each level, so that a repeat which lacks a level is
// compared at the pressures that it has. The slopes are those of the repeats less `slope`.
std::vector<LineFit> lines_of_repeats(const std::vector<RangePoint>& range, double slope) {
  const AdditiveFit additive = fit_additive(range, slope);
  std::map<std::int32_t, std::vector<LinePoint>> repeats;
  for (const RangePoint& p : range) {
    const auto level = additive.of_level.find(p.key);
    if (level == additive.of_level.end()) continue;
    const double y = additive.above_line(p) - level->second;
    repeats[p.repeat].push_back({p.at.x, y, p.at.weight});
  }
  std::vector<LineFit> lines;
  for (const auto& [repeat, points] : repeats) {
    if (const auto line = fit_line(points)) lines.push_back(*line);
  }
  return lines;
}

PureError error_of_slopes(const std::vector<LineFit>& lines) {
  double weight = 0, mean = 0, ss = 0;
  for (const LineFit& l : lines) weight += l.sxx, mean += l.sxx * l.slope;
  mean /= weight;
  for (const LineFit& l : lines) ss += l.sxx * (l.slope - mean) * (l.slope - mean);
  const auto freedom = static_cast<double>(lines.size()) - 1;
  return {ss / freedom, freedom, fmt::format("the slopes of {} repeats as a sample", lines.size())};
}

std::optional<PureError> pooled(const std::vector<RangePoint>& range,
                                const std::vector<RangePoint>& whole_run, double slope) {
  auto here = error_between_repeats(range, slope);
  if (!here || here->degrees_of_freedom >= kEnough) return here;
  auto run = error_between_repeats(whole_run, slope);
  if (!run || run->degrees_of_freedom < kEnough) return here;
  run->basis += " of the whole run";
  return run;
}

// Weight of one reading in the slope.
struct Term {
  double t_s = 0, factor = 0;
};

void add_readings(const Scene& scene, const std::vector<RangePoint>& range, const LineFit& line,
                  std::vector<Term>& terms) {
  std::vector<double> factor(scene.data.levels.size() + 1, 0.0);
  for (const RangePoint& p : range) {
    factor[static_cast<std::size_t>(p.level)] = (p.at.x - line.x_mean) / line.sxx;
  }
  for (const RunReading& r : scene.data.readings) {
    const auto level = static_cast<std::size_t>(r.level);
    if (r.index <= 0 || level >= factor.size() || factor[level] == 0 || !scene.uses(r)) continue;
    terms.push_back({r.t_s, factor[level]});
  }
}

// The rests move what is subtracted at each level.
void add_rests(const Scene& scene, const std::vector<RangePoint>& range, const LineFit& line,
               std::vector<Term>& terms) {
  const auto& nodes = scene.drift.nodes();
  if (!scene.drift.known()) return;
  std::vector<double> factor(nodes.size(), 0.0);
  for (const RangePoint& p : range) {
    const auto influence = scene.drift.influence(p.t_s);
    const double part = p.at.weight * (p.at.x - line.x_mean) / line.sxx;
    for (std::size_t k = 0; k < nodes.size(); ++k) factor[k] -= part * influence[k];
  }
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    for (std::size_t i = nodes[k].first; i < nodes[k].last; ++i) {
      if (!scene.uses(scene.data.readings[i])) continue;
      terms.push_back({scene.data.readings[i].t_s, factor[k] / nodes[k].readings});
    }
  }
}

// Variance of the sum of all terms under a first-order process of unit variance.
double unit_variance(std::vector<Term> terms, double rho, double spacing_s) {
  std::ranges::sort(terms, {}, &Term::t_s);
  double variance = 0, before = 0;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (i > 0) {
      const double gap = (terms[i].t_s - terms[i - 1].t_s) / spacing_s;
      before = rho > 0 ? std::pow(rho, gap) * (before + terms[i - 1].factor) : 0;
    }
    variance += terms[i].factor * (terms[i].factor + 2 * before);
  }
  return variance;
}

// Mean time from one reading of a level to the next.
double spacing_of(const Scene& scene) {
  double time = 0, count = 0;
  const auto& readings = scene.data.readings;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const RunReading &a = readings[i - 1], &b = readings[i];
    if (a.level != b.level || a.index <= 0 || b.index <= 0) continue;
    time += b.t_s - a.t_s;
    count += 1;
  }
  return count > 0 ? time / count : 1;
}

struct Squares {
  double sum = 0, freedom = 0;
  double mean() const { return sum / freedom; }
};

// Mean squares of the readings of a range about their levels' trends, and of what the force's
// scatter adds to them beside the line: negative where the capacitance follows the force.
struct LevelSquares {
  Squares capacitance, force;
};
LevelSquares squares_of(const std::vector<RangePoint>& points, double slope) {
  LevelSquares out;
  for (const RangePoint& p : points) {
    out.capacitance.sum += p.reading_ss - p.trend_ss;
    out.capacitance.freedom += static_cast<double>(p.readings - 2);
    out.force.sum += reading_ss(p, slope) - p.reading_ss;
    out.force.freedom += static_cast<double>(p.readings - 1);
  }
  return out;
}

// Of the force within the levels of the run.
Correlation correlation_of_force(const Scene& scene) {
  std::vector<EvenStretch> levels(scene.data.levels.size());
  for (EvenStretch& level : levels) level.trend = true;
  for (const RunReading& r : scene.data.readings) {
    const auto k = static_cast<std::size_t>(r.level) - 1;
    if (r.index > 0 && r.level > 0 && k < levels.size() && r.has_force() && scene.uses(r)) {
      levels[k].add(r.force_N);
    }
  }
  return fit_correlation(levels);
}

// The correlation comes from all levels, the noise from this range. Readings deviate from the line,
// so the scatter of the force counts, too, with its own correlation: that of a load cell is white
// where that of the capacitance is not.
std::optional<PureError> error_of_readings(const Scene& scene, const std::vector<RangePoint>& range,
                                           const std::vector<RangePoint>& whole_run,
                                           const LineFit& line) {
  const Correlation& c = scene.correlation;
  LevelSquares here = squares_of(range, line.slope);
  const LevelSquares all = squares_of(whole_run, line.slope);
  const double freedom = here.capacitance.freedom;
  if (freedom < 2 || c.freedom <= 0) return std::nullopt;
  const double spacing_s = spacing_of(scene);
  std::vector<Term> terms;
  add_readings(scene, range, line, terms);
  double of_force = 0;
  if (here.force.sum > 0) {
    of_force = here.force.mean() * unit_variance(terms, correlation_of_force(scene).rho, spacing_s);
  } else {
    here.capacitance.sum = std::max(0.0, here.capacitance.sum + here.force.sum);
  }
  add_rests(scene, range, line, terms);
  const double ratio =
      all.capacitance.sum > 0 ? here.capacitance.mean() / all.capacitance.mean() : 1;
  const double of_capacitance =
      c.variance * ratio * unit_variance(std::move(terms), c.rho, spacing_s);
  const double variance = of_capacitance + of_force;
  const double own = c.degrees_of_freedom(freedom);
  const double denominator =
      of_capacitance * of_capacitance / own + of_force * of_force / here.force.freedom;
  return PureError{
      variance * line.sxx, denominator > 0 ? variance * variance / denominator : own,
      fmt::format("readings of one repeat, whose neighbours correlate by {:.2f}", c.rho)};
}

}  // namespace

std::optional<SlopeScatter> scatter_of_slope(const Scene& scene,
                                             const std::vector<RangePoint>& range,
                                             const std::vector<RangePoint>& whole_run,
                                             const LineFit& line) {
  SlopeScatter out;
  const auto lines = lines_of_repeats(range, line.slope);
  for (const LineFit& l : lines) out.slopes.push_back(line.slope + l.slope);
  if (lines.empty()) out.slopes.push_back(line.slope);
  if (lines.size() >= 2) {
    out.of_slopes = out.error = error_of_slopes(lines);
    out.of_levels = pooled(range, whole_run, line.slope);
    return out;
  }
  out.one_repeat = true;
  if (auto within = error_of_readings(scene, range, whole_run, line)) {
    out.error = *within;
    out.of_levels = error_within_levels(range, line.slope);
    return out;
  }
  if (line.points <= 2) return std::nullopt;
  const double freedom = line.points - 2;
  out.error = {line.residual_ss / freedom, freedom,
               "scatter about the line, the curve's own shape included"};
  return out;
}

}  // namespace lcrig
