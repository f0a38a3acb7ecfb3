// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/place_weight.hpp"

#include <fmt/format.h>

#include <optional>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

PlaceWeightStep PlaceWeightStep::parse(const StepReader& r) {
  PlaceWeightStep out;
  const auto mass = r.optional("mass", Dimension::mass, Range{0, 1e5});  // kg
  int given = mass ? 1 : 0;
  const auto load = r.load(Range{0, kForces.max}, given);
  if (given != 1) {
    r.json.refuse(
        fmt::format("{} loads, expected exactly one of mass_g, force_N, pressure_kPa (or "
                    "another unit)",
                    given));
  }
  if (load) {
    out.load = *load;
  } else if (mass) {
    out.load.kind = TargetKind::mass;
    out.load.value = *mass;
  }
  return out;
}

StepPlan PlaceWeightStep::plan(PlannedRig& rig) const {
  StepPlan out(PlannedRig::kByHand_s);
  out.by_hand = true;
  const double force_N = rig.force_of(load);
  out.note = fmt::format("{:.4g} g = {:.4g} N; about {:.0f} s for the operator",
                         force_N / rig.known().gravity_m_s2 * 1e3, force_N, out.seconds);
  rig.go_to_force(force_N, load.kind == TargetKind::mass ? nullptr : &load.value, out);
  rig.foresee(force_N, 0);
  return out;
}

Task<Result<>> PlaceWeightStep::execute(RunParts& run, StepProgress& /*remembered*/) const {
  const double mass_kg = load.kind == TargetKind::mass
                             ? run.get(load.value)
                             : run.labels.force_of(load) / run.setup.gravity_m_s2;
  std::optional<ProgressKeeper::Shown> waiting;
  if (!run.interrupts.finishing()) {
    auto shown = co_await run.wait_as(RunState::waiting_for_operator);
    waiting.emplace(std::move(shown));
  }
  run.setup.frame.show_pressure(run.setup.pressure);
  auto placed = co_await run.setup.frame.place_mass(Mass::from_si(mass_kg));
  waiting.reset();
  if (!placed) co_return fail(placed.error());
  run.event(ended_event<EventKind::confirm>(*placed));
  co_return Result<>();
}

}  // namespace lcrig
