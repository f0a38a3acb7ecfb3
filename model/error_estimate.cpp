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

// What of the specimen decides the errors at bonded faces.
struct Softest {
  double shape_factor = 1e9;  // radius over twice the thickness of the thickest soft block
  double poisson_ratio = 0;  // the largest of the soft ones
  double thickness_m = 0;  // of all soft layers
  double mismatch = 0;  // of E against 2 mu (1 + nu): linear and finite levels differ by it
  double capacitor_m = 0;  // thickness of the thickest capacitor
  int blocks = 0;
  bool films_bend = false;
  bool free_face = false;  // the top of the stack is soft and nothing holds it
};

void add_layer(const Specimen& s, const Layer& layer, double block_m, Softest& result) {
  const Material& m = s.material(layer);
  result.thickness_m += layer.thickness_m;
  result.shape_factor = std::min(result.shape_factor, s.disc_diameter_m / (4 * block_m));
  result.poisson_ratio = std::max(result.poisson_ratio, m.poisson_ratio);
  const double consistent = 2 * m.shear_modulus_Pa() * (1 + m.poisson_ratio);
  result.mismatch = std::max(result.mismatch, relative(consistent, m.youngs_modulus_Pa));
}

Softest find_softest(const Specimen& s) {
  Softest result;
  const Layer* below = nullptr;
  double block_m = 0;
  for (const auto& capacitor : s.capacitors) {
    double total = 0;
    for (const auto& layer : capacitor.layers) {
      const bool joins = below != nullptr && below->material == layer.material &&
                         s.faces == Faces::bonded_base && s.is_soft(s.material(layer));
      block_m = joins ? block_m + layer.thickness_m : layer.thickness_m;
      result.blocks += joins ? 0 : 1;
      below = &layer;
      total += layer.thickness_m;
      if (s.is_soft(s.material(layer))) {
        add_layer(s, layer, block_m, result);
      } else if (!s.material(layer).rigid) {
        result.films_bend = true;
      }
    }
    result.capacitor_m = std::max(result.capacitor_m, total);
  }
  result.free_face =
      s.is_soft(s.material(*below)) && s.top == Top::pressure && s.faces == Faces::bonded_base;
  return result;
}

// The same options at the level that is exact for sliding faces.
Result<double> free_error(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  LevelSettings one = settings;
  one.level = Level::hyperelastic;
  one.lateral = Lateral::free;
  one.electrode_area = ElectrodeArea::reference;
  auto exact = state_at(s, one, pressure);
  auto mine = state_at(s, settings, pressure);
  if (!exact || !mine) {
    return fail(exact ? mine.error() : exact.error());
  }
  return relative(mine->delta_capacitance_F, exact->delta_capacitance_F) + kOneDimensional;
}

// Mean strain of the soft layers by the coarsest mesh; contact gaps are no strain.
Result<double> mean_strain(const Specimen& s, Pressure pressure) {
  Specimen plain = s;
  plain.contact_gap.reset();
  LevelSettings coarse = at_level(Level::fem_linear);
  coarse.mesh.refinement = 0;
  const auto state = state_at(plain, coarse, pressure);
  if (!state) {
    return fail(state.error());
  }
  return std::min(state->shortening_m / find_softest(s).thickness_m, 1.0);
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
  const auto strain = mean_strain(s, pressure);
  if (!strain) {
    return strain;
  }
  const Softest soft = find_softest(s);
  const double e = *strain;
  return soft.mismatch + (soft.free_face ? 0.6 * e + 85 * e * e : 2 * e);
}

// What the neighbourhood of a bonded rim corner costs at finite strain: refining it does not
// converge, least of all where the surface beside it is free to fold.
double corner_error(const Specimen& s, Pressure pressure) {
  const Softest soft = find_softest(s);
  const double e = mean_strain(s, pressure).value_or(1.0);
  return 2e-3 * e + 2 / soft.shape_factor * e * e + (soft.free_face ? 40 * e * e : 0);
}

// A level that does not know bonded faces at all, against the cheapest one that does.
Result<double> crude_error(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  LevelSettings better =
      at_level(s.faces == Faces::bonded_laminate ? Level::bonded : Level::fem_linear);
  better.mesh.refinement = 0;
  better.fringe = settings.fringe;
  auto mine = state_at(s, settings, pressure);
  auto known = state_at(s, better, pressure);
  auto rest = estimate_error(s, better, pressure);
  if (!mine || !known || !rest) {
    return fail(!mine ? mine.error() : !known ? known.error() : rest.error());
  }
  const double difference = relative(mine->delta_capacitance_F, known->delta_capacitance_F);
  return difference + (1 + difference) * *rest;
}

double bonded_error(const Softest& soft, const Specimen& s) {
  const double films = soft.films_bend ? soft.capacitor_m / s.disc_diameter_m : 0;
  return bonded_modulus_error(soft.poisson_ratio, soft.shape_factor) + films;
}

}  // namespace

double bonded_modulus_error(double nu, double shape_factor) {
  return std::min(0.03, 0.105 * std::pow(2 * nu, 6) / shape_factor);
}

double mesh_error(const Specimen& s, const LevelSettings& settings) {
  if (s.faces == Faces::free) {
    return 1e-10;  // uniform strains
  }
  const Softest soft = find_softest(s);
  const auto i = static_cast<std::size_t>(std::clamp(settings.mesh.refinement, 0, 3));
  if (soft.blocks > 1) {
    constexpr std::array<double, 4> kLaminate{3e-4, 8e-5, 2.5e-5, 8e-6};
    return kLaminate[i] * (soft.free_face ? 2 : 1);
  }
  // A disc's corners matter by the share of the rim, and the less the more compressible it is.
  constexpr std::array<double, 4> kLinear{5e-4, 1e-4, 2e-5, 1.2e-5};
  constexpr std::array<double, 4> kFinite{1.6e-3, 1.2e-3, 5e-4, 1e-4};
  const double k = settings.level == Level::fem_finite ? kFinite[i] : kLinear[i];
  const double rim = soft.free_face ? 0.4 : 1 / (soft.shape_factor + 0.5);
  return k * std::pow(2 * std::max(soft.poisson_ratio, 0.3), 6) * rim;
}

Result<double> estimate_error(const Specimen& s, const LevelSettings& settings, Pressure pressure) {
  if (auto ok = check_specimen(s); !ok) {
    return fail(ok.error());
  }
  if (s.faces == Faces::free) {
    return free_error(s, settings, pressure);
  }
  switch (settings.level) {
    case Level::linear:
    case Level::hyperelastic: return crude_error(s, settings, pressure);
    case Level::bonded: {
      auto bent = settings.nonlinear ? Result<double>(0.0) : nonlinearity(s, pressure);
      return bent ? Result<double>(*bent + bonded_error(find_softest(s), s)) : bent;
    }
    case Level::fem_linear: {
      auto bent = nonlinearity(s, pressure);
      return bent ? Result<double>(*bent + mesh_error(s, settings)) : bent;
    }
    case Level::fem_finite: return mesh_error(s, settings) + corner_error(s, pressure);
  }
  return fail(Errc::bug, "unknown level");
}

}  // namespace lcrig
