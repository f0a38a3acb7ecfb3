// SPDX-License-Identifier: Apache-2.0
#include "model/fit_place.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLogStep = 1e-3;  // of log(mu), for central differences: their error is below 1e-6
// Share of the pressure range over which a misfit of the law changes its sign: a law that is wrong
// bends once or twice between nothing and the highest pressure.
constexpr double kMisfitLength = 0.4;
// A specimen that creeps answers as to a higher pressure; beyond this the curve goes straight.
constexpr double kBeyond = 1.1;
constexpr double kMiddlingCreep = 0.01, kMiddlingMisfit = 1e-3;

Result<std::size_t> find_soft(const Specimen& s) {
  std::vector<std::size_t> soft;
  for (std::size_t i = 0; i < s.materials.size(); ++i) {
    if (s.is_soft(s.materials[i])) soft.push_back(i);
  }
  if (soft.size() != 1) {
    return fail(Errc::invalid_request, "fit: specimen {} has {} soft materials, expected one",
                s.name, soft.size());
  }
  return soft.front();
}

// Covariance of the law's misfit between two pressures, relative to the highest; 0 without a load.
double misfit_between(double a, double b) {
  if (!(a > 0) || !(b > 0)) return 0;
  const double distance = (a - b) / kMisfitLength;
  return a * b * std::exp(-distance * distance / 2);
}

}  // namespace

Result<FitPlaces> FitPlaces::make(const Specimen& specimen, const LevelSettings& settings,
                                  const FitData& data) {
  if (auto ok = check_specimen(specimen); !ok) return fail(ok.error());
  const auto soft = find_soft(specimen);
  if (!soft) return fail(soft.error());
  auto cells = cells_of(data);
  if (!cells) return fail(cells.error());
  FitPlaces out(specimen, settings, data);
  out.cells_ = std::move(*cells);
  out.soft_ = *soft;
  out.start_mu_Pa_ = specimen.materials[*soft].shear_modulus_Pa();
  auto curve = out.curve(specimen, out.start_mu_Pa_);
  if (!curve) return fail(curve.error());
  out.start_ = {out.start_mu_Pa_, 0, 0, VectorXd::Zero(out.elements()), std::move(*curve)};
  VectorXd times = VectorXd::Zero(out.rows());
  for (Eigen::Index i = 0; i < out.cells_.size(); ++i) {
    times(i) = out.cells_.mean[static_cast<std::size_t>(i)].time_s * data.drift_error_F_s;
  }
  out.drift_ = times * times.transpose();
  return out;
}

Eigen::Index FitPlaces::elements() const {
  return data_.creep_times_s.empty() ? 0 : std::ssize(data_.creep_times_s) + 1;
}

int FitPlaces::different_pressures() const {
  std::vector<double> all;
  for (const FitPoint& p : cells_.mean) {
    if (p.pressure_Pa > 0) all.push_back(p.pressure_Pa);
  }
  std::sort(all.begin(), all.end());
  int count = 0;
  double last = 0;
  for (const double Pa : all) {
    if (Pa <= last * 1.02) continue;
    last = Pa;
    ++count;
  }
  return count;
}

Result<FitCurve> FitPlaces::curve(const Specimen& specimen, double mu_Pa) const {
  Specimen s = specimen;
  Material& m = s.materials[soft_];
  m.given_shear_modulus_Pa = mu_Pa;
  m.youngs_modulus_Pa = 2 * mu_Pa * (1 + m.poisson_ratio);
  if (elements() == 0) return FitCurve::solve(s, settings_, cells_.highest_Pa);
  auto beyond = FitCurve::solve(s, settings_, kBeyond * cells_.highest_Pa);
  return beyond ? std::move(beyond) : FitCurve::solve(s, settings_, cells_.highest_Pa);
}

Result<FitPlace> FitPlaces::stepped(const FitPlace& from, const VectorXd& target,
                                    double length) const {
  if (!target.allFinite()) return fail(Errc::invalid_request, "{}", kNoConvergence);
  FitPlace next = from;
  next.mu_Pa *= std::exp(std::clamp(length * target(0), -1.0, 1.0));
  next.offset_Pa += length * (target(1) * cells_.highest_Pa - from.offset_Pa);
  if (with_c0()) next.shift_F += length * (target(2) * cells_.span_F - from.shift_F);
  auto curve = this->curve(specimen_, next.mu_Pa);
  if (!curve) return fail(curve.error());
  next.curve = std::move(*curve);
  return next;
}

// The pressure that would act at once as this one does with its history, less the offset.
double FitPlaces::answered_Pa(const FitPoint& p, const FitPlace& at) const {
  double Pa = p.pressure_Pa - at.offset_Pa;
  if (p.pressure_Pa <= 0 || elements() == 0) return Pa;
  for (std::size_t k = 0; k < p.memory_Pa.size(); ++k) {
    Pa += at.amplitudes(static_cast<Eigen::Index>(k)) * p.memory_Pa[k];
  }
  return Pa + at.amplitudes(elements() - 1) * p.pressure_Pa * p.held_decades;
}

VectorXd FitPlaces::law(const FitPlace& at) const {
  VectorXd out = VectorXd::Zero(cells_.size());
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const FitPoint& p = cells_.mean[static_cast<std::size_t>(i)];
    if (p.pressure_Pa > 0) out(i) = at.curve.at(answered_Pa(p, at));
  }
  return out;
}

// Derivatives by the amplitudes. What the drift took away of the memory is missing from the data.
MatrixXd FitPlaces::creep(const FitPlace& at) const {
  MatrixXd out = MatrixXd::Zero(rows(), elements());
  if (elements() == 0) return out;
  const double unloaded = at.curve.slope(0);
  for (Eigen::Index i = 0; i < cells_.size(); ++i) {
    const FitPoint& p = cells_.mean[static_cast<std::size_t>(i)];
    const double slope = p.pressure_Pa > 0 ? at.curve.slope(answered_Pa(p, at)) : unloaded;
    for (std::size_t k = 0; k < p.memory_Pa.size(); ++k) {
      const double drift = k < data_.memory_drift_Pa_s.size() ? data_.memory_drift_Pa_s[k] : 0;
      out(i, static_cast<Eigen::Index>(k)) = slope * p.memory_Pa[k] - unloaded * drift * p.time_s;
    }
    out(i, elements() - 1) = slope * p.pressure_Pa * p.held_decades;
  }
  return out;
}

MatrixXd FitPlaces::deviations(const FitPlace& at) const {
  MatrixXd out = cells_.deviations;
  for (Eigen::Index i = 0; i < cells_.size(); ++i) {
    const FitPoint& p = cells_.mean[static_cast<std::size_t>(i)];
    const double slope = at.curve.slope(p.pressure_Pa > 0 ? answered_Pa(p, at) : 0);
    for (Eigen::Index k = 0; k < elements(); ++k) {
      const MatrixXd& of = cells_.memory_deviations[static_cast<std::size_t>(k)];
      out.row(i) -= slope * at.amplitudes(k) * of.row(i);
    }
  }
  return out;
}

VectorXd FitPlaces::residuals(const FitPlace& at, const ScaledProblem& problem) const {
  VectorXd out = VectorXd::Zero(rows());
  const VectorXd of_law = law(at);
  for (Eigen::Index i = 0; i < cells_.size(); ++i) {
    const FitPoint& p = cells_.mean[static_cast<std::size_t>(i)];
    out(i) = p.delta_capacitance_F - of_law(i) - at.shift_F;
    if (elements() == 0) continue;
    // Creep that is not in the argument of the law: at rest, and what the drift took away.
    const double slope = p.pressure_Pa > 0 ? at.curve.slope(answered_Pa(p, at)) : 0;
    for (std::size_t k = 0; k < p.memory_Pa.size(); ++k) {
      const auto c = static_cast<Eigen::Index>(k);
      out(i) -= at.amplitudes(c) * (problem.creep(i, c) - slope * p.memory_Pa[k]);
    }
  }
  if (with_c0()) out(cells_.size()) = -at.shift_F;
  return out;
}

void FitPlaces::fill_errors(ScaledProblem& out) const {
  const Eigen::Index n = cells_.size();
  out.readings = n;
  out.noise = VectorXd::Zero(rows());
  out.noise.head(n) = cells_.noise;
  if (with_c0()) out.noise(n) = std::pow(data_.c0.standard_error_F, 2);
  out.known = drift_;
  out.known.topLeftCorner(n, n) += cells_.repeats;
  out.misfit = MatrixXd::Zero(rows(), rows());
  // A specimen may come back to another capacitance for good. The rests share this shift, and only
  // their recovery tells of creep.
  double shift2 = 0, rests = 0;
  for (const FitPoint& p : cells_.mean) {
    if (p.pressure_Pa > 0) continue;
    shift2 += std::pow(p.delta_capacitance_F, 2);
    rests += 1;
  }
  const double set = rests > 0 ? shift2 / rests : 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double a = cells_.mean[static_cast<std::size_t>(i)].pressure_Pa / cells_.highest_Pa;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double b = cells_.mean[static_cast<std::size_t>(k)].pressure_Pa / cells_.highest_Pa;
      out.misfit(i, k) = cells_.span_F * cells_.span_F * misfit_between(a, b);
      if (a <= 0 && b <= 0) out.known(i, k) += set;
    }
  }
}

Result<ScaledProblem> FitPlaces::problem(const FitPlace& at) const {
  const auto stiffer = curve(specimen_, at.mu_Pa * std::exp(kLogStep));
  const auto softer = curve(specimen_, at.mu_Pa * std::exp(-kLogStep));
  for (const auto* r : {&stiffer, &softer}) {
    if (!*r) return fail(r->error());
  }
  ScaledProblem out;
  const Eigen::Index n = cells_.size();
  out.slopes = MatrixXd::Zero(rows(), with_c0() ? 3 : 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const FitPoint& p = cells_.mean[static_cast<std::size_t>(i)];
    if (with_c0()) out.slopes(i, 2) = cells_.span_F;
    if (p.pressure_Pa <= 0) continue;
    const double Pa = answered_Pa(p, at);
    out.slopes(i, 0) = (stiffer->at(Pa) - softer->at(Pa)) / (2 * kLogStep);
    if (Pa > 0) out.slopes(i, 1) = -at.curve.slope(Pa) * cells_.highest_Pa;
  }
  if (with_c0()) out.slopes(n, 2) = cells_.span_F;
  out.creep = creep(at);
  fill_errors(out);
  out.values = residuals(at, out) + out.creep * at.amplitudes;
  out.values += out.slopes.col(1) * (at.offset_Pa / cells_.highest_Pa);
  if (with_c0()) out.values += out.slopes.col(2) * (at.shift_F / cells_.span_F);
  return out;
}

FitObjective::FitObjective(const ScaledProblem& p) {
  MatrixXd variance =
      MatrixXd(p.noise.asDiagonal()) + p.known + kMiddlingMisfit * kMiddlingMisfit * p.misfit;
  variance += kMiddlingCreep * kMiddlingCreep * p.creep * p.creep.transpose();
  llt_.compute(variance);
}

// Scaled by the diagonal, so that only the similarity of the columns matters.
bool FitObjective::determines(const MatrixXd& slopes) const {
  const MatrixXd normal = slopes.transpose() * llt_.solve(slopes);
  return normal.determinant() > 1e-20 * normal.diagonal().prod();
}

VectorXd FitObjective::solve(const MatrixXd& slopes, const VectorXd& values) const {
  const MatrixXd weighted = llt_.solve(slopes);
  return (slopes.transpose() * weighted).ldlt().solve(weighted.transpose() * values);
}

}  // namespace lcrig
