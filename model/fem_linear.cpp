// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "model/fem_capacitance.hpp"
#include "model/fem_levels.hpp"

namespace lcrig {
namespace {

Result<> check_pressure(Pressure pressure) {
  if (!std::isfinite(pressure.si()) || pressure.si() < 0) {
    return fail(Errc::invalid_request, "pressure {} Pa must be finite and compressive (>= 0)",
                pressure.si());
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<FemLinear>> FemLinear::make(const Specimen& specimen,
                                                   const LevelSettings& settings) {
  auto space = StackSpace::make(specimen, settings.mesh, false);
  if (!space) return fail(space.error());
  std::unique_ptr<FemLinear> model(
      new FemLinear(std::move(*space), settings.electrode_area, specimen.c0_F()));
  FemSystem system(model->space_, Kinematics::linear);
  FemState state = system.rest();
  model->report_ = system.solve(1.0, state, true);
  if (!model->report_.converged) {
    return fail(Errc::invalid_request, "fem_linear, specimen {}: {}", specimen.name,
                model->report_.why);
  }
  model->u_ = std::move(state.u);
  model->sweep();
  return model;
}

// Radius times a quadratic is a cubic in each cell, which Simpson's rule integrates exactly.
void FemLinear::sweep() {
  const auto& r = space_.radii();
  for (std::size_t row = 0; row < space_.rows().size(); ++row) {
    auto& volume = swept_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Height line{static_cast<int>(row), static_cast<double>(k) - 1};
      const auto u = space_.displacement(u_, line, 1);
      for (std::size_t i = 0; i + 2 < r.size(); i += 2) {
        volume[k] -= std::numbers::pi / 3 * (r[i + 2] - r[i]) *
                     (r[i] * u[i] + 4 * r[i + 1] * u[i + 1] + r[i + 2] * u[i + 2]);
      }
    }
  }
}

double FemLinear::swept_volume_m3_Pa(double height_m) const {
  const Height h = space_.height(std::min(height_m, space_.rows().back().z1));
  const auto& v = swept_[static_cast<std::size_t>(h.row)];
  return v[0] * h.zeta * (h.zeta - 1) / 2 + v[1] * (1 - h.zeta * h.zeta) +
         v[2] * h.zeta * (h.zeta + 1) / 2;
}

Result<StackState> FemLinear::state(Pressure pressure,
                                    const std::vector<StackSpace::Capacitor>& capacitors) {
  if (auto ok = check_pressure(pressure); !ok) return fail(ok.error());
  auto changes = capacitance_changes(space_, capacitors, u_, pressure.si(), area_);
  if (!changes) {
    return fail(changes.error().code,
                "fem_linear: {} at {} kPa: beyond small strains, use fem_finite",
                changes.error().what, pressure.si() / 1e3);
  }
  StackState result;
  result.pressure_Pa = pressure.si();
  result.shortening_m = pressure.si() * space_.shortening_m(u_);
  result.delta_capacitance_F = std::accumulate(changes->begin(), changes->end(), 0.0);
  result.capacitor_delta_F = std::move(*changes);
  return result;
}

Result<StackState> FemLinear::at_pressure(Pressure pressure) {
  return state(pressure, space_.capacitors());
}

Result<StackState> FemLinear::at_pressure(Pressure pressure,
                                          const std::vector<double>& partition_m) {
  auto capacitors = space_.partition(partition_m);
  if (!capacitors) return fail(capacitors.error());
  return state(pressure, *capacitors);
}

Result<std::unique_ptr<LevelModel>> make_fem_linear(const Specimen& specimen,
                                                    const LevelSettings& settings) {
  auto model = FemLinear::make(specimen, settings);
  if (!model) return fail(model.error());
  return std::unique_ptr<LevelModel>(std::move(*model));
}

}  // namespace lcrig
