// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "model/fem_capacitance.hpp"
#include "model/fem_levels.hpp"
#include "model/gauss.hpp"

namespace lcrig {
namespace {}  // namespace

Result<std::unique_ptr<FemLinear>> FemLinear::make(const Specimen& specimen,
                                                   const LevelSettings& settings) {
  auto space = StackSpace::make(specimen, settings.mesh, false);
  if (!space) return fail(space.error());
  std::unique_ptr<FemLinear> model(
      new FemLinear(std::move(*space), settings.electrode_area, specimen.c0_F()));
  model->report_ = LinearSystem(model->space_).solve(model->u_);
  if (!model->report_.converged) {
    return fail(Errc::invalid_request, "fem_linear, specimen {}: {}", specimen.name,
                model->report_.why);
  }
  return model;
}

void FemLinear::sweep() {
  const auto& r = space_.radii();
  const auto degree = static_cast<std::size_t>(space_.degree());
  for (std::size_t row = 0; row < space_.rows().size(); ++row) {
    auto& volume = swept_.emplace_back();
    for (std::size_t k = 0; k <= degree; ++k) {
      const Height line{static_cast<int>(row),
                        2 * static_cast<double>(k) / static_cast<double>(degree) - 1};
      const auto u = space_.displacement(u_, line, 1);
      for (std::size_t i = 0; i + degree < r.size(); i += degree) {
        const double half = (r[i + degree] - r[i]) / 2;
        for (const auto& [x, weight] : kGauss5) {
          const auto shape = lagrange(space_.degree(), x).value;
          double moved = 0;
          for (std::size_t j = 0; j <= degree; ++j) moved += shape[j] * u[i + j];
          volume[k] -= 2 * std::numbers::pi * half * weight * (r[i] + (1 + x) * half) * moved;
        }
      }
    }
  }
}

double FemLinear::swept_volume_m3_Pa(double height_m) {
  if (swept_.empty()) sweep();
  const Height h = space_.height(std::min(height_m, space_.rows().back().z1));
  const auto& v = swept_[static_cast<std::size_t>(h.row)];
  const auto shape = lagrange(space_.degree(), h.zeta).value;
  return std::inner_product(shape.begin(), shape.end(), v.begin(), 0.0);
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
