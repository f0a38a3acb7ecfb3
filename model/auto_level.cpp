// SPDX-License-Identifier: Apache-2.0
#include "model/auto_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace lcrig {
namespace {

// Kirchhoff's edge correction for a disc capacitor whose dielectric ends at the rim (the air part
// of the fringe only), relative to C0. Good to 10 % up to a gap of an eighth of the radius.
double fringe_size(const Specimen& s) {
  double worst = 0;
  for (const auto& capacitor : s.capacitors) {
    double d = 0;
    for (const auto& layer : capacitor.layers) {
      d += layer.thickness_m;
    }
    const double a = s.disc_diameter_m / 2;
    const double kirchhoff =
        d / (std::numbers::pi * a) * (std::log(16 * std::numbers::pi * a / d) - 1);
    worst = std::max(worst, kirchhoff * s.dielectric_gap_m(capacitor) / d);
  }
  return worst;
}

// What the closing would gain if rigid layers were as soft as polyimide (2.5 GPa, nu 0.34).
double film_strain_size(const Specimen& s, Pressure pressure, double delta_F) {
  constexpr double kFilmModulus_Pa = 2.5e9 * (1 - 0.34) / ((1 + 0.34) * (1 - 2 * 0.34));
  double gain = 0;
  for (const auto& capacitor : s.capacitors) {
    double closing = 0;
    for (const auto& layer : capacitor.layers) {
      const auto& m = s.material(layer);
      closing += m.rigid ? layer.thickness_m / m.relative_permittivity : 0;
    }
    closing *= pressure.si() / kFilmModulus_Pa;
    gain += s.c0_F(capacitor) * closing / s.dielectric_gap_m(capacitor);
  }
  return delta_F > 0 ? gain / delta_F : 0;
}

Result<double> delta_at(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  auto model = make_level_model(s, settings);
  if (!model) {
    return fail(model.error());
  }
  auto state = (*model)->at_pressure(pressure);
  if (!state) {
    return fail(state.error());
  }
  return state->delta_capacitance_F;
}

std::vector<Omission> list_omissions(const Specimen& s, Pressure pressure, double delta_F) {
  LevelSettings held;
  held.lateral = Lateral::confined;
  const auto confined = delta_at(s, held, pressure);
  std::vector<Omission> list;
  list.push_back({"fringe field", fringe_size(s),
                  "of C0, Kirchhoff's formula with the dielectric ending at the rim; nearly "
                  "constant under load"});
  list.push_back({"strain of rigid films", film_strain_size(s, pressure, delta_F),
                  "of delta C, if they were polyimide of 2.5 GPa"});
  if (s.faces == Faces::free && confined && delta_F > 0) {
    list.push_back({"lateral friction", 1 - *confined / delta_F,
                    "of delta C, at most: if the faces did not slide at all"});
  }
  list.push_back({"viscosity", 0.04, "of delta C over 10 s; assumed, no source for this material"});
  list.push_back({"electrode stiffness", 0, "printed electrodes have no thickness in the model"});
  return list;
}

}  // namespace

Result<LevelChoice> choose_level(const Specimen& specimen, double tolerance,
                                 Pressure max_pressure) {
  if (!(tolerance > 0) || !(max_pressure.si() > 0)) {
    return fail(Errc::invalid_request, "tolerance {} and largest pressure {} Pa must be positive",
                tolerance, max_pressure.si());
  }
  if (auto ok = check_specimen(specimen); !ok) {
    return fail(ok.error());
  }
  if (specimen.faces != Faces::free) {
    return fail(Errc::invalid_request, "specimen {}: no level here describes faces `{}`",
                specimen.name, to_string(specimen.faces));
  }
  LevelChoice choice;
  const auto best = delta_at(specimen, choice.settings, max_pressure);
  if (!best) {
    return fail(best.error());
  }
  choice.left_out = list_omissions(specimen, max_pressure, *best);
  LevelSettings linear;
  linear.level = Level::linear;
  const auto simple = delta_at(specimen, linear, max_pressure);
  const double error = simple && *best > 0 ? std::abs(*simple / *best - 1) : 1;
  if (error <= tolerance) {
    choice.settings = linear;
    choice.error_estimate = error;
    choice.reason = fmt::format("free faces, linear within {:.2g} of hyperelastic", error);
  } else {
    choice.error_estimate = 1e-13;
    choice.reason =
        fmt::format("free faces: hyperelastic is exact there; linear would err by {:.2g} at {} kPa",
                    error, max_pressure.si() / 1e3);
  }
  return choice;
}

nlohmann::json to_json(const LevelChoice& choice) {
  nlohmann::json left_out = nlohmann::json::array();
  for (const auto& o : choice.left_out) {
    left_out.push_back(
        {{"effect", o.effect}, {"relative_size", o.relative_size}, {"note", o.note}});
  }
  return {{"level", to_string(choice.settings.level)},
          {"form", to_string(choice.settings.form)},
          {"pressure_kind", to_string(choice.settings.pressure_kind)},
          {"error_estimate", choice.error_estimate},
          {"reason", choice.reason},
          {"left_out", left_out}};
}

std::string to_text(const LevelChoice& choice) {
  std::string text =
      fmt::format("level {}: {}\n  estimated error {:.2g}; left out:\n",
                  to_string(choice.settings.level), choice.reason, choice.error_estimate);
  for (const auto& o : choice.left_out) {
    text += fmt::format("  {:24} {:8.2g}  {}\n", o.effect, o.relative_size, o.note);
  }
  return text;
}

}  // namespace lcrig
