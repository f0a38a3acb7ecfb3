// SPDX-License-Identifier: Apache-2.0
#include "model/specimen_figures.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "model/specimen_stiffness.hpp"

namespace lcrig {

namespace {

// Of the softest modulus: a load that is small for every layer.
constexpr double kSmallStrain = 1e-4;

std::optional<double> stiffness_N_m(const Specimen& s) {
  double softest_Pa = 0;
  for (const Capacitor& c : s.capacitors) {
    for (const Layer& layer : c.layers) {
      const Material& m = s.material(layer);
      if (m.rigid) continue;
      if (softest_Pa == 0 || m.youngs_modulus_Pa < softest_Pa) softest_Pa = m.youngs_modulus_Pa;
    }
  }
  if (softest_Pa == 0) return std::nullopt;
  const double force_N = kSmallStrain * softest_Pa * s.area_m2();
  const auto way_m = expected_compression(s, Force::from_si(force_N), std::nullopt);
  if (!way_m || !(way_m(force_N) > 0)) return std::nullopt;
  return force_N / way_m(force_N);
}

}  // namespace

SpecimenFigures figures_of(const Specimen& s) {
  SpecimenFigures out;
  out.c0_F = s.c0_F();
  out.disc_diameter_m = s.disc_diameter_m;
  out.area_m2 = s.area_m2();
  out.capacitors = s.capacitors.size();
  out.layers = s.layer_count();
  out.top = s.top;
  for (const Capacitor& c : s.capacitors) {
    for (const Layer& layer : c.layers) {
      out.thickness_m += layer.thickness_m;
      if (!s.material(layer).rigid) out.soft_thickness_m += layer.thickness_m;
    }
  }
  out.stiffness_N_m = stiffness_N_m(s);
  return out;
}

std::string to_text(const SpecimenFigures& f) {
  const std::string stiffness =
      f.stiffness_N_m          ? fmt::format("{:.4g} N/mm at small loads", *f.stiffness_N_m * 1e-3)
      : f.soft_thickness_m > 0 ? std::string("only finite elements know it: lcrig model curve")
                               : std::string("rigid");
  return fmt::format(
      "  C0            {:.5g} pF ({} in parallel)\n"
      "  thickness     {:.6g} um in {} layers, {:.6g} um of it soft\n"
      "  stiffness     {}\n"
      "  pressed area  {:.4g} mm2: the disc of {:.6g} mm, top {}\n",
      f.c0_F * 1e12, f.capacitors, f.thickness_m * 1e6, f.layers, f.soft_thickness_m * 1e6,
      stiffness, f.area_m2 * 1e6, f.disc_diameter_m * 1e3, to_string(f.top));
}

nlohmann::json to_json(const SpecimenFigures& f) {
  return {{"C0_pF", f.c0_F * 1e12},
          {"capacitors", f.capacitors},
          {"layers", f.layers},
          {"thickness_um", f.thickness_m * 1e6},
          {"soft_thickness_um", f.soft_thickness_m * 1e6},
          {"stiffness_N_per_mm",
           f.stiffness_N_m ? nlohmann::json(*f.stiffness_N_m * 1e-3) : nlohmann::json()},
          {"disc_diameter_mm", f.disc_diameter_m * 1e3},
          {"pressed_area_mm2", f.area_m2 * 1e6},
          {"top", to_string(f.top)}};
}

}  // namespace lcrig
