// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/zero.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "protocols/rig/rest_measurement.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

namespace {

// Each zero removes a part of the true force from what the limits see. All zeros of a run together
// may remove as much as the limits allow on the specimen at all. A single one never removes more,
// because the guard would have ended the run.
Result<> check_sum(double sum_N, const RunParts& run) {
  const BoundLimits& limits = run.setup.limits;
  const double most_N = std::max(std::abs(limits.force_min_N), std::abs(limits.force_max_N));
  if (std::abs(sum_N) <= most_N) return {};
  return fail(Errc::limit_tripped,
              "step {}: the zeros of this run would take {:.4f} N out of the force together, and "
              "{:.4f} N is the most that its limits allow to be felt: the probe may press while it "
              "is zeroed; move it away before `zero`, or zero the cell at the machine and begin a "
              "new run",
              run.log.step_id(), sum_N, most_N);
}

// The force of the probe on the specimen, as far as the run knows: the probe is beyond contact, and
// the cell shows more than without load.
double pressed_N(const RestMeasurement& rest, const RunParts& run) {
  const auto contact_m = run.rig.contact.travel_m;
  if (!contact_m || !run.rig.is_loaded(rest.force_N())) return 0;
  if (rest.travel_m() && *rest.travel_m() < *contact_m) return 0;
  return rest.force_N() - run.rig.cell.unloaded_N();
}

}  // namespace

ZeroStep ZeroStep::parse(const StepReader& r) {
  ZeroStep out;
  out.force = r.json.optional_boolean("force").value_or(false);
  out.travel = r.json.optional_boolean("travel").value_or(false);
  out.max_offset = r.optional("max_offset", Dimension::force, kPositiveForces);
  if (!out.force && !out.travel) {
    r.json.refuse("nothing to zero, expected \"force\": true or \"travel\": true or both");
  }
  if (out.max_offset && !out.force) {
    r.json.refuse("max_offset without \"force\": true, expected both or none");
  }
  return out;
}

StepPlan ZeroStep::plan(PlannedRig& rig) const {
  StepPlan out(1);
  const FrameCapabilities& caps = rig.frame();
  if (force && !caps.zero_force) {
    out.refuse(Refusal(
        caps.weights
            ? "zero of the force, which this rig cannot do. It has dead weights: leave the zero "
              "out and load with place_weight, as static-weights does"
            : "zero of the force, which this rig cannot do"));
  } else if (travel && !caps.zero_travel) {
    out.refuse(Refusal("zero of the travel, which this rig cannot do"));
  }
  if (travel) rig.zero_travel();
  if (force) rig.zero_force();
  return out;
}

Task<Result<>> ZeroStep::execute(RunParts& run, StepProgress& /*remembered*/) const {
  auto rest = co_await run.meter.measure(RestMeter::kRestTime);
  if (!rest) co_return fail(rest.error());
  if (max_offset && std::abs(rest->force_N()) > run.get(*max_offset)) {
    co_return fail(Errc::limit_tripped,
                   "step {}: {:.4f} N at rest before zeroing, {:.4f} N allowed: the probe may "
                   "already touch; move it away or zero the cell at the machine",
                   run.log.step_id(), rest->force_N(), run.get(*max_offset));
  }
  const double sum_N = run.rig.cell.zeros_N.value_or(0) + rest->force_N();
  if (force) {
    if (auto allowed = check_sum(sum_N, run); !allowed) co_return allowed;
  }
  const double hidden_N = force ? pressed_N(*rest, run) : 0;
  const ScopedFlag zeroing = run.response.expect_zero(travel);  // the gateway may report it as well
  auto zeroed = co_await run.setup.frame.zero(force, travel);
  if (!zeroed && zeroed.error().code == Errc::refused) run.response.zero_settled();
  if (!zeroed) co_return zeroed;
  run.watch.zeroed(*rest, force, travel, hidden_N);
  run.event(run.point());  // stores the new origin
  run.event(ZeroEvent{rest->force_N()});
  co_await run.setup.clock.wait_for(old_samples(run.setup.frame_rate_Hz));
  auto after = co_await run.meter.measure(RestMeter::kRestTime);
  if (!after) co_return fail(after.error());
  run.watch.zero_measured(*rest, *after, hidden_N);
  run.response.zero_settled();
  co_return Result<>();
}

}  // namespace lcrig
