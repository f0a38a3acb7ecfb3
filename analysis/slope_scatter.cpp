// SPDX-License-Identifier: Apache-2.0
// Determines the scatter of a slope: between repeats, or within the only repeat.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/replicates.hpp"

namespace lcrig {

namespace {

// Fewer degrees of freedom make an interval needlessly wide: the next source of scatter is tried.
constexpr double kEnough = 5;

// One line for each repeat, through its deviations from the mean of each level, so that a repeat
// without some level is compared at the pressures it has. The slopes are relative to `slope`.
std::vector<LineFit> lines_of_repeats(const std::vector<RangePoint>& range, double slope) {
  const AdditiveFit additive = fit_additive(range, slope);
  std::map<std::int32_t, std::vector<LinePoint>> repeats;
  for (const RangePoint& p : range) {
    const auto level = additive.of_level.find(p.key);
    if (level == additive.of_level.end()) continue;
    const double y = additive.above_line(p) - level->second;
    repeats[p.repeat].push_back({p.at.x, y, p.line_weight});
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

// How much each repeat contributes to the slope. Where a repeat lacks a level, the shares of the
// repeats are unequal. The slope is a sum of c y over the points. `c` is the line's weight on the
// effects of the levels, corrected for the offsets of the repeats. With w the weights of the
// additive fit, c/w is again the sum of an effect of the level and one of the repeat.
struct Shares {
  Eigen::MatrixXd of_slopes;  // (r, k): what repeat r adds when the slope of repeat k grows by 1
  Eigen::VectorXd added;  // contribution of the readings of each repeat, fF/kPa
  double square_sum = 0;  // sum of the squared shares of the repeats in the slope
};

std::optional<Shares> shares_in(const std::vector<RangePoint>& range, const LineFit& line) {
  std::map<LevelKey, Eigen::Index> levels;
  std::map<std::int32_t, Eigen::Index> repeats;
  for (const RangePoint& p : range) {
    levels.try_emplace(p.key, std::ssize(levels));
    repeats.try_emplace(p.repeat, std::ssize(repeats));
  }
  const Eigen::Index of_levels = std::ssize(levels), of_repeats = std::ssize(repeats);
  const Eigen::Index all = of_levels + of_repeats, what_is_there = of_repeats + 1;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(all, all);
  // Right sides for c, for a slope of 1 in each repeat, and for the deviations from the line.
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(all, of_repeats + 2);
  const auto beside = [&](const RangePoint& p) { return p.at.y - line.at(p.at.x); };
  for (const RangePoint& p : range) {
    const Eigen::Index l = levels.at(p.key), k = repeats.at(p.repeat), r = of_levels + k;
    const double w = p.at.weight, x = p.at.x - line.x_mean;
    normal(l, l) += w, normal(r, r) += w, normal(l, r) += w, normal(r, l) += w;
    right(l, 0) += p.line_weight * x / line.sxx;
    right(l, k + 1) += w * x, right(r, k + 1) += w * x;
    right(l, what_is_there) += w * beside(p), right(r, what_is_there) += w * beside(p);
  }
  const Eigen::MatrixXd effects = normal.completeOrthogonalDecomposition().solve(right);
  // Repeats that share no level with the others: their offsets cannot be told from the slope.
  if ((normal * effects - right).norm() > 1e-9 * right.norm()) return std::nullopt;
  Shares out{Eigen::MatrixXd::Zero(of_repeats, of_repeats), Eigen::VectorXd::Zero(of_repeats)};
  Eigen::VectorXd share = Eigen::VectorXd::Zero(of_repeats);
  for (const RangePoint& p : range) {
    const Eigen::Index l = levels.at(p.key), k = repeats.at(p.repeat);
    const double c = p.at.weight * (effects(l, 0) + effects(of_levels + k, 0));
    share(k) += c * (p.at.x - line.x_mean);
    out.added(k) += c * (beside(p) - effects(l, what_is_there));
    for (Eigen::Index j = 0; j < of_repeats; ++j) out.of_slopes(k, j) -= c * effects(l, j + 1);
  }
  out.of_slopes.diagonal() += share;
  out.square_sum = share.squaredNorm();
  return out;
}

// The slopes of the repeats as a sample when their shares are unequal. The contributions of the
// repeats are squared and summed. A factor makes the sum unbiased for slopes that differ. The
// degrees of freedom are Satterthwaite's for this sum. A repeat with two of six levels hardly
// counts in either (Bell and McCaffrey, Survey Methodology 28 (2002) 169). With equal shares the
// result is the ordinary sample variance.
std::optional<PureError> error_of_unequal_repeats(const std::vector<RangePoint>& range,
                                                  const LineFit& line) {
  constexpr double kNothing = 1e-6;  // of the shares
  const auto shares = shares_in(range, line);
  if (!shares) return std::nullopt;
  const double seen = shares->of_slopes.squaredNorm();
  if (!(seen > kNothing * shares->square_sum)) return std::nullopt;
  const Eigen::MatrixXd covariance = shares->of_slopes * shares->of_slopes.transpose();
  return PureError{shares->added.squaredNorm() * shares->square_sum / seen * line.sxx,
                   seen * seen / covariance.squaredNorm(),
                   fmt::format("the slopes of {} repeats as a sample, by their unequal shares",
                               shares->added.size())};
}

// True if every repeat has every level with the same number of readings: equal shares.
bool is_balanced(const std::vector<RangePoint>& range, std::size_t repeats) {
  std::map<LevelKey, std::vector<double>> weights;
  for (const RangePoint& p : range) weights[p.key].push_back(p.at.weight);
  return std::ranges::all_of(weights, [&](const auto& level) {
    const auto& [key, w] = level;
    return w.size() == repeats && std::ranges::count(w, w.front()) == std::ssize(w);
  });
}

std::optional<PureError> error_of_repeats(const std::vector<RangePoint>& range,
                                          const std::vector<LineFit>& lines, const LineFit& line) {
  if (lines.size() < 2) return std::nullopt;
  if (is_balanced(range, lines.size())) return error_of_slopes(lines);
  return error_of_unequal_repeats(range, line);
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

// One reading and its weight in the slope.
struct Term {
  double t_s = 0, factor = 0;
};

void add_readings(const Scene& scene, const std::vector<RangePoint>& range, const LineFit& line,
                  std::vector<Term>& terms) {
  std::vector<double> factor(scene.data.levels.size() + 1, 0.0);
  for (const RangePoint& p : range) {
    factor[static_cast<std::size_t>(p.level)] =
        p.line_weight / p.at.weight * (p.at.x - line.x_mean) / line.sxx;
  }
  for (const RunReading& r : scene.data.readings) {
    const auto level = static_cast<std::size_t>(r.level);
    if (r.index <= 0 || level >= factor.size() || factor[level] == 0 || !scene.uses(r)) continue;
    terms.push_back({r.t_s, factor[level]});
  }
}

// Adds the weights of the rests, because their drift is subtracted at each level.
void add_rests(const Scene& scene, const std::vector<RangePoint>& range, const LineFit& line,
               std::vector<Term>& terms) {
  const auto& nodes = scene.drift.nodes();
  if (!scene.drift.known()) return;
  std::vector<double> factor(nodes.size(), 0.0);
  for (const RangePoint& p : range) {
    const auto influence = scene.drift.influence(p.t_s);
    const double part = p.line_weight * (p.at.x - line.x_mean) / line.sxx;
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

// Mean squares of the readings of a range about their levels' trends, and what the scatter of the
// force adds to them about the line: negative where the capacitance follows the force.
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

// Correlation of neighbouring force readings within the levels of the run.
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

// The correlation comes from all levels, the noise from this range. Readings deviate from the line
// by the scatter of the force, too. It has its own correlation, because the noise of a load cell is
// white where that of the capacitance is not.
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
  const auto error = error_of_repeats(range, lines, line);
  if (error) {
    out.of_slopes = out.error = *error;
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
