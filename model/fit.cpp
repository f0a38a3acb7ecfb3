// SPDX-License-Identifier: Apache-2.0
#include "model/fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>

namespace lcrig {
namespace {

constexpr int kMostIterations = 50;
constexpr double kStep = 1e-4;  // relative step of the derivatives
constexpr double kSettled = 1e-9;  // relative length of the last step

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

// Model values at all points for one pair of modulus and offset.
class Curve2 {
 public:
  Curve2(const Specimen& specimen, const LevelSettings& settings, std::size_t soft,
         const std::vector<FitPoint>& points)
      : specimen_(specimen), settings_(settings), soft_(soft), points_(points) {}

  Result<std::vector<double>> at(double mu_Pa, double offset_Pa) const {
    Specimen s = specimen_;
    Material& m = s.materials[soft_];
    m.given_shear_modulus_Pa = mu_Pa;
    m.youngs_modulus_Pa = 2 * mu_Pa * (1 + m.poisson_ratio);
    auto model = make_level_model(s, settings_);
    if (!model) return fail(model.error());
    std::vector<double> values;
    for (const auto& p : points_) {
      const auto state =
          (*model)->at_pressure(Pressure::from_si(std::max(p.pressure_Pa - offset_Pa, 0.0)));
      if (!state) return fail(state.error());
      values.push_back(state->delta_capacitance_F);
    }
    return values;
  }

 private:
  const Specimen& specimen_;
  const LevelSettings& settings_;
  std::size_t soft_;
  const std::vector<FitPoint>& points_;
};

struct Place {
  double mu_Pa = 0, offset_Pa = 0, shift_F = 0;
};

// Weighted least squares, linearized at a place. Rows are points; the last row is C0 if it is
// fitted.
struct Linear {
  Eigen::MatrixXd slopes;  // derivatives by log(mu), offset/scale_Pa, shift/scale_F
  Eigen::VectorXd residuals, values, weights;
  Eigen::MatrixXd normal() const { return slopes.transpose() * weights.asDiagonal() * slopes; }
  Eigen::VectorXd score() const { return slopes.transpose() * weights.asDiagonal() * residuals; }
  double chi2() const { return residuals.dot(weights.asDiagonal() * residuals); }
};

struct Fitter {
  const Curve2& curve;
  const std::vector<FitPoint>& points;
  double scale_Pa;  // of the offset
  double scale_F;  // of the shift
  C0Error c0;

  bool with_c0() const { return c0.standard_error_F > 0; }
  Eigen::Index parameters() const { return with_c0() ? 3 : 2; }
  double weight(const FitPoint& p) const {
    return p.standard_error_F > 0 ? 1 / (p.standard_error_F * p.standard_error_F) : 1e30;
  }

  Result<double> chi2(const Place& at) const {
    auto values = curve.at(at.mu_Pa, at.offset_Pa);
    if (!values) return fail(values.error());
    double sum = with_c0() ? std::pow(at.shift_F / c0.standard_error_F, 2) : 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double r = points[i].delta_capacitance_F - (*values)[i] - at.shift_F;
      sum += weight(points[i]) * r * r;
    }
    return sum;
  }

  Result<Linear> linear(const Place& at) const {
    auto here = curve.at(at.mu_Pa, at.offset_Pa);
    auto stiffer = curve.at(at.mu_Pa * (1 + kStep), at.offset_Pa);
    auto later = curve.at(at.mu_Pa, at.offset_Pa + kStep * scale_Pa);
    auto sooner = curve.at(at.mu_Pa, at.offset_Pa - kStep * scale_Pa);
    for (const auto* r : {&here, &stiffer, &later, &sooner}) {
      if (!*r) return fail(r->error());
    }
    const auto n = static_cast<Eigen::Index>(points.size());
    const Eigen::Index rows = n + (with_c0() ? 1 : 0);
    Linear l;
    l.slopes = Eigen::MatrixXd::Zero(rows, parameters());
    l.residuals = l.values = l.weights = Eigen::VectorXd::Zero(rows);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      l.weights(i) = weight(points[k]);
      l.values(i) = (*here)[k];
      l.slopes(i, 0) = ((*stiffer)[k] - (*here)[k]) / kStep;
      l.slopes(i, 1) = ((*later)[k] - (*sooner)[k]) / (2 * kStep);
      l.residuals(i) = points[k].delta_capacitance_F - (*here)[k] - at.shift_F;
      if (with_c0()) l.slopes(i, 2) = scale_F;
    }
    if (with_c0()) {
      l.slopes(n, 2) = scale_F;
      l.weights(n) = 1 / (c0.standard_error_F * c0.standard_error_F);
      l.residuals(n) = -at.shift_F;
    }
    return l;
  }
};

// Variance of the parameters from what each repeat contributes to them; the repeats are a sample.
Eigen::MatrixXd variance_of_repeats(const Fitter& fitter, const Linear& l,
                                    const Eigen::MatrixXd& inverse, int& repeats) {
  std::map<std::int32_t, Eigen::VectorXd> scores;
  for (std::size_t k = 0; k < fitter.points.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    auto [it, fresh] =
        scores.try_emplace(fitter.points[k].repeat, Eigen::VectorXd::Zero(l.slopes.cols()));
    it->second += l.weights(i) * l.residuals(i) * l.slopes.row(i).transpose();
  }
  repeats = static_cast<int>(scores.size());
  Eigen::MatrixXd middle = Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  if (repeats < 2) return middle;
  // The weight of C0 keeps the fit away from the points, and this part is common to all repeats.
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(l.slopes.cols());
  for (const auto& [repeat, score] : scores) mean += score / repeats;
  for (const auto& [repeat, score] : scores) {
    middle += (score - mean) * (score - mean).transpose() * repeats / (repeats - 1.0);
  }
  return inverse * middle * inverse;
}

// Variance that the error of C0 adds to the parameters. All repeats share this error, so their
// scatter does not show it, however much they differ.
Eigen::MatrixXd variance_of_c0(const Fitter& fitter, const Linear& l,
                               const Eigen::MatrixXd& inverse) {
  if (!fitter.with_c0()) return Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  const Eigen::Index last = l.slopes.rows() - 1;
  return inverse * l.slopes.row(last).transpose() * l.weights(last) * l.slopes.row(last) * inverse;
}

struct Spread {
  Eigen::MatrixXd of_residuals, of_repeats, of_c0;
  Eigen::VectorXd per_model_error;
  int freedom = 1, repeats = 0, freedom_of_c0 = 1;
};

// Half-width of the interval from two independent parts, with Welch and Satterthwaite's degrees of
// freedom, truncated (GUM G.4.1). If the first part has one or two degrees of freedom, these
// promise too much. Then the squares of the half-widths are added (Banerjee 1960), which never
// holds less often than stated.
double half_width(double first, int freedom, double second, int freedom_of_second) {
  const double t = student_t975(freedom), t_of_second = student_t975(freedom_of_second);
  const double variance = first + second;
  if (freedom < 3) return std::sqrt(t * t * first + t_of_second * t_of_second * second);
  if (!(variance > 0)) return 0;
  const double welch =
      variance * variance / (first * first / freedom + second * second / freedom_of_second);
  return student_t975(static_cast<int>(std::min(welch, 1e6))) * std::sqrt(variance);
}

// `unit`: the change of the value for a unit step of the parameter.
FitValue value_of(double value, Eigen::Index k, double unit, const Spread& s) {
  const bool sample = s.repeats >= 2;
  const double between = sample ? s.of_repeats(k, k) : s.of_residuals(k, k);
  const double c0 = sample ? s.of_c0(k, k) : 0;  // the residuals already include it
  const double half =
      unit * half_width(between, sample ? s.repeats - 1 : s.freedom, c0, s.freedom_of_c0);
  return {value, unit * std::sqrt(between + c0), value - half, value + half,
          unit * s.per_model_error(k)};
}

Fit summarize(const Fitter& fitter, const Linear& l, const Place& at, int iterations) {
  Fit fit;
  fit.points = static_cast<int>(fitter.points.size());
  fit.iterations = iterations;
  Spread s;
  s.freedom = fit.points - 2;
  const double scatter = l.chi2() / s.freedom;
  const Eigen::MatrixXd inverse = l.normal().inverse();
  s.of_residuals = inverse * scatter;
  s.of_repeats = variance_of_repeats(fitter, l, inverse, s.repeats);
  s.of_c0 = variance_of_c0(fitter, l, inverse);
  s.freedom_of_c0 = std::max(1, static_cast<int>(std::min(fitter.c0.degrees_of_freedom, 1e6)));
  s.per_model_error = -inverse * (l.slopes.transpose() * (l.weights.asDiagonal() * l.values));
  fit.repeats = s.repeats >= 2 ? s.repeats : 0;
  fit.shear_modulus_Pa = value_of(at.mu_Pa, 0, at.mu_Pa, s);
  fit.contact_offset_Pa = value_of(at.offset_Pa, 1, fitter.scale_Pa, s);
  if (fitter.with_c0()) fit.c0_shift_F = value_of(at.shift_F, 2, fitter.scale_F, s);
  fit.correlation = inverse(0, 1) / std::sqrt(inverse(0, 0) * inverse(1, 1));
  double weights = 0;
  for (const auto& p : fitter.points) weights += fitter.weight(p);
  fit.residual_F = std::sqrt(l.chi2() / weights);
  return fit;
}

// Takes one Gauss-Newton step, halved until it improves the fit. Returns its relative length.
double improve(const Fitter& fitter, const Linear& l, Place& at) {
  const Eigen::VectorXd step = l.normal().ldlt().solve(l.score());
  const double before = l.chi2();
  for (double length = 1; length > 1e-4; length /= 2) {
    Place next = at;
    next.mu_Pa *= std::exp(std::clamp(length * step(0), -1.0, 1.0));
    next.offset_Pa += length * step(1) * fitter.scale_Pa;
    if (fitter.with_c0()) next.shift_F += length * step(2) * fitter.scale_F;
    const auto chi2 = fitter.chi2(next);
    if (chi2 && *chi2 <= before * (1 + 1e-12)) {
      at = next;
      return length * step.cwiseAbs().sum();
    }
  }
  return 0;  // already at the minimum, up to rounding
}

// Scaled by the diagonal, so that only the similarity of the columns matters.
bool is_determined(const Eigen::MatrixXd& normal) {
  return normal.determinant() > 1e-20 * normal.diagonal().prod();
}

}  // namespace

double student_t975(int degrees_of_freedom) {
  const boost::math::students_t distribution(std::max(degrees_of_freedom, 1));
  return boost::math::quantile(distribution, 0.975);
}

Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const std::vector<FitPoint>& points, const C0Error& c0) {
  if (auto ok = check_specimen(specimen); !ok) return fail(ok.error());
  const std::size_t least = c0.standard_error_F > 0 ? 5 : 4;
  if (points.size() < least) {
    return fail(Errc::invalid_request, "fit: {} points, at least {} are needed", points.size(),
                least);
  }
  const auto soft = find_soft(specimen);
  if (!soft) return fail(soft.error());
  double highest = 0, largest = 0;
  for (const auto& p : points) {
    if (!std::isfinite(p.pressure_Pa) || !std::isfinite(p.delta_capacitance_F)) {
      return fail(Errc::invalid_request, "fit: a point is not a number");
    }
    highest = std::max(highest, p.pressure_Pa);
    largest = std::max(largest, std::abs(p.delta_capacitance_F));
  }
  const Curve2 curve(specimen, settings, *soft, points);
  const Fitter fitter{curve, points, std::max(highest, 1.0), std::max(largest, 1e-18), c0};
  Place at{specimen.materials[*soft].shear_modulus_Pa(), 0, 0};
  for (int i = 1; i <= kMostIterations; ++i) {
    const auto l = fitter.linear(at);
    if (!l) return fail(l.error());
    if (!is_determined(l->normal())) break;
    if (improve(fitter, *l, at) < kSettled) return summarize(fitter, *l, at, i);
  }
  return fail(Errc::invalid_request,
              "fit: no convergence; the points do not determine modulus and offset together");
}

}  // namespace lcrig
