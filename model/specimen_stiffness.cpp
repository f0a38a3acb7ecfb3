// SPDX-License-Identifier: Apache-2.0
#include "model/specimen_stiffness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "model/response.hpp"
#include "model/stretch.hpp"

namespace lcrig {

namespace {

// Used only to estimate times and expected forces; the lower bound does not depend on it.
constexpr double kTolerance = 0.01;

// Forces of a table, so fine that a layer hardly stiffens from one to the next.
constexpr double kTableFirst_N = 1e-3, kTableRatio = 1.05;
constexpr std::size_t kTableSteps = 425;  // reaches 1e6 N

using Table = std::array<double, kTableSteps + 1>;

const Table& forces_N() {
  static const Table all = [] {
    Table out{};
    for (std::size_t i = 1; i <= kTableSteps; ++i) {
      out[i] = kTableFirst_N * std::pow(kTableRatio, static_cast<double>(i - 1));
    }
    return out;
  }();
  return all;
}

double interpolate(const Table& values, double force_N) {
  const Table& force = forces_N();
  const auto above = std::upper_bound(force.begin() + 1, force.end(), force_N);
  if (above == force.end()) return values.back();
  const auto i = static_cast<std::size_t>(above - force.begin());
  const double part = (force_N - force[i - 1]) / (force[i] - force[i - 1]);
  return values[i - 1] + part * (values[i] - values[i - 1]);
}

// One law of a layer: how it may behave sideways, and which strain energy it follows.
struct LayerLaw {
  double shear_Pa, poisson_ratio;
  EnergyForm form;
  Lateral lateral;
};

// Lowers each step of strain to that of this law.
void take_law(const LayerLaw& law, double area_m2, Table& steps) {
  double before = 0;
  for (std::size_t i = 1; i <= kTableSteps; ++i) {
    const auto now =
        solve_stretch(Pressure::from_si(law.shear_Pa), law.poisson_ratio, law.form, law.lateral,
                      PressureKind::dead, Pressure::from_si(forces_N()[i] / area_m2));
    if (!now) return;  // from here on it gives way without an end
    steps[i] = std::min(steps[i], std::max(now->strain - before, 0.0));
    before = now->strain;
  }
}

Table least_steps(const Material& material, double area_m2) {
  Table steps;
  steps.fill(std::numeric_limits<double>::infinity());
  // A file may state both moduli, and they may disagree.
  const double of_youngs = material.youngs_modulus_Pa / (2 * (1 + material.poisson_ratio));
  for (const double shear : std::set{material.shear_modulus_Pa(), of_youngs}) {
    for (const EnergyForm form :
         {EnergyForm::a, EnergyForm::b, EnergyForm::c, EnergyForm::d, EnergyForm::e}) {
      for (const Lateral lateral : {Lateral::free, Lateral::confined}) {
        take_law({shear, material.poisson_ratio, form, lateral}, area_m2, steps);
      }
    }
  }
  return steps;
}

// Thickness of all layers of each material that strains.
std::map<std::size_t, double> soft_thickness_m(const Specimen& specimen) {
  std::map<std::size_t, double> out;
  for (const Capacitor& capacitor : specimen.capacitors) {
    for (const Layer& layer : capacitor.layers) {
      if (!specimen.material(layer).rigid) out[layer.material] += layer.thickness_m;
    }
  }
  return out;
}

}  // namespace

std::function<double(double force_N)> least_shortening(const Specimen& specimen) {
  const auto table = std::make_shared<Table>();
  for (const auto& [material, thickness_m] : soft_thickness_m(specimen)) {
    const Table steps = least_steps(specimen.materials[material], specimen.area_m2());
    double strain = 0;
    for (std::size_t i = 1; i <= kTableSteps; ++i) {
      if (std::isfinite(steps[i])) strain += steps[i];
      (*table)[i] += thickness_m * strain;
    }
  }
  // A layer that has crept under a held force answers like one under a larger force.
  const double crept = 1 + (specimen.creep ? specimen.creep->fraction : 0);
  return [table, crept](double force_N) { return interpolate(*table, crept * force_N) / crept; };
}

std::function<double(double force_N)> free_shortening(const Specimen& specimen) {
  std::vector<std::pair<double, Material>> layers;
  for (const auto& [material, thickness_m] : soft_thickness_m(specimen)) {
    layers.emplace_back(thickness_m, specimen.materials[material]);
  }
  return [layers = std::move(layers), area_m2 = specimen.area_m2()](double force_N) {
    double sum_m = 0;
    for (const auto& [thickness_m, material] : layers) {
      const auto stretch = solve_stretch(Pressure::from_si(material.shear_modulus_Pa()),
                                         material.poisson_ratio, EnergyForm::a, Lateral::free,
                                         PressureKind::dead, Pressure::from_si(force_N / area_m2));
      if (stretch) sum_m += stretch->strain * thickness_m;
    }
    return sum_m;
  };
}

std::function<double(double force_N)> expected_compression(
    const Specimen& specimen, Force force_max, std::optional<double> frame_stiffness_N_m) {
  const double compliance = frame_stiffness_N_m ? 1 / *frame_stiffness_N_m : 0;
  for (const Level level : {Level::bonded, Level::hyperelastic, Level::linear}) {
    LevelSettings settings;
    settings.level = level;
    auto made = make_response(specimen, settings, force_max, kTolerance);
    if (!made) continue;
    return [table = std::shared_ptr<TabulatedResponse>(std::move(*made)),
            compliance](double force) { return table->shortening_m(force) + force * compliance; };
  }
  return {};
}

}  // namespace lcrig
