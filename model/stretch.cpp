// SPDX-License-Identifier: Apache-2.0
// With j = ln J as the unknown, every form gives its stretches and pressure in closed form, and at
// no strain is a difference of nearly equal numbers taken. docs/model.md, section "One layer".
#include "model/stretch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcrig {
namespace {

struct Law {
  EnergyForm form;
  Lateral lateral;
  bool dead;
  double lambda;  // first Lame constant over mu
  double bulk;  // bulk modulus over mu
};

struct Loaded {
  double p = 0;  // pressure over mu
  double dp = 0;  // its derivative with respect to j
  double log_z = 0;
  double log_r = 0;
};

bool isochoric_split(EnergyForm form) {
  return form == EnergyForm::b || form == EnergyForm::d;
}

// J U'(J) over mu and its derivative with respect to j; U is the volumetric energy.
struct Volumetric {
  double h, dh;
};
Volumetric volumetric(const Law& law, double j) {
  const double k = isochoric_split(law.form) ? law.bulk : law.lambda;
  switch (law.form) {
    case EnergyForm::b:
    case EnergyForm::c: {
      const double J = std::exp(j);
      return {k * J * std::expm1(j), k * J * (2 * J - 1)};
    }
    case EnergyForm::d:
    case EnergyForm::e: {
      const double g = std::expm1(2 * j);
      return {k / 2 * g, k * (g + 1)};
    }
    default: return {k * j, k};
  }
}

// Forms in mu and lambda: lambda_r^2 = 1 - h follows from zero radial stress.
Loaded free_coupled(const Law& law, double j) {
  const auto [h, dh] = volumetric(law, j);
  const double r = 1 - h;
  const double log_r2 = std::log1p(-h);
  const double log_z = j - log_r2;
  const double z = std::exp(log_z);
  const double dlog_z = 1 + dh / r;
  if (law.dead) {
    return {z * std::expm1(log_r2 - 2 * log_z), -(dh + r * dlog_z) / z - z * dlog_z, log_z,
            log_r2 / 2};
  }
  return {-std::expm1(2 * log_z - log_r2) / z, -dlog_z / z - z / r * (dlog_z + dh / r), log_z,
          log_r2 / 2};
}

// Root w of (1+w)^3 - 1 = d (1+w)^2, d >= 0, to full relative precision. Cardano's root of y = 1+w
// has only positive terms. One Newton step in w restores the digits that y - 1 loses.
double cubic_root(double d) {
  const double d3 = d * d * d / 27;
  const double u = std::cbrt(d3 + 0.5 + std::sqrt(d3 + 0.25));
  const double w = d / 3 + d * d / (9 * u) + (u - 1);
  const double y = 1 + w;
  return w - (w * (3 + w * (3 + w)) - d * y * y) / (3 * y * y - 2 * d * y);
}

// Isochoric forms: with y = (lambda_r/lambda_z)^(2/3), zero radial stress means y - y^-2 = -3 h.
Loaded free_split(const Law& law, double j) {
  const auto [h, dh] = volumetric(law, j);
  const double d = -3 * h;
  const double w = cubic_root(d);
  const double y = 1 + w;
  const double dlog_y = -3 * dh / (y + 2 / (y * y));
  const double log_y = std::log1p(w);
  const double log_z = j / 3 - log_y;
  const double log_r = j / 3 + log_y / 2;
  const double base = law.dead ? std::exp(log_z) : std::exp(j);
  const double dbase = law.dead ? 1.0 / 3 - dlog_y : 1;
  return {d / base, (-3 * dh - d * dbase) / base, log_z, log_r};
}

Loaded confined(const Law& law, double j) {
  const auto [h, dh] = volumetric(law, j);
  const double z = std::exp(j);
  const double g = std::expm1(2 * j);  // lambda^2 - 1
  double tau = g + h;
  double dtau = 2 * (g + 1) + dh;
  if (isochoric_split(law.form)) {
    const double f = 2.0 / 3 * std::exp(-2.0 / 3 * j);
    tau = f * g + h;
    dtau = f * (2 * (g + 1) - 2.0 / 3 * g) + dh;
  }
  return {-tau / z, (tau - dtau) / z, j, 0};
}

Loaded free_incompressible(const Law& law, double log_z) {
  const double z = std::exp(log_z);
  if (law.dead) return {z * std::expm1(-3 * log_z), -2 / (z * z) - z, log_z, -log_z / 2};
  return {-std::expm1(3 * log_z) / z, -1 / z - 2 * z * z, log_z, -log_z / 2};
}

Loaded evaluate(const Law& law, double j) {
  if (law.lateral == Lateral::confined) return confined(law, j);
  if (law.form == EnergyForm::incompressible) return free_incompressible(law, j);
  return isochoric_split(law.form) ? free_split(law, j) : free_coupled(law, j);
}

// Newton's method for ln p over ln x, x = -j, inside a bracket that every evaluation narrows. p
// starts linear in x and grows like a power, so in logarithms both ends are nearly straight.
std::optional<double> find_equilibrium(const Law& law, double target) {
  double below = 0;  // x at which the pressure is too small
  double above = std::numeric_limits<double>::infinity();
  double x = std::min(target / -evaluate(law, 0).dp, 1.0);
  for (int i = 0; i < 200 && x < 300; ++i) {
    const Loaded point = evaluate(law, -x);
    const double excess = (target - point.p) / point.p;
    const double slope = -point.dp * x / point.p;  // d ln p / d ln x
    const double log_step = std::log1p(excess) / slope;
    if (std::abs(log_step) < 1e-8) {
      return x + x * std::expm1(log_step);  // convergence is quadratic, so only rounding remains
    }
    (excess > 0 ? below : above) = x;
    double next = x * std::exp(log_step);
    if (!(next > below && next < above) || slope <= 0) {
      next = std::isinf(above) ? 2 * x : below > 0 ? std::sqrt(below * above) : above / 2;
    }
    x = next;
  }
  return std::nullopt;
}

bool in_range(double mu, double nu, double p) {
  return std::isfinite(mu) && mu > 0 && nu >= 0 && nu <= 0.5 && std::isfinite(p) && p >= 0;
}

}  // namespace

Result<Stretch> solve_stretch(Pressure shear_modulus, double nu, EnergyForm form, Lateral lateral,
                              PressureKind kind, Pressure pressure) {
  const double mu = shear_modulus.si();
  const double p = pressure.si();
  if (!in_range(mu, nu, p)) {
    return fail(Errc::invalid_request,
                "shear modulus {} Pa, Poisson ratio {}, pressure {} Pa: out of range", mu, nu, p);
  }
  if (nu == 0.5) form = EnergyForm::incompressible;
  const bool locked = form == EnergyForm::incompressible && lateral == Lateral::confined;
  if (p == 0 || locked) {
    return Stretch{};  // an incompressible layer that cannot widen does not move
  }
  const double lambda = nu < 0.5 ? 2 * nu / (1 - 2 * nu) : 0;
  const Law law{form, lateral, kind == PressureKind::dead, lambda, lambda + 2.0 / 3};
  const auto x = find_equilibrium(law, p / mu);
  if (!x) {
    return fail(Errc::invalid_request,
                "strain-energy form {} has no equilibrium at {} kPa (shear modulus {} kPa)",
                to_string(form), p / 1e3, mu / 1e3);
  }
  const Loaded point = evaluate(law, -*x);
  return Stretch{-std::expm1(point.log_z), point.log_z, point.log_r,
                 form == EnergyForm::incompressible ? 0 : -*x};
}

}  // namespace lcrig
