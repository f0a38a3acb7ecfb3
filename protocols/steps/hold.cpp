// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/hold.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_motion.hpp"
#include "protocols/run/frame_watch.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

namespace {
constexpr double kNoGap_m = 1e-9;
}  // namespace

HoldStep HoldStep::parse(const StepReader& r) {
  HoldStep out;
  out.mode = r.json.word<HoldMode>("hold");
  out.duration = r.required("for", Dimension::time, Range{0, kTimes.max});
  int given = 0;
  out.at = r.load(kForces, given);
  if (given > 1) r.json.refuse("a force and a pressure, expected at most one of them");
  if (out.at && out.mode == HoldMode::travel) {
    r.json.refuse("a force beside \"hold\": \"travel\", expected \"hold\": \"force\"");
  }
  return out;
}

StepPlan HoldStep::plan(PlannedRig& rig) const {
  StepPlan out(rig.get(duration));
  const FrameCapabilities& caps = rig.frame();
  // Dead weights hold a force by themselves.
  if (mode == HoldMode::force && !caps.force_hold && !caps.weights) {
    out.refuse(
        Refusal("holding a force needs a force loop in the frame; this one has none: hold "
                "the travel"));
  } else if (at && caps.weights && !caps.force_hold) {
    out.refuse(Refusal("a dead-weight rig cannot go to a force by itself: use place_weight"));
  }
  const bool by_loop = mode == HoldMode::force && !caps.weights;
  const double gap_m = rig.contact_m() - rig.travel_m();
  if (by_loop && rig.contact() != PlannedRig::Contact::unknown && gap_m > kNoGap_m) {
    out.refuse(
        Refusal(fmt::format("holding a force needs contact, and the specimen is {:.3g} mm "
                            "away here: ramp to a force first",
                            gap_m * 1e3)));
  }
  if (out.why) return out;
  const double before_N = rig.force_N(), force_N = at ? rig.force_of(*at) : before_N;
  if (at) {
    add_remark(out.note, fmt::format("holds {:.4g} N", force_N));
    rig.go_to_travel(rig.travel_at(force_N), nullptr, out);
    rig.go_to_force(force_N, &at->value, out);
  }
  if (by_loop) check_force_loop(force_N, rig, out);
  if (!by_loop || out.why) return out;
  const ForceLoop& loop = *caps.force_loop;
  const double worst_N = rig.felt_N(std::max(force_N, before_N)) + loop.ripple.si() +
                         (force_N > before_N ? loop.rate_max.si() * to_seconds(loop.lag) : 0);
  if (exceeds(worst_N, rig.largest_end_N())) {
    out.refuse(
        Refusal(fmt::format("holding {:.4g} N may end at {:.3g} N, {}: ramp to the force first, or "
                            "hold the travel",
                            force_N, worst_N, rig.limit_text())));
  } else {
    rig.foresee(worst_N, 0);
  }
  return out;
}

namespace {

// Does not let a specimen that was run into be held at more than its present force.
Task<Result<>> hold_at_force(const HoldStep& step, RunParts& run) {
  auto force_N = run.meter.present_force_N();
  if (step.at) force_N = run.labels.force_of(*step.at);
  if (!force_N) co_return fail(force_N.error());
  const double most_N = run.rig.frame.force_N.value_or(0) + kNoiseSigmas * run.rig.cell.noise_N();
  const auto may = run.rig.trust.may_press();
  if (!may && *force_N > most_N) {
    co_return fail(may.error().code, "step {}: {}", run.log.step_id(), may.error().what);
  }
  run.watch.leave_to_loop();
  auto held = co_await run.drive.hold_force(*force_N);
  run.drive.will_hold(*force_N);
  co_return held;
}

}  // namespace

Task<Result<>> HoldStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  // A run that only watches sends no command; the step just waits.
  if (!progress.holds && run.setup.commands) {
    Result<> held;
    run.drive.will_hold(std::nullopt);
    if (mode == HoldMode::travel) {
      held = co_await run.drive.hold_travel();
    } else {
      held = co_await hold_at_force(*this, run);
    }
    if (!held) co_return held;
    progress.holds = true;
  }
  co_return co_await wait_out(run.get(duration), run, progress.time);
}

}  // namespace lcrig
