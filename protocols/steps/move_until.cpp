// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/move_until.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "protocols/file/step_reader.hpp"
#include "protocols/plan/aperture.hpp"
#include "protocols/plan/planned_motion.hpp"
#include "protocols/rig/rig_state.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

namespace {

// The force at which the final speed begins: the fraction of the target force, or of the way to it
// if that is less. While unloading, the fraction of the force would lie beyond the target, so it is
// taken of the way.
double turn_force_N(double from_N, double to_N, double fraction) {
  const double way_N = from_N + fraction * (to_N - from_N);
  return to_N > from_N ? std::min(fraction * to_N, way_N) : way_N;
}

}  // namespace

MoveUntilStep MoveUntilStep::parse(const StepReader& r) {
  MoveUntilStep out;
  out.until = r.target("until");
  out.speed = r.required("speed", Dimension::speed, kSpeeds);
  out.final_speed = r.optional("final_speed", Dimension::speed, kSpeeds);
  if (const auto fraction = r.json.find("final_from")) {
    out.final_from = r.scope.read(*fraction, Dimension::none, 1, Range{0, 1, true});
  }
  out.overshoot = r.optional("overshoot", Dimension::force, kPositiveForces);
  out.timeout = r.timeout();
  if (out.final_speed.has_value() != out.final_from.has_value()) {
    r.json.refuse("one of final_speed and final_from, expected both or none");
  }
  if (!is_force(out.until) && (out.final_speed || out.overshoot)) {
    r.json.refuse("final_speed or overshoot without a force, expected until force or pressure");
  }
  return out;
}

StepPlan MoveUntilStep::plan(PlannedRig& rig) const {
  StepPlan out;
  PlannedMotion motion(rig, timeout, out);
  rig.use_speed(speed, out);
  if (!is_force(until)) {
    motion.to_travel(until, speed);
    motion.check_timeout();
    return out;
  }
  const double force_N = rig.force_of(until), v = rig.get(speed), from_m = rig.travel_m();
  const double from_N = rig.force_N();
  const bool loading = force_N > from_N;
  motion.to_force(until, speed);
  const Number& last = final_speed ? *final_speed : speed;
  if (final_speed) {
    rig.use_speed(last, out);
    const double turn_N = turn_force_N(from_N, force_N, rig.get(*final_from));
    const double to_m = rig.travel_m();
    const double slow_m = std::min(std::abs(to_m - from_m), std::abs(to_m - rig.travel_at(turn_N)));
    out.seconds += slow_m / rig.get(last) - slow_m / v;
    // The first part may overshoot by the rest of the way plus the allowed overshoot.
    std::optional<Number> allowed;
    if (overshoot) allowed = Number(rig.get(*overshoot) + (force_N - turn_N));
    if (turn_N > from_N) motion.check_stop(rig.felt_N(turn_N), speed, allowed);
  }
  if (const auto t = loaded_time_s(force_N, v, rig.known()); loading && t && !final_speed) {
    const double each = to_seconds(rig.known().lcr.conversion_time(rig.meter()));
    add_remark(out.note, fmt::format("loaded for {:.3g} s: {:.0f} readings of {:.0f} ms", *t,
                                     std::floor(*t / each), each * 1e3));
  }
  if (loading) motion.check_stop(rig.felt_N(force_N), last, overshoot, &until.value);
  motion.check_timeout();
  return out;
}

Task<Result<>> MoveUntilStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  const TimeLimit limit(run.get(timeout), &progress.time);
  if (!is_force(until)) co_return co_await move_to_place(until, speed, limit, run);
  const double force_N = run.labels.force_of(until);
  double v = run.get(speed);
  bool is_there = false;
  if (final_speed) {
    const auto present_N = run.meter.present_force_N();
    if (!present_N) co_return fail(present_N.error());
    const double turn_N = turn_force_N(*present_N, force_N, run.get(*final_from));
    const bool loading = force_N > *present_N;
    // Skips the first part if less than the last part is left, because it would lead backwards.
    if ((turn_N > *present_N) == loading) {
      auto near = co_await run.motions.to_force(turn_N, v, limit);
      if (!near) co_return near;
    }
    v = run.get(*final_speed);
    // Skips the last part if the first went too far.
    const auto near_N = run.meter.present_force_N();
    if (!near_N) co_return fail(near_N.error());
    is_there = loading ? *near_N >= force_N : *near_N <= force_N;
  }
  Result<> moved;
  if (!is_there) moved = co_await run.motions.to_force(force_N, v, limit);
  if (!moved || !overshoot) co_return moved;
  const auto now_N = run.meter.present_force_N();
  if (!now_N) co_return fail(now_N.error());
  const double beyond = std::max(*now_N, run.rig.frame.end_force_N.value_or(*now_N)) - force_N;
  if (beyond > run.get(*overshoot)) {
    co_return fail(Errc::limit_tripped, "step {}: overshoot of {:.4f} N, {:.4f} N allowed",
                   run.log.step_id(), beyond, run.get(*overshoot));
  }
  co_return Result<>();
}

}  // namespace lcrig
