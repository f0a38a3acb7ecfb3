// SPDX-License-Identifier: Apache-2.0
#include "model/bonded.hpp"

#include <array>
#include <cmath>

#include "model/stretch.hpp"

namespace lcrig {
namespace {

constexpr double kAsymptoticFrom = 60;

// With s_n = I_{n+1}/(x I_n) the recurrence of Bessel functions is s_n = 1/(2n + 2 + x^2 s_{n+1}).
// Run downwards, it forgets the value it started from.
double by_recurrence(double x) {
  const int start = 24 + static_cast<int>(1.2 * x);
  double s = 1.0 / (2 * start + 2 + x);
  double above = s;
  for (int n = start - 1; n >= 0; --n) {
    above = s;
    s = 1 / (2 * n + 2 + x * x * s);
  }
  return 8 * s * above;
}

// I1/I0 = sum c_k x^-k from its Riccati equation r' = 1 - r/x - r^2.
double by_asymptotics(double x) {
  constexpr std::size_t kTerms = 12;
  std::array<double, kTerms> c{1, -0.5};
  double ratio = 1 - 0.5 / x;
  double power = 1 / x;
  for (std::size_t k = 2; k < kTerms; ++k) {
    double sum = static_cast<double>(k - 2) * c[k - 1];
    for (std::size_t i = 1; i < k; ++i) sum -= c[i] * c[k - i];
    c[k] = sum / 2;
    power /= x;
    ratio += c[k] * power;
  }
  return (1 - 2 * ratio / x) * 8 / (x * x);
}

}  // namespace

double bessel_bulge(double x) {
  return x < kAsymptoticFrom ? by_recurrence(x) : by_asymptotics(x);
}

// E_a = (lambda+2mu) - 2 lambda^2 I1/((lambda+2mu) x I0 - 2 mu I1), x = alpha a. It is written with
// delta = I2/I0 = 1 - 2 I1/(x I0) and m = mu/lambda, because then every term is positive and m = 0
// is allowed.
double bonded_modulus_Pa(double mu, double nu, double shape_factor) {
  const double s2 = shape_factor * shape_factor;
  if (nu == 0) {
    return 2 * mu;  // without lateral contraction the bond has no effect
  }
  const double m = (1 - 2 * nu) / (2 * nu);
  const double x = std::sqrt(48 * s2 * m / (1 + 2 * m));
  const double lambda_delta = 6 * s2 * bessel_bulge(x) / (1 + 2 * m);  // divided by mu
  return mu * (3 + 2 * m + lambda_delta * (1 + m + 2 * m * m)) / (1 + m + m * m * lambda_delta);
}

Result<double> bonded_strain(Pressure shear_modulus, double nu, double shape_factor,
                             Pressure pressure) {
  const auto held = solve_stretch(shear_modulus, nu, EnergyForm::a, Lateral::confined,
                                  PressureKind::dead, pressure);
  if (!held) return fail(held.error());
  const double mu = shear_modulus.si();
  const double apparent = bonded_modulus_Pa(mu, nu, shape_factor);
  if (nu == 0.5) return pressure.si() / apparent;
  const double confined = mu * (2 + 2 * nu / (1 - 2 * nu));
  const double strain = held->strain * confined / apparent;
  if (strain >= 1) {
    return fail(Errc::invalid_request,
                "bonded: {} kPa would close the layer; use a finite-element level",
                pressure.si() / 1e3);
  }
  return strain;
}

}  // namespace lcrig
