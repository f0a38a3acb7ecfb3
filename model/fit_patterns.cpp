// SPDX-License-Identifier: Apache-2.0
#include "model/fit_patterns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <optional>

#include "model/auto_level.hpp"

namespace lcrig {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMisfitP = 0.01;  // below it the law alone does not describe the data
constexpr double kCreepShows = 2.6;  // standard errors: chance exceeds it once in a hundred
constexpr int kChords = 6;
// A modulus this many times the file's, or less than its inverse, makes other faces worth a try.
constexpr double kOtherModulus = 2.5;

double c0_ratio(const FitPlaces& places, const FitPlace& at) {
  const double measured = places.data().measured_c0_F;
  return measured > 0 && at.curve.c0_F() > 0 ? measured / at.curve.c0_F() : 1;
}

// The specimen whose soft layers, or films, are thicker by this factor.
Specimen thickened(Specimen s, bool soft, double factor) {
  for (Capacitor& c : s.capacitors) {
    for (Layer& l : c.layers) {
      if (s.is_soft(s.material(l)) == soft) l.thickness_m *= factor;
    }
  }
  return s;
}

// The thickness that would give the measured C0. nullopt: none within a factor of two.
std::optional<Specimen> as_measured(const Specimen& s, bool soft, double ratio) {
  const double wanted_F = s.c0_F() * ratio;
  double low = 0.5, high = 2;
  if (thickened(s, soft, low).c0_F() < wanted_F || thickened(s, soft, high).c0_F() > wanted_F) {
    return std::nullopt;
  }
  while (high - low > 1e-12) {
    const double middle = (low + high) / 2;
    (thickened(s, soft, middle).c0_F() > wanted_F ? low : high) = middle;
  }
  return thickened(s, soft, low);
}

// Moves the parameters until a changed law leaves the same weighted residuals as ours does. The
// weights stay, so the influence does.
std::optional<VectorXd> shift_under(const FitPlaces& places, const FitPlace& from,
                                    const MatrixXd& influence, const Specimen& other,
                                    double factor) {
  const Eigen::Index n = places.cells().size();
  const MatrixXd of_cells = influence.leftCols(n);
  const VectorXd ours = places.law(from);
  FitPlace at = from;
  VectorXd shift = VectorXd::Zero(influence.rows());
  for (int i = 0; i < kChords; ++i) {
    auto curve = places.curve(other, at.mu_Pa);
    if (!curve) return std::nullopt;
    at.curve = std::move(*curve);
    VectorXd step = of_cells * (ours - factor * places.law(at));
    if (influence.rows() > 2) {
      // A shift moves the cells and C0's datum alike, and the influence knows both.
      const double moved = (at.shift_F - from.shift_F);
      step -= influence.rowwise().sum() * moved;
    }
    shift += step;
    at.mu_Pa = from.mu_Pa * std::exp(std::clamp(shift(0), -2.0, 2.0));
    at.offset_Pa = from.offset_Pa + shift(1) * places.cells().highest_Pa;
    if (influence.rows() > 2) at.shift_F = from.shift_F + shift(2) * places.cells().span_F;
    if (step.cwiseAbs().maxCoeff() < 1e-7) break;
  }
  return shift;
}

// The law alone, at its own best place: the residuals that show the pattern.
void judge_law_alone(const FitPlaces& places, const ScaledProblem& problem, FitMisfit& out) {
  const PlainAnswer plain = solve_plain(problem);
  out.chi2 = plain.chi2;
  out.degrees_of_freedom = static_cast<double>(problem.values.size() - problem.slopes.cols());
  const Eigen::Index n = places.cells().size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const FitPoint& p = places.cells().mean[static_cast<std::size_t>(i)];
    const double sd = plain.residual_sd(i);
    out.pulls.push_back(
        {p.pressure_Pa, p.time_s, plain.residuals(i), sd > 0 ? plain.residuals(i) / sd : 0});
  }
  if (places.with_c0()) out.c0_pull = -plain.residuals(n) / std::sqrt(problem.noise(n));
}

double p_of(double chi2, double freedom) {
  const boost::math::chi_squared distribution(std::max(freedom, 1.0));
  return boost::math::cdf(boost::math::complement(distribution, std::max(chi2, 0.0)));
}

// Weighted squares that the law leaves when creep of the found size is allowed for.
double chi2_with_creep(const ScaledProblem& problem, double scale) {
  ScaledProblem creeping = problem;
  creeping.known += scale * scale * problem.creep * problem.creep.transpose();
  return solve_plain(creeping).chi2;
}

// `p_with`: how well the law describes the data when it may creep as found.
void find_creep(const FitPlaces& places, const ScaledAnswer& answer, double p_with,
                FitMisfit& out) {
  const Eigen::Index k = answer.amplitudes.size();
  if (k < 2) return;
  // What has yielded at the end of the run under a held load; the last amplitude is per decade.
  double run_s = 0;
  for (const FitPoint& p : places.cells().mean) run_s = std::max(run_s, p.time_s);
  VectorXd yielded = VectorXd::Zero(k);
  for (Eigen::Index i = 0; i + 1 < k; ++i) {
    yielded(i) = -std::expm1(-run_s / places.data().creep_times_s[static_cast<std::size_t>(i)]);
  }
  double decades = 0;
  for (const FitPoint& p : places.cells().mean) decades = std::max(decades, p.held_decades);
  yielded(k - 1) = decades;
  const double size = yielded.dot(answer.amplitudes);
  const double error = std::sqrt(yielded.dot(answer.amplitudes_covariance * yielded));
  const bool shows = std::abs(size) > kCreepShows * error;
  if (out.p > kMisfitP || !(shows || p_with > kMisfitP)) return;
  out.patterns.push_back(
      {FitPatternKind::creep, size * 100,
       fmt::format("creep: the specimen yields by {:.2g} % +- {:.2g} % of the load in the run",
                   size * 100, error * 100)});
}

void find_hysteresis(const FitPlaces& places, FitMisfit& out) {
  double gap_F = 0;
  for (const FitPoint& p : places.cells().mean) {
    if (std::abs(p.gap_F) > std::abs(gap_F)) gap_F = p.gap_F;
  }
  if (gap_F == 0) return;
  const double percent = gap_F / places.cells().span_F * 100;
  out.patterns.push_back(
      {FitPatternKind::hysteresis, percent,
       fmt::format("hysteresis: unloading lies up to {:.2g} % of the span from loading", percent)});
}

void find_size(const FitPlaces& places, const FitPlace& at, FitMisfit& out) {
  const double ratio = c0_ratio(places, at), off = ratio - 1;
  const double error = places.data().c0_tolerance +
                       2 * places.data().c0.standard_error_F / places.data().measured_c0_F;
  if (!(places.data().measured_c0_F > 0) || std::abs(off) <= error) return;
  std::string text = fmt::format(
      "size: C0 is {:+.2g} % from that of the specimen's file; permittivity or disc area {:+.2g} %",
      off * 100, off * 100);
  const auto soft = as_measured(places.specimen(), true, ratio);
  if (soft) {
    const auto thickness = [](const Specimen& s) {
      double sum = 0;
      for (const Capacitor& c : s.capacitors) {
        for (const Layer& l : c.layers) sum += s.is_soft(s.material(l)) ? l.thickness_m : 0;
      }
      return sum;
    };
    text += fmt::format(", or soft layers {:+.2g} % thick",
                        (thickness(*soft) / thickness(places.specimen()) - 1) * 100);
  }
  out.patterns.push_back({FitPatternKind::size, off * 100, text + ", would explain it"});
}

// Other faces explain a modulus far from the file's if they bring it near.
void find_faces(const FitPlaces& places, const FitPlace& at, FitMisfit& out) {
  const double ratio = at.mu_Pa / places.start_mu_Pa();
  if (ratio < kOtherModulus && ratio > 1 / kOtherModulus) return;
  const double highest_Pa = places.cells().highest_Pa;
  Specimen other = places.specimen();
  other.faces = other.faces == Faces::free ? Faces::bonded_laminate : Faces::free;
  const auto choice = choose_level(other, 0.1, Pressure::from_si(highest_Pa));
  if (!choice) return;
  const auto curve = FitCurve::solve(other, choice->settings, highest_Pa);
  if (!curve) return;
  const double seen = places.law(at).maxCoeff(), expected = curve->at(highest_Pa);
  if (!(expected > 0) || std::abs(std::log(seen / expected)) > std::log(1.5)) return;
  out.patterns.push_back(
      {FitPatternKind::faces, (ratio - 1) * 100,
       fmt::format("faces: the modulus is {:.2g} times the file's; with {} faces the file's "
                   "modulus gives what was measured",
                   ratio, to_string(other.faces))});
}

}  // namespace

std::vector<VectorXd> FitShifts::all() const {
  std::vector<VectorXd> out = geometry;
  out.insert(out.end(), hysteresis.begin(), hysteresis.end());
  return out;
}

FitShifts find_shifts(const FitPlaces& places, const FitPlace& at, const MatrixXd& influence) {
  FitShifts out;
  const Eigen::Index n = places.cells().size();
  const double ratio = c0_ratio(places, at);
  if (ratio != 1) {
    const auto add = [&](const std::optional<VectorXd>& shift) {
      if (shift) out.geometry.push_back(*shift);
    };
    add(shift_under(places, at, influence, places.specimen(), ratio));
    for (const bool soft : {true, false}) {
      const auto other = as_measured(places.specimen(), soft, ratio);
      if (other) add(shift_under(places, at, influence, *other, 1));
    }
  }
  VectorXd gap = VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    gap(i) = places.cells().mean[static_cast<std::size_t>(i)].gap_F / 2;
  }
  if (gap.cwiseAbs().maxCoeff() > 0) out.hysteresis.push_back(influence.leftCols(n) * gap);
  return out;
}

FitMisfit find_misfit(const FitPlaces& places, const FitPlace& at, const ScaledProblem& problem,
                      const ScaledAnswer& answer) {
  FitMisfit out;
  ScaledProblem scattered = problem;
  scattered.noise.head(problem.readings) *= answer.scatter * answer.scatter;
  judge_law_alone(places, scattered, out);
  out.p = p_of(out.chi2, out.degrees_of_freedom);
  const Eigen::Index n = places.cells().size();
  out.law_F = std::sqrt(answer.misfit.head(n).squaredNorm() / static_cast<double>(n));
  const double p_with_creep =
      p_of(chi2_with_creep(scattered, answer.creep_scale), out.degrees_of_freedom);
  find_creep(places, answer, p_with_creep, out);
  find_hysteresis(places, out);
  find_size(places, at, out);
  find_faces(places, at, out);
  if (p_with_creep < kMisfitP) {
    const double percent = out.law_F / places.cells().span_F * 100;
    out.patterns.push_back(
        {FitPatternKind::law, percent,
         fmt::format("law: it leaves {:.2g} fF rms ({:.2g} % of the span) beside creep",
                     out.law_F * 1e15, percent)});
  }
  return out;
}

}  // namespace lcrig
