// SPDX-License-Identifier: Apache-2.0
#include "model/error_estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lcrig {
namespace {

constexpr double kOneDimensional = 1e-13;  // hyperelastic with free faces: rounding

Result<StackState> state_at(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  auto model = make_level_model(s, settings);
  if (!model) {
    return fail(model.error());
  }
  return (*model)->at_pressure(pressure);
}

LevelSettings at_level(Level level) {
  LevelSettings settings;
  settings.level = level;
  return settings;
}

double relative(double value, double reference) {
  return reference > 0 ? std::abs(value / reference - 1) : 0;
}

// Radius over twice the thickness of the thickest layer that strains much, and its Poisson ratio.
struct Softest {
  double shape_factor = 1e9, poisson_ratio = 0, thickness_m = 0, mismatch = 0;
  double capacitor_m = 0;  // thickness of the thickest capacitor
  bool films_bend = false;
};
Softest find_softest(const Specimen& s) {
  Softest result;
  double least = 1e300;
  for (const auto& m : s.materials) {
    least = m.rigid ? least : std::min(least, m.youngs_modulus_Pa);
  }
  for (const auto& capacitor : s.capacitors) {
    double total = 0;
    for (const auto& layer : capacitor.layers) {
      const Material& m = s.material(layer);
      total += layer.thickness_m;
      if (m.rigid) {
        continue;
      }
      if (m.youngs_modulus_Pa > 100 * least) {
        result.films_bend = true;
        continue;
      }
      result.thickness_m += layer.thickness_m;
      result.shape_factor =
          std::min(result.shape_factor, s.disc_diameter_m / (4 * layer.thickness_m));
      result.poisson_ratio = std::max(result.poisson_ratio, m.poisson_ratio);
      const double consistent = 2 * m.shear_modulus_Pa() * (1 + m.poisson_ratio);
      result.mismatch = std::max(result.mismatch, relative(consistent, m.youngs_modulus_Pa));
    }
    result.capacitor_m = std::max(result.capacitor_m, total);
  }
  const auto& top = s.material(s.capacitors.back().layers.back());
  result.films_bend = result.films_bend || (!top.rigid && s.top == Top::pressure);
  return result;
}

Result<double> free_error(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  auto exact = state_at(s, at_level(Level::hyperelastic), pressure);
  auto mine = state_at(s, settings, pressure);
  if (!exact || !mine) {
    return fail(exact ? mine.error() : exact.error());
  }
  return relative(mine->delta_capacitance_F, exact->delta_capacitance_F) + kOneDimensional;
}

// What small-strain elasticity misses at this pressure.
Result<double> nonlinearity(const Specimen& s, Pressure pressure) {
  if (s.faces == Faces::bonded_laminate) {
    LevelSettings straight = at_level(Level::bonded);
    straight.nonlinear = false;
    auto linear = state_at(s, straight, pressure);
    auto bent = state_at(s, at_level(Level::bonded), pressure);
    if (!linear || !bent) {
      return fail(linear ? bent.error() : linear.error());
    }
    return 1.3 * relative(linear->delta_capacitance_F, bent->delta_capacitance_F);
  }
  LevelSettings coarse = at_level(Level::fem_linear);
  coarse.mesh.refinement = 0;
  auto state = state_at(s, coarse, pressure);
  if (!state) {
    return fail(state.error());
  }
  const Softest soft = find_softest(s);
  return 2 * state->shortening_m / soft.thickness_m + soft.mismatch;
}

// Mean strain, for the strain-dependent part of the corner error.
double mean_strain(const Specimen& s, Pressure pressure) {
  LevelSettings coarse = at_level(Level::fem_linear);
  coarse.mesh.refinement = 0;
  const auto state = state_at(s, coarse, pressure);
  const Softest soft = find_softest(s);
  return state ? std::min(state->shortening_m / soft.thickness_m, 1.0) : 1.0;
}

}  // namespace

double bonded_modulus_error(double nu, double shape_factor) {
  return std::min(0.03, 0.105 * std::pow(2 * nu, 6) / shape_factor);
}

double mesh_error(const Specimen& s, int refinement) {
  if (s.faces == Faces::free) {
    return 1e-10;  // uniform strains
  }
  const bool alone = s.materials.size() == 1;
  constexpr std::array<double, 4> kLaminate{3e-4, 8e-5, 2.5e-5, 8e-6};
  constexpr std::array<double, 4> kAlone{6e-4, 1.5e-4, 3e-5, 1e-5};
  const auto i = static_cast<std::size_t>(std::clamp(refinement, 0, 3));
  return alone ? kAlone[i] : kLaminate[i];
}

Result<double> estimate_error(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  if (s.faces == Faces::free) {
    return free_error(s, settings, pressure);
  }
  const Softest soft = find_softest(s);
  switch (settings.level) {
    case Level::linear:
    case Level::hyperelastic:
      return fail(Errc::invalid_request,
                  "specimen {}: level `{}` needs faces `free`: bonded faces make it err by tens",
                  s.name, to_string(settings.level));
    case Level::bonded: {
      auto bent = settings.nonlinear ? Result<double>(0.0) : nonlinearity(s, pressure);
      if (!bent) {
        return bent;
      }
      const double films = soft.films_bend ? soft.capacitor_m / s.disc_diameter_m : 0;
      return *bent + bonded_modulus_error(soft.poisson_ratio, soft.shape_factor) + films;
    }
    case Level::fem_linear: {
      auto bent = nonlinearity(s, pressure);
      return bent ? Result<double>(*bent + mesh_error(s, settings.mesh.refinement)) : bent;
    }
    case Level::fem_finite:
      return mesh_error(s, settings.mesh.refinement) + 0.01 * mean_strain(s, pressure);
  }
  return fail(Errc::bug, "unknown level");
}

}  // namespace lcrig
