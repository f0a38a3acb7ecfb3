// SPDX-License-Identifier: Apache-2.0
#include "model/auto_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "model/error_estimate.hpp"
#include "model/fringe.hpp"

namespace lcrig {
namespace {

// Of the capacitor with the widest gap, relative to its C0.
double fringe_size(const Specimen& s) {
  double worst = 0;
  for (const auto& capacitor : s.capacitors) {
    double d = 0;
    for (const auto& layer : capacitor.layers) {
      d += layer.thickness_m;
    }
    const double permittivity = d / s.dielectric_gap_m(capacitor);
    worst = std::max(worst, fringe_in_air(d / (s.disc_diameter_m / 2), permittivity));
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
  const auto confined = s.faces == Faces::free ? delta_at(s, held, pressure) : Result<double>(0);
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

namespace {

// Cheapest first; what cannot describe the faces drops out by its error estimate.
std::vector<LevelSettings> candidates(const Specimen& s) {
  std::vector<LevelSettings> list;
  const auto add = [&](Level level, int refinement) {
    LevelSettings settings;
    settings.level = level;
    settings.mesh.refinement = refinement;
    list.push_back(settings);
  };
  if (s.faces == Faces::free) {
    add(Level::linear, 1);
    add(Level::hyperelastic, 1);
    return list;
  }
  if (s.faces == Faces::bonded_laminate) {
    add(Level::bonded, 1);
  }
  for (const Level level : {Level::fem_linear, Level::fem_finite}) {
    for (int refinement = 0; refinement <= (level == Level::fem_finite ? 1 : kFinestMesh);
         ++refinement) {
      add(level, refinement);  // finite strain: finer corners fold over before they help
    }
  }
  return list;
}

std::string name_of(const LevelSettings& settings) {
  std::string name(to_string(settings.level));
  if (settings.level >= Level::fem_linear) {
    name += fmt::format(" (mesh {})", settings.mesh.refinement);
  }
  return name;
}

}  // namespace

Result<LevelChoice> choose_level(const Specimen& specimen, double tolerance,
                                 Pressure max_pressure) {
  if (!(tolerance > 0) || !(max_pressure.si() > 0) || !std::isfinite(max_pressure.si())) {
    return fail(Errc::invalid_request, "tolerance {} and largest pressure {} Pa must be positive",
                tolerance, max_pressure.si());
  }
  if (auto ok = check_specimen(specimen); !ok) {
    return fail(ok.error());
  }
  std::string rejected;
  double least = std::numeric_limits<double>::infinity();
  for (const LevelSettings& settings : candidates(specimen)) {
    const auto error = estimate_error(specimen, settings, max_pressure);
    if (error && *error <= tolerance) {
      LevelChoice choice;
      choice.settings = settings;
      choice.error_estimate = *error;
      choice.reason =
          fmt::format("faces `{}`, up to {:.4g} kPa: {} errs by {:.2g} of the {:.2g} allowed{}{}",
                      to_string(specimen.faces), max_pressure.si() / 1e3, name_of(settings), *error,
                      tolerance, rejected.empty() ? "" : "; cheaper: ", rejected);
      const auto delta = delta_at(specimen, settings, max_pressure);
      choice.left_out = list_omissions(specimen, max_pressure, delta.value_or(0));
      return choice;
    }
    least = std::min(least, error.value_or(least));
    rejected += fmt::format("{}{} {}", rejected.empty() ? "" : ", ", name_of(settings),
                            error ? fmt::format("{:.2g}", *error) : "not applicable");
  }
  return fail(Errc::invalid_request,
              "specimen {}: no level meets a tolerance of {:.2g} at {:.4g} kPa; {:.2g} can be met "
              "(estimated "
              "errors: {})",
              specimen.name, tolerance, max_pressure.si() / 1e3, least * 1.01, rejected);
}

nlohmann::json to_json(const LevelChoice& choice) {
  nlohmann::json left_out = nlohmann::json::array();
  for (const auto& o : choice.left_out) {
    left_out.push_back(
        {{"effect", o.effect}, {"relative_size", o.relative_size}, {"note", o.note}});
  }
  return {{"level", to_string(choice.settings.level)},
          {"mesh", choice.settings.mesh.refinement},
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
