// SPDX-License-Identifier: Apache-2.0
#include "model/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lcrig {
namespace {

constexpr int kMostIterations = 50;
constexpr double kStep = 1e-4;  // relative, for derivatives

Result<std::size_t> find_soft(const Specimen& s) {
  std::vector<std::size_t> soft;
  for (std::size_t i = 0; i < s.materials.size(); ++i) {
    if (s.is_soft(s.materials[i])) {
      soft.push_back(i);
    }
  }
  if (soft.size() != 1) {
    return fail(Errc::invalid_request, "fit: specimen {} has {} soft materials, expected one",
                s.name, soft.size());
  }
  return soft.front();
}

// Model values at all points for one pair of parameters.
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
    if (!model) {
      return fail(model.error());
    }
    std::vector<double> values;
    for (const auto& p : points_) {
      const auto state =
          (*model)->at_pressure(Pressure::from_si(std::max(p.pressure_Pa - offset_Pa, 0.0)));
      if (!state) {
        return fail(state.error());
      }
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

// Normal equations of the two parameters, scaled by mu and by the largest pressure.
struct Normal {
  double a00 = 0, a01 = 0, a11 = 0, b0 = 0, b1 = 0, chi2 = 0;
  double determinant() const { return a00 * a11 - a01 * a01; }
};

struct Fitter {
  const Curve2& curve;
  const std::vector<FitPoint>& points;
  double scale_Pa;  // of the offset

  double weight(const FitPoint& p) const {
    return p.standard_error_F > 0 ? 1 / (p.standard_error_F * p.standard_error_F) : 1e30;
  }

  Result<double> chi2(double mu, double offset) const {
    auto values = curve.at(mu, offset);
    if (!values) {
      return fail(values.error());
    }
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double r = points[i].delta_capacitance_F - (*values)[i];
      sum += weight(points[i]) * r * r;
    }
    return sum;
  }

  Result<Normal> normal(double mu, double offset) const {
    auto here = curve.at(mu, offset);
    auto stiffer = curve.at(mu * (1 + kStep), offset);
    auto later = curve.at(mu, offset + kStep * scale_Pa);
    auto sooner = curve.at(mu, offset - kStep * scale_Pa);
    for (const auto* r : {&here, &stiffer, &later, &sooner}) {
      if (!*r) {
        return fail(r->error());
      }
    }
    Normal n;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double w = weight(points[i]);
      const double d0 = ((*stiffer)[i] - (*here)[i]) / kStep;
      const double d1 = ((*later)[i] - (*sooner)[i]) / (2 * kStep);
      const double r = points[i].delta_capacitance_F - (*here)[i];
      n.a00 += w * d0 * d0;
      n.a01 += w * d0 * d1;
      n.a11 += w * d1 * d1;
      n.b0 += w * d0 * r;
      n.b1 += w * d1 * r;
      n.chi2 += w * r * r;
    }
    return n;
  }
};

FitValue value_of(double value, double standard_error, double t) {
  return {value, standard_error, value - t * standard_error, value + t * standard_error};
}

Fit summarize(const Fitter& fitter, const Normal& n, double mu, double offset, int iterations) {
  Fit fit;
  fit.points = static_cast<int>(fitter.points.size());
  fit.iterations = iterations;
  const int freedom = fit.points - 2;
  const double t = student_t975(freedom);
  const double scatter = n.chi2 / freedom;
  const double c00 = n.a11 / n.determinant(), c11 = n.a00 / n.determinant();
  fit.shear_modulus_Pa = value_of(mu, mu * std::sqrt(c00 * scatter), t);
  fit.contact_offset_Pa = value_of(offset, fitter.scale_Pa * std::sqrt(c11 * scatter), t);
  fit.correlation = -n.a01 / std::sqrt(n.a00 * n.a11);
  double weights = 0;
  for (const auto& p : fitter.points) {
    weights += fitter.weight(p);
  }
  fit.residual_F = std::sqrt(n.chi2 / weights);
  return fit;
}

// One Gauss-Newton step, halved until it improves; returns its relative length.
Result<double> improve(const Fitter& fitter, const Normal& n, double& mu, double& offset) {
  const double d0 = (n.a11 * n.b0 - n.a01 * n.b1) / n.determinant();
  const double d1 = (n.a00 * n.b1 - n.a01 * n.b0) / n.determinant();
  for (double length = 1; length > 1e-4; length /= 2) {
    const double next_mu = mu * std::exp(std::clamp(length * d0, -1.0, 1.0));
    const double next_offset = offset + length * d1 * fitter.scale_Pa;
    const auto chi2 = fitter.chi2(next_mu, next_offset);
    if (chi2 && *chi2 <= n.chi2 * (1 + 1e-12)) {
      mu = next_mu;
      offset = next_offset;
      return length * (std::abs(d0) + std::abs(d1));
    }
  }
  return 0.0;  // at the minimum as far as rounding can tell
}

}  // namespace

double student_t975(int degrees_of_freedom) {
  constexpr std::array kTable{12.706, 4.303, 3.182, 2.776, 2.571,
                              2.447,  2.365, 2.306, 2.262, 2.228};
  if (degrees_of_freedom <= static_cast<int>(kTable.size())) {
    return kTable[static_cast<std::size_t>(std::max(degrees_of_freedom, 1) - 1)];
  }
  constexpr double z = 1.959964;  // Cornish and Fisher's expansion in 1/n
  const double n = degrees_of_freedom, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * n * n * n);
}

Result<Fit> fit_response(const Specimen& specimen, const LevelSettings& settings,
                         const std::vector<FitPoint>& points) {
  if (auto ok = check_specimen(specimen); !ok) {
    return fail(ok.error());
  }
  if (points.size() < 4) {
    return fail(Errc::invalid_request, "fit: {} points, at least 4 are needed", points.size());
  }
  const auto soft = find_soft(specimen);
  if (!soft) {
    return fail(soft.error());
  }
  double highest = 0;
  for (const auto& p : points) {
    if (!std::isfinite(p.pressure_Pa) || !std::isfinite(p.delta_capacitance_F)) {
      return fail(Errc::invalid_request, "fit: a point is not a number");
    }
    highest = std::max(highest, p.pressure_Pa);
  }
  const Curve2 curve(specimen, settings, *soft, points);
  const Fitter fitter{curve, points, std::max(highest, 1.0)};
  double mu = specimen.materials[*soft].shear_modulus_Pa();
  double offset = 0;
  for (int i = 1; i <= kMostIterations; ++i) {
    const auto n = fitter.normal(mu, offset);
    if (!n) {
      return fail(n.error());
    }
    if (!(n->determinant() > 1e-20 * n->a00 * n->a11)) {
      break;
    }
    const auto length = improve(fitter, *n, mu, offset);
    if (length && *length < 1e-9) {
      return summarize(fitter, *n, mu, offset, i);
    }
  }
  return fail(Errc::invalid_request,
              "fit: no convergence; the points do not determine modulus and offset together");
}

}  // namespace lcrig
