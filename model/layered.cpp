// SPDX-License-Identifier: Apache-2.0
#include "model/level_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcrig {
namespace {

class LayeredModel final : public LevelModel {
 public:
  LayeredModel(const Specimen& specimen, LayerStrain strain)
      : specimen_(specimen), strain_(std::move(strain)) {
    for (const auto& capacitor : specimen_.capacitors) capacitors_.push_back(prepare(capacitor));
  }

  Result<StackState> at_pressure(Pressure pressure) override {
    if (auto ok = check_pressure(pressure); !ok) return fail(ok.error());
    if (auto ok = update_strains(pressure); !ok) return fail(ok.error());
    StackState state;
    state.pressure_Pa = pressure.si();
    state.capacitor_delta_F.reserve(capacitors_.size());
    for (const auto& capacitor : capacitors_) {
      double closing = 0;
      for (const auto& part : capacitor.soft) {
        closing += part.gap_m * strains_[part.kind];
        state.shortening_m += part.thickness_m * strains_[part.kind];
      }
      const double delta = delta_capacitance_F(capacitor.c0_F, capacitor.gap_m, closing);
      state.capacitor_delta_F.push_back(delta);
      state.delta_capacitance_F += delta;
    }
    return state;
  }

  double c0_F() const override { return specimen_.c0_F(); }

 private:
  struct Part {
    double thickness_m, gap_m;
    std::size_t kind;  // index into kinds_
  };
  struct Prepared {
    double c0_F, gap_m;
    std::vector<Part> soft;  // the layers that strain
  };

  Prepared prepare(const Capacitor& capacitor) {
    Prepared result{specimen_.c0_F(capacitor), specimen_.dielectric_gap_m(capacitor), {}};
    for (const auto& layer : capacitor.layers) {
      const auto& material = specimen_.material(layer);
      if (!material.rigid) {
        result.soft.push_back({layer.thickness_m,
                               layer.thickness_m / material.relative_permittivity, kind_of(layer)});
      }
    }
    return result;
  }

  std::size_t kind_of(const Layer& layer) {
    const auto same = [&](const Layer& other) {
      return other.material == layer.material && other.thickness_m == layer.thickness_m;
    };
    const auto found = std::find_if(kinds_.begin(), kinds_.end(), same);
    if (found != kinds_.end()) return static_cast<std::size_t>(found - kinds_.begin());
    kinds_.push_back(layer);
    return kinds_.size() - 1;
  }

  Result<> update_strains(Pressure pressure) {
    strains_.resize(kinds_.size());
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
      auto strain = strain_(specimen_.material(kinds_[i]), kinds_[i].thickness_m, pressure);
      if (!strain) return fail(strain.error());
      strains_[i] = *strain;
    }
    return {};
  }

  Specimen specimen_;
  LayerStrain strain_;
  std::vector<Layer> kinds_;  // distinct layers; each is solved once per pressure
  std::vector<double> strains_;
  std::vector<Prepared> capacitors_;
};

}  // namespace

std::unique_ptr<LevelModel> make_layered_model(const Specimen& specimen, LayerStrain strain) {
  return std::make_unique<LayeredModel>(specimen, std::move(strain));
}

}  // namespace lcrig
