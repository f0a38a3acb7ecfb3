// SPDX-License-Identifier: Apache-2.0
#include "model/level.hpp"

#include <array>
#include <cmath>

#include "model/layered.hpp"

namespace lcrig {
namespace {

constexpr std::array kLevelNames{"linear", "hyperelastic"};

Result<double> linear_strain(const Material& m, Pressure pressure) {
  const double strain = pressure.si() / m.youngs_modulus_Pa;
  if (strain >= 1) {
    return fail(Errc::invalid_request,
                "linear: {} kPa is not below Young's modulus of {} ({} kPa): the spring law has "
                "closed the layer; use a finite-strain level",
                pressure.si() / 1e3, m.name, m.youngs_modulus_Pa / 1e3);
  }
  return strain;
}

Result<double> hyperelastic_strain(const Material& m, Pressure pressure,
                                   const LevelSettings& settings) {
  auto stretch = solve_stretch(Pressure::from_si(m.shear_modulus_Pa()), m.poisson_ratio,
                               settings.form, settings.lateral, settings.pressure_kind, pressure);
  if (!stretch) {
    return fail(stretch.error().code, "hyperelastic, {}: {}", m.name, stretch.error().what);
  }
  return stretch->strain;
}

}  // namespace

std::string_view to_string(Level level) {
  return kLevelNames[static_cast<std::size_t>(level)];
}

std::optional<Level> parse_level(std::string_view text) {
  for (std::size_t i = 0; i < kLevelNames.size(); ++i) {
    if (text == kLevelNames[i]) {
      return static_cast<Level>(i);
    }
  }
  return std::nullopt;
}

double delta_capacitance_F(double c0_F, double gap_m, double closing_m) {
  return c0_F * closing_m / (gap_m - closing_m);
}

Result<std::unique_ptr<LevelModel>> make_level_model(const Specimen& specimen,
                                                     const LevelSettings& settings) {
  if (auto ok = check_specimen(specimen); !ok) {
    return fail(ok.error());
  }
  switch (settings.level) {
    case Level::linear:
      return make_layered_model(
          specimen, [](const Material& m, double, Pressure p) { return linear_strain(m, p); });
    case Level::hyperelastic:
      return make_layered_model(specimen, [settings](const Material& m, double, Pressure p) {
        return hyperelastic_strain(m, p, settings);
      });
  }
  return fail(Errc::bug, "unknown level");
}

}  // namespace lcrig
