// SPDX-License-Identifier: Apache-2.0
#include "model/bench_world.hpp"

#include <utility>

namespace lcrig {

Result<std::unique_ptr<BenchWorld>> BenchWorld::make(const Specimen& specimen,
                                                     std::optional<double> probe_diameter_m,
                                                     double tolerance, Force max_force,
                                                     PlantConfig mounting,
                                                     std::optional<ErrorScope> scope,
                                                     std::optional<std::uint64_t> rig_seed) {
  PressureArea pressure;
  pressure.probe_diameter_m = probe_diameter_m;
  put_disc(specimen, pressure);
  if (auto whole = require_whole_disc(pressure); !whole) return fail(whole.error());
  const Pressure max_pressure = Pressure::from_si(max_force.si() / specimen.area_m2());
  if (specimen.creep) {
    mounting.creep_fraction = specimen.creep->fraction;
    mounting.creep_time_s = specimen.creep->time_s;
  }
  std::optional<BenchErrors> errors;
  if (scope) {
    const ForceClass cell = mounting.force_class.value_or(kAssumedForceClass);
    errors.emplace(mounting.seed, *scope, rig_seed, cell);
  }
  if (errors) errors->apply(mounting);
  auto choice = choose_level(specimen, tolerance, max_pressure);
  if (!choice) {
    return fail(choice.error().code, "{}: set `error_tolerance` of the bench to what can be met",
                choice.error().what);
  }
  auto response = make_response(specimen, choice->settings, max_force, tolerance);
  if (!response) return fail(response.error());
  return std::unique_ptr<BenchWorld>(
      new BenchWorld(std::move(*choice), std::move(*response), mounting, std::move(errors)));
}

BenchWorld::BenchWorld(LevelChoice level, std::shared_ptr<const TabulatedResponse> response,
                       PlantConfig mounting, std::optional<BenchErrors> errors)
    : errors_(std::move(errors)),
      level_(std::move(level)),
      response_(std::move(response)),
      plant_(*response_, mounting) {}

Electrical BenchWorld::electrical(MonoTime t) {
  Electrical e = plant_.electrical(t);
  if (errors_) {
    e.capacitance_F = errors_->shown_F(t, e.capacitance_F, response_->c0_F(), plant_.force_N(t));
  }
  return e;
}

std::function<double(double force_N)> BenchWorld::compression_m() const {
  return [specimen = response_, k = plant_.config().frame_stiffness_N_m](double force_N) {
    return specimen->shortening_m(force_N) + force_N / k;
  };
}

}  // namespace lcrig
