// SPDX-License-Identifier: Apache-2.0
#include "model/level.hpp"

#include <cmath>

#include "model/bonded.hpp"
#include "model/fem_levels.hpp"
#include "model/level_parts.hpp"

namespace lcrig {
namespace {

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

Result<double> bonded_layer_strain(const Material& m, double shape_factor, Pressure pressure,
                                   bool nonlinear) {
  const double linear_mu = m.youngs_modulus_Pa / (2 * (1 + m.poisson_ratio));
  if (!nonlinear) {
    const double strain =
        pressure.si() / bonded_modulus_Pa(linear_mu, m.poisson_ratio, shape_factor);
    if (strain >= 1) {
      return fail(Errc::invalid_request, "bonded: {} kPa would close a layer of {}",
                  pressure.si() / 1e3, m.name);
    }
    return strain;
  }
  return bonded_strain(Pressure::from_si(m.shear_modulus_Pa()), m.poisson_ratio, shape_factor,
                       pressure);
}

Result<> check_applies(const Specimen& s, const LevelSettings& settings) {
  const Level level = settings.level;
  if (level == Level::bonded && s.faces != Faces::bonded_laminate) {
    return fail(Errc::invalid_request,
                "specimen {}: level `bonded` needs faces `bonded_laminate`, not `{}`", s.name,
                to_string(s.faces));
  }
  if (level != Level::hyperelastic && settings.form != EnergyForm::a) {
    return fail(Errc::invalid_request,
                "level `{}` knows strain-energy form A only; the others belong to `hyperelastic`",
                to_string(level));
  }
  if (level != Level::hyperelastic && settings.lateral == Lateral::confined) {
    return fail(Errc::invalid_request, "`confined` belongs to level `hyperelastic`, not to `{}`",
                to_string(level));
  }
  if (level < Level::fem_linear && settings.electrode_area == ElectrodeArea::deformed) {
    return fail(Errc::invalid_request,
                "level `{}` has no deformed electrode; take a finite-element level",
                to_string(level));
  }
  return {};
}

Result<std::unique_ptr<LevelModel>> make_bonded(const Specimen& specimen, bool nonlinear) {
  const double radius = specimen.disc_diameter_m / 2;
  return make_layered_model(specimen, [radius, nonlinear](const Material& m, double t, Pressure p) {
    return bonded_layer_strain(m, radius / (2 * t), p, nonlinear);
  });
}

Result<std::unique_ptr<LevelModel>> make_plain(const Specimen& specimen,
                                               const LevelSettings& settings) {
  switch (settings.level) {
    case Level::linear:
      return make_layered_model(
          specimen, [](const Material& m, double, Pressure p) { return linear_strain(m, p); });
    case Level::hyperelastic:
      return make_layered_model(specimen, [settings](const Material& m, double, Pressure p) {
        return hyperelastic_strain(m, p, settings);
      });
    case Level::bonded: return make_bonded(specimen, settings.nonlinear);
    case Level::fem_linear: return make_fem_linear(specimen, settings);
    case Level::fem_finite: return make_fem_finite(specimen, settings);
  }
  return fail(Errc::bug, "unknown level");
}

}  // namespace

double delta_capacitance_F(double c0_F, double gap_m, double closing_m) {
  return c0_F * closing_m / (gap_m - closing_m);
}

Result<std::unique_ptr<LevelModel>> make_level_model(const Specimen& specimen,
                                                     const LevelSettings& settings) {
  if (auto ok = check_specimen(specimen); !ok) return fail(ok.error());
  if (auto ok = check_applies(specimen, settings); !ok) return fail(ok.error());
  auto model = make_plain(specimen, settings);
  if (model && settings.fringe) model = with_fringe(specimen, std::move(*model));
  if (model && specimen.contact_gap) return with_contact_gap(specimen, std::move(*model));
  return model;
}

Result<> check_pressure(Pressure pressure) {
  if (!std::isfinite(pressure.si()) || pressure.si() < 0) {
    return fail(Errc::invalid_request, "pressure {} Pa must be finite and compressive (>= 0)",
                pressure.si());
  }
  return {};
}

}  // namespace lcrig
