// SPDX-License-Identifier: Apache-2.0
#include "model/fit.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "model/fit_cells.hpp"
#include "model/fit_curve.hpp"
#include "model/fit_patterns.hpp"
#include "model/fit_place.hpp"
#include "model/fit_scales.hpp"

namespace lcrig {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostIterations = 50, kMostRounds = 4;
constexpr double kFitSettled = 1e-9;  // decrease of the objective: relative, and of a chi square
constexpr double kSettledRound = 0.02;  // standard errors
// Largest half-width of the modulus, relative to it, that creep, misfit and shifts may make.
constexpr double kMostMisfit = 0.5;
// Largest root mean square that the law may leave beside creep, relative to the span.
constexpr double kMostLeft = 0.1;

// Scales that the data choose among; relative to the pressure (creep) and to the span (misfit).
ScaleGrid grid_of(const FitCells& cells, bool with_creep) {
  ScaleGrid grid;
  grid.creep = {0};
  for (double s = 2e-4; with_creep && s < 0.2; s *= 2.2) grid.creep.push_back(s);
  for (double s = 3e-5; s < 0.5; s *= 2.5) grid.misfit.push_back(s);
  if (cells.repeat_count > 1) {
    grid.scatter = {1};
  } else if (cells.told) {
    grid.scatter = {1, 1.5, 2.2, 3.3};
  } else {
    for (double s = 1e-3; s < 200; s *= 2.5) grid.scatter.push_back(s);
  }
  return grid;
}

// Finds the least squares with middling scales by Gauss and Newton's method; a step is halved until
// the objective falls.
Result<int> descend(const FitPlaces& places, FitPlace& at) {
  auto problem = places.problem(at);
  if (!problem) return fail(problem.error());
  const FitObjective objective(*problem);
  double before = objective.at(places.residuals(at, *problem));
  for (int i = 1; i <= kMostIterations; ++i) {
    if (!objective.determines(problem->slopes)) break;
    const VectorXd target = objective.solve(problem->slopes, problem->values);
    bool better = false;
    double after = before;
    for (double length = 1; length > 1e-4 && !better; length /= 2) {
      const auto next = places.stepped(at, target, length);
      if (!next) continue;
      after = objective.at(places.residuals(*next, *problem));
      better = after <= before;
      if (better) at = *next;
    }
    if (!better || before - after <= kFitSettled * (1 + before)) return i;
    before = after;
    problem = places.problem(at);
    if (!problem) return fail(problem.error());
  }
  return fail(Errc::invalid_request, "{}", kNoConvergence);
}

struct Widths {
  MatrixXd of_repeats, of_others, of_c0;
  double freedom = 1, freedom_of_c0 = 1, freedom_of_misfit = 2;
};

// What each repeat contributes; the repeats are a sample. With one repeat: the noise of its points.
void fill_repeats(const FitPlaces& places, const FitPlace& at, const ScaledAnswer& answer,
                  const MatrixXd& of_c0, Widths& out) {
  const FitCells& cells = places.cells();
  if (cells.repeat_count < 2) {
    out.of_repeats = answer.of_noise - of_c0;
    out.freedom = std::max(1.0, static_cast<double>(cells.size() - answer.parameters.size()));
    return;
  }
  const MatrixXd shares = answer.influence.leftCols(cells.size()) * places.deviations(at);
  const double r = cells.repeat_count;
  out.of_repeats = shares * shares.transpose() / (r * (r - 1));
  out.freedom = r - 1;
}

// Half-width of the interval from two independent parts, with Welch and Satterthwaite's degrees of
// freedom, truncated (GUM G.4.1). If the first part has one or two degrees of freedom, these
// promise too much. Then the squares of the half-widths are added (Banerjee 1960), which never
// holds less often than stated.
double half_width(double first, double freedom, double second, double freedom_of_second) {
  const double t = student_t975(freedom), t_of_second = student_t975(freedom_of_second);
  const double variance = first + second;
  if (freedom < 3) return std::sqrt(t * t * first + t_of_second * t_of_second * second);
  if (!(variance > 0)) return 0;
  const double welch =
      variance * variance / (first * first / freedom + second * second / freedom_of_second);
  return student_t975(std::floor(std::min(welch, 1e6))) * std::sqrt(variance);
}

struct Answered {
  FitPlace at;
  ScaledProblem problem;
  ScaledAnswer answer;
};

// Moves to the answer of all scales and linearizes there again.
Result<Answered> settle(FitPlaces& places, const ScaleGrid& grid, FitPlace at) {
  Answered out{at, {}, {}};
  for (int round = 1; round <= kMostRounds; ++round) {
    auto problem = places.problem(out.at);
    if (!problem) return fail(problem.error());
    out.problem = std::move(*problem);
    out.answer = solve_scales(out.problem, grid);
    auto next = places.stepped(out.at, out.answer.parameters, 1);
    if (!next) return fail(next.error());
    next->amplitudes = out.answer.amplitudes;
    const double error = std::sqrt(std::max(
        0.0, out.answer.of_noise(0, 0) + out.answer.of_misfit(0, 0) + out.answer.of_creep(0, 0)));
    const double step = std::abs(out.answer.parameters(0));
    out.at = *next;
    places.judge_repeats(out.at);
    if (round > 1 && (step < kSettledRound * error || step < 1e-9)) break;
  }
  return out;
}

// Of the parts that all repeats share, C0 and misfit have few degrees of freedom.
double freedom_of_others(const Widths& w, Eigen::Index k) {
  const double c0 = w.of_c0(k, k), rest = std::max(0.0, w.of_others(k, k) - c0);
  if (!(c0 + rest > 0)) return 1e6;
  const double welch =
      (c0 + rest) * (c0 + rest) / (c0 * c0 / w.freedom_of_c0 + rest * rest / w.freedom_of_misfit);
  return std::clamp(welch, 1.0, 1e6);
}

// `unit`: the change of the value for a unit of the parameter.
FitValue value_of(double value, Eigen::Index k, double unit, const Widths& w,
                  const VectorXd& per_model_error, const std::vector<VectorXd>& shifts) {
  const double between = std::max(0.0, w.of_repeats(k, k));
  const double others = std::max(0.0, w.of_others(k, k));
  const double half = half_width(between, w.freedom, others, freedom_of_others(w, k));
  double low = 0, high = 0;
  for (const VectorXd& shift : shifts) {
    low = std::min(low, shift(k));
    high = std::max(high, shift(k));
  }
  return {value, unit * std::sqrt(between + others), value + unit * (low - half),
          value + unit * (high + half), unit * per_model_error(k)};
}

double largest(const std::vector<VectorXd>& shifts, Eigen::Index k) {
  double out = 0;
  for (const VectorXd& s : shifts) out = std::max(out, std::abs(s(k)));
  return out;
}

Widths widths_of(const FitPlaces& places, const Answered& of) {
  Widths w;
  const Eigen::Index m = of.answer.parameters.size(), n = places.cells().size();
  w.of_c0 = MatrixXd::Zero(m, m);
  if (places.with_c0()) {
    const VectorXd a = of.answer.influence.col(n);
    w.of_c0 = a * a.transpose() * of.problem.noise(n);
  }
  fill_repeats(places, of.at, of.answer, w.of_c0, w);
  const MatrixXd drift =
      of.answer.influence * places.shared_known() * of.answer.influence.transpose();
  w.of_others = w.of_c0 + drift + of.answer.of_creep + of.answer.of_misfit + of.answer.of_scales;
  w.freedom_of_c0 = std::max(1.0, places.data().c0.degrees_of_freedom);
  w.freedom_of_misfit = std::max(2.0, places.different_pressures() - 3.0);
  return w;
}

FitParts parts_of(const FitPlaces& places, const Answered& of, const Widths& w,
                  const FitShifts& shifts) {
  const auto sd = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  FitParts p;
  p.repeats = sd(w.of_repeats(0, 0));
  p.c0 = sd(w.of_c0(0, 0));
  const VectorXd a = of.answer.influence.row(0);
  p.drift = sd(a.dot(places.shared_known() * a));
  p.creep = sd(of.answer.of_creep(0, 0));
  p.misfit = sd(of.answer.of_misfit(0, 0) + of.answer.of_scales(0, 0));
  p.geometry = largest(shifts.geometry, 0);
  p.hysteresis = largest(shifts.hysteresis, 0);
  return p;
}

Fit summarize(const FitPlaces& places, const Answered& of, const FitShifts& shifts) {
  const FitCells& cells = places.cells();
  const Widths w = widths_of(places, of);
  Fit fit;
  fit.points = static_cast<int>(places.data().points.size());
  fit.repeats = cells.repeat_count >= 2 ? cells.repeat_count : 0;
  VectorXd modelled = VectorXd::Zero(of.problem.values.size());
  modelled.head(cells.size()) = places.law(of.at);
  const VectorXd per_model_error = -(of.answer.influence * modelled);
  const auto value = [&](double at, Eigen::Index k, double unit) {
    return value_of(at, k, unit, w, per_model_error, shifts.all());
  };
  fit.shear_modulus_Pa = value(of.at.mu_Pa, 0, of.at.mu_Pa);
  fit.contact_offset_Pa = value(of.at.offset_Pa, 1, cells.highest_Pa);
  if (places.with_c0()) fit.c0_shift_F = value(of.at.shift_F, 2, cells.span_F);
  const MatrixXd all = w.of_repeats + w.of_others;
  fit.correlation = all(0, 1) / std::sqrt(all(0, 0) * all(1, 1));
  const VectorXd left = places.residuals(of.at, of.problem).head(cells.size());
  fit.residual_F = std::sqrt(left.squaredNorm() / static_cast<double>(cells.size()));
  fit.parts = parts_of(places, of, w, shifts);
  return fit;
}

Result<> refuse_if_meaningless(const Fit& fit, double span_F) {
  const FitParts& p = fit.parts;
  const double misfit = 2 * std::hypot(p.creep, p.misfit) + p.geometry + p.hysteresis;
  const double left = fit.misfit.law_F / span_F;
  // Both moduli describe the readings, and they differ by more than kMostMisfit.
  for (const FitPattern& pattern : fit.misfit.patterns) {
    if (pattern.kind != FitPatternKind::faces) continue;
    return fail(Errc::invalid_request,
                "fit refused: {}: state the faces, or a modulus nearer to the truth, in the "
                "specimen's file",
                pattern.text);
  }
  if (misfit <= kMostMisfit && left <= kMostLeft) return {};
  std::string why;
  for (const FitPattern& pattern : fit.misfit.patterns) why += "; " + pattern.text;
  if (why.empty()) why = "; the levels do not tell creep and misfit from the modulus";
  return fail(Errc::invalid_request,
              "fit refused: the law does not describe these readings (it leaves {:.2g} % of the "
              "span, and the modulus could be off by {:.2g} %){}",
              left * 100, misfit * 100, why);
}

}  // namespace

double student_t975(double degrees_of_freedom) {
  const boost::math::students_t distribution(std::max(degrees_of_freedom, 1.0));
  return boost::math::quantile(distribution, 0.975);
}

Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const FitData& data) {
  auto places = FitPlaces::make(specimen, settings, data);
  if (!places) return fail(places.error());
  FitPlace at = places->start();
  const auto iterations = descend(*places, at);
  if (!iterations) return fail(iterations.error());
  const ScaleGrid grid = grid_of(places->cells(), !data.creep_times_s.empty());
  const auto of = settle(*places, grid, at);
  if (!of) return fail(of.error());
  const FitShifts shifts = find_shifts(*places, of->at, of->answer.influence);
  Fit fit = summarize(*places, *of, shifts);
  fit.iterations = *iterations;
  fit.misfit = find_misfit(*places, of->at, of->problem, of->answer);
  if (auto ok = refuse_if_meaningless(fit, places->cells().span_F); !ok) return fail(ok.error());
  return fit;
}

}  // namespace lcrig
