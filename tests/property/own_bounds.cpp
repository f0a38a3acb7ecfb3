// SPDX-License-Identifier: Apache-2.0
#include "tests/property/own_bounds.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

namespace lcrig::property {

namespace {

// The root of a rising function, by bisection.
template <class F>
double root(double low, double high, F f) {
  for (int i = 0; i < 200 && high - low > 1e-15 * std::abs(high); ++i) {
    const double middle = (low + high) / 2;
    (f(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

OwnContact::OwnContact(const sim::RandomRig& rig) : frame_N_m_(rig.frame_stiffness_N_m) {
  bounded_ = frame_N_m_.has_value();
  if (rig.specimen_text.empty()) return;
  const auto file = nlohmann::json::parse(rig.specimen_text);
  const auto& material = file.at("materials").at("m");
  if (material.contains("rigid")) return;
  bounded_ = true;
  poisson_ = material.at("poisson_ratio");
  shear_Pa_ = material.at("youngs_modulus_kPa").get<double>() * 1e3 / (2 * (1 + poisson_));
  const double diameter_m = file.at("disc_diameter_mm").get<double>() * 1e-3;
  area_m2_ = std::numbers::pi / 4 * diameter_m * diameter_m;
  for (const auto& layer : file.at("capacitors").at(0).at("layers")) {
    thickness_m_ += layer.at("thickness_mm").get<double>() * 1e-3;
  }
}

// W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2 with J = stretch: the pressure is
// mu (1/l - l) - lambda ln(l)/l.
double OwnContact::layers_m(double force_N) const {
  if (thickness_m_ <= 0) return 0;
  const double lame_Pa = 2 * shear_Pa_ * poisson_ / (1 - 2 * poisson_);
  const double pressure_Pa = force_N / area_m2_;
  const double strain = root(0.0, 1.0, [&](double e) {
    const double l = 1 - e;
    return shear_Pa_ * (1 / l - l) - lame_Pa * std::log1p(-e) / l - pressure_Pa;
  });
  return strain * thickness_m_;
}

double OwnContact::way_m(double force_N) const {
  return layers_m(force_N) + (frame_N_m_ ? force_N / *frame_N_m_ : 0);
}

double OwnContact::force_after_N(double force_N, double way) const {
  if (!bounded_) return std::numeric_limits<double>::infinity();
  const double target_m = way_m(force_N) + way;
  double high = 2 * force_N + 1e-6;
  while (way_m(high) < target_m && high < 1e9) high *= 2;
  return root(force_N, high, [&](double f) { return way_m(f) - target_m; });
}

double OwnContact::stiffness_N_m(double force_N) const {
  const double d = std::max(1e-4 * force_N, 1e-6);
  return 2 * d / (way_m(force_N + d) - way_m(std::max(force_N - d, 0.0)));
}

// Incompressible, uniaxial stress: the pressure is E/3 (1/l^2 - l).
double OwnContact::generous_way_m(double force_N) const {
  const double frame_m = frame_N_m_ ? force_N / *frame_N_m_ : 0;
  if (thickness_m_ <= 0) return 2 * frame_m;
  const double third_Pa = 2 * shear_Pa_ * (1 + poisson_) / 3, pressure_Pa = force_N / area_m2_;
  const double strain = root(0.0, 1.0, [&](double e) {
    const double l = 1 - e;
    return third_Pa * (1 / (l * l) - l) - pressure_Pa;
  });
  return 2 * (strain * thickness_m_ + frame_m);
}

double own_stopping_way_m(const sim::RandomRig& rig, double speed_m_s) {
  const FrameCapabilities& c = rig.declared();
  const double tau_s = to_seconds(c.reaction) + (c.device_stop ? 0 : 0.02);
  return speed_m_s * tau_s + speed_m_s * speed_m_s / (2 * c.deceleration.si());
}

double own_speed_m_s(const sim::RandomRig& rig, double way_m) {
  return root(0.0, 1.0, [&](double v) { return own_stopping_way_m(rig, v) - way_m; });
}

double own_fastest_m_s(const sim::RandomRig& rig, double from_N, double to_N) {
  const OwnContact contact(rig);
  if (!contact.is_bounded() || to_N <= from_N) return 0;
  return own_speed_m_s(rig, contact.way_m(to_N) - contact.way_m(from_N));
}

double own_uncertainty_N(const sim::RandomRig& rig, double limit_N) {
  const double part = rig.force_class_percent / 100;
  return part * limit_N + part / 10 * rig.declared().force_max.si() + 4 * rig.plant.force_noise_N;
}

double own_lost_way_m(const sim::RandomRig& rig, double speed_m_s) {
  return 1.02 * speed_m_s + own_stopping_way_m(rig, speed_m_s);
}

}  // namespace lcrig::property
