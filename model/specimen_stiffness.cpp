// SPDX-License-Identifier: Apache-2.0
#include "model/specimen_stiffness.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "model/response.hpp"
#include "model/stretch.hpp"

namespace lcrig {

namespace {

// Used only to estimate times and expected forces; the lower bound does not depend on it.
constexpr double kTolerance = 0.01;

struct SoftLayer {
  double thickness_m, shear_modulus_Pa, poisson_ratio;
};

}  // namespace

std::function<double(double force_N)> least_shortening(const Specimen& specimen) {
  std::vector<SoftLayer> layers;
  for (const Capacitor& capacitor : specimen.capacitors) {
    for (const Layer& layer : capacitor.layers) {
      const Material& m = specimen.material(layer);
      if (m.rigid) continue;
      // A file may state both moduli. If they disagree, the stiffer one gives the bound.
      const double of_youngs = m.youngs_modulus_Pa / (2 * (1 + m.poisson_ratio));
      const double shear = std::max(m.shear_modulus_Pa(), of_youngs);
      layers.push_back({layer.thickness_m, shear, m.poisson_ratio});
    }
  }
  return [layers = std::move(layers), area_m2 = specimen.area_m2()](double force_N) {
    double sum_m = 0;
    for (const SoftLayer& layer : layers) {
      const auto stretch = solve_stretch(Pressure::from_si(layer.shear_modulus_Pa),
                                         layer.poisson_ratio, EnergyForm::a, Lateral::confined,
                                         PressureKind::dead, Pressure::from_si(force_N / area_m2));
      if (stretch) sum_m += stretch->strain * layer.thickness_m;
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
