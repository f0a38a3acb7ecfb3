// SPDX-License-Identifier: Apache-2.0
#include "model/specimen.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace lcrig {
namespace {

constexpr std::size_t kMostLayers = 1000;

bool positive(double value) {
  return std::isfinite(value) && value > 0;
}

// No solid lies outside these limits. Within them no product or quotient of two moduli leaves the
// range of numbers.
bool sensible_modulus(double value_Pa) {
  return value_Pa >= 1e-3 && value_Pa <= 1e15;
}

Result<> check_material(const Material& m) {
  if (!std::isfinite(m.relative_permittivity) || m.relative_permittivity < 1) {
    return fail(Errc::invalid_request, "material {}: relative permittivity {} must be at least 1",
                m.name, m.relative_permittivity);
  }
  if (m.rigid) return {};
  if (!sensible_modulus(m.youngs_modulus_Pa)) {
    return fail(Errc::invalid_request, "material {}: Young's modulus {} Pa must be 1e-3 to 1e15 Pa",
                m.name, m.youngs_modulus_Pa);
  }
  if (!(m.poisson_ratio >= 0 && m.poisson_ratio <= 0.5)) {
    return fail(Errc::invalid_request, "material {}: Poisson ratio {} must be in 0 to 0.5", m.name,
                m.poisson_ratio);
  }
  if (m.given_shear_modulus_Pa && !sensible_modulus(*m.given_shear_modulus_Pa)) {
    return fail(Errc::invalid_request, "material {}: shear modulus {} Pa must be 1e-3 to 1e15 Pa",
                m.name, *m.given_shear_modulus_Pa);
  }
  return {};
}

Result<> check_capacitor(const Specimen& s, std::size_t index) {
  const auto& layers = s.capacitors[index].layers;
  if (layers.empty()) {
    return fail(Errc::invalid_request, "specimen {}: capacitor {} has no layers", s.name,
                index + 1);
  }
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].material >= s.materials.size()) {
      return fail(Errc::invalid_request, "specimen {}: capacitor {}, layer {}: unknown material",
                  s.name, index + 1, i + 1);
    }
    if (!positive(layers[i].thickness_m)) {
      return fail(Errc::invalid_request,
                  "specimen {}: capacitor {}, layer {}: thickness {} m must be positive", s.name,
                  index + 1, i + 1, layers[i].thickness_m);
    }
  }
  return {};
}

}  // namespace

double Material::shear_modulus_Pa() const {
  return given_shear_modulus_Pa.value_or(youngs_modulus_Pa / (2 * (1 + poisson_ratio)));
}

double Specimen::area_m2() const {
  return std::numbers::pi / 4 * disc_diameter_m * disc_diameter_m;
}

bool Specimen::is_soft(const Material& material) const {
  constexpr double kFilmContrast = 100;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& capacitor : capacitors) {
    for (const auto& layer : capacitor.layers) {
      const Material& m = this->material(layer);
      least = m.rigid ? least : std::min(least, m.youngs_modulus_Pa);
    }
  }
  return !material.rigid && material.youngs_modulus_Pa < kFilmContrast * least;
}

double Specimen::dielectric_gap_m(const Capacitor& capacitor) const {
  double gap = 0;
  for (const auto& layer : capacitor.layers) {
    gap += layer.thickness_m / material(layer).relative_permittivity;
  }
  return gap;
}

double Specimen::c0_F(const Capacitor& capacitor) const {
  return kVacuumPermittivity_F_m * area_m2() / dielectric_gap_m(capacitor);
}

double Specimen::c0_F() const {
  double sum = 0;
  for (const auto& capacitor : capacitors) sum += c0_F(capacitor);
  return sum;
}

std::size_t Specimen::layer_count() const {
  std::size_t count = 0;
  for (const auto& capacitor : capacitors) count += capacitor.layers.size();
  return count;
}

void put_disc(const Specimen& specimen, PressureArea& pressure) {
  pressure.disc_diameter_m = specimen.disc_diameter_m;
  pressure.plate = specimen.top != Top::pressure;
}

Result<> check_specimen(const Specimen& s) {
  if (!positive(s.disc_diameter_m)) {
    return fail(Errc::invalid_request, "specimen {}: disc diameter {} m must be positive", s.name,
                s.disc_diameter_m);
  }
  if (s.capacitors.empty()) {
    return fail(Errc::invalid_request, "specimen {}: no capacitors", s.name);
  }
  if (s.layer_count() > kMostLayers) {
    return fail(Errc::invalid_request, "specimen {}: {} layers, at most {} are allowed", s.name,
                s.layer_count(), kMostLayers);
  }
  for (const auto& material : s.materials) {
    if (auto ok = check_material(material); !ok) return ok;
  }
  if (s.contact_gap &&
      !(positive(s.contact_gap->height_m) && positive(s.contact_gap->half_pressure_Pa))) {
    return fail(Errc::invalid_request, "specimen {}: contact gap must have positive sizes", s.name);
  }
  if (s.creep && !(positive(s.creep->fraction) && positive(s.creep->time_s))) {
    return fail(Errc::invalid_request, "specimen {}: creep must have positive sizes", s.name);
  }
  for (std::size_t i = 0; i < s.capacitors.size(); ++i) {
    if (auto ok = check_capacitor(s, i); !ok) return ok;
  }
  return {};
}

}  // namespace lcrig
