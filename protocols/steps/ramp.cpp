// SPDX-License-Identifier: Apache-2.0
#include "protocols/steps/ramp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "protocols/file/step_reader.hpp"
#include "protocols/plan/planned_motion.hpp"
#include "protocols/rig/rig_state.hpp"
#include "protocols/run/run_parts.hpp"

namespace lcrig {

RampStep RampStep::parse(const StepReader& r) {
  RampStep out;
  out.to = r.target("to");
  out.speed = r.optional("speed", Dimension::speed, kSpeeds);
  out.force_rate = r.optional("force_rate", Dimension::force_rate, kPositive);
  out.timeout = r.timeout();
  if (!is_force(out.to) && !out.speed) {
    r.json.refuse("no speed, expected speed_mm_s (or another unit) for a ramp to a travel or gap");
  }
  if (!is_force(out.to) && out.force_rate) {
    r.json.refuse("a force rate, expected a force or pressure to ramp to");
  }
  if (out.speed.has_value() == out.force_rate.has_value()) {
    r.json.refuse("expected exactly one of speed_mm_s and force_rate_N_s (or another unit)");
  }
  return out;
}

namespace {

// Checks a ramp of the frame's force loop. The loop first closes the gap, at its own speed.
void check_ramp(const RampStep& step, double force_N, PlannedRig& rig, StepPlan& out) {
  check_force_loop(force_N, rig, out);
  if (out.why) return;
  const ForceLoop& loop = *rig.frame().force_loop;
  const Number& rate = *step.force_rate;
  const double r = rig.get(rate), limit = rig.largest_end_N(), end = rig.proposed_end_N();
  if (exceeds(r, loop.rate_max.si())) {
    return out.refuse(Refusal(
        fmt::format("{:.4g} N/s, the frame's force loop follows {:.4g} N/s", r, loop.rate_max.si()),
        at_most(rate, loop.rate_max.si(), rig.asked())));
  }
  const double from = rig.felt_N(rig.force_N()), felt = rig.felt_N(force_N);
  double worst = rig.forecast().ramp_N(from, felt, r);
  if (exceeds(worst, limit) && rig.can_be_measured()) {
    worst = rig.forecast().ramp_if_measured_N(from, felt, r).value_or(worst);
    add_remark(out.note, "if the stiffness that is measured at contact allows it");
  }
  add_remark(out.note, fmt::format("{:.3g} N at worst", worst));
  if (!exceeds(worst, limit)) return rig.foresee(worst, loop.approach.si());
  const double fastest = rig.forecast().fastest_ramp_N_s(felt, end);
  const std::string why = fmt::format("{:.4g} N/s to {:.4g} N may end at {:.3g} N, {}", r, force_N,
                                      worst, rig.limit_text());
  if (fastest > 0 && fastest < r) {
    return out.refuse(Refusal(fmt::format("{}: at most {:.3g} N/s", why, fastest),
                              at_most(rate, fastest, rig.asked())));
  }
  if (fastest <= 0) {
    const double most = end - rig.felt_N(0) - loop.ripple.si();
    return out.refuse(Refusal(
        fmt::format("{}: at most {:.4g} N, for a held force may be off by its ripple of {:.2g} N",
                    why, most, loop.ripple.si()),
        at_most(step.to.value, rig.get(step.to.value) * most / std::max(force_N, 1e-9),
                rig.asked())));
  }
  out.refuse(
      Refusal(fmt::format("{}: the frame approaches with {:.3g} mm/s by itself; press the "
                          "specimen with move_until first, or use speed_mm_s",
                          why, loop.approach.si() * 1e3)));
}

void plan_rate(const RampStep& step, PlannedRig& rig, StepPlan& out) {
  if (!rig.frame().force_hold) {
    return out.refuse(
        Refusal("a force rate needs a force loop in the frame; this one has none: use speed_mm_s"));
  }
  const double from_N = rig.force_N(), to_N = rig.force_of(step.to);
  const double rate = rig.get(*step.force_rate);
  check_ramp(step, to_N, rig, out);
  out.seconds = std::abs(to_N - from_N) / rate;
  add_remark(out.note, fmt::format("{:.4g} N to {:.4g} N at {:.4g} N/s", from_N, to_N, rate));
  const double gap_m = from_N > 0 ? 0 : rig.contact_m() - rig.travel_m();
  const auto& loop = rig.frame().force_loop;
  if (loop && loop->approach.si() > 0 && gap_m > 0) out.seconds += gap_m / loop->approach.si();
  rig.go_to_travel(rig.travel_at(to_N), nullptr, out);
  rig.go_to_force(to_N, &step.to.value, out);
}

constexpr double kLongWay = 1.2, kLongWayMore_s = 5;  // time-out for the way back to the start of a
                                                      // search

// For `finally` that goes to a gap although contact was never found. If the probe presses, it moves
// back by that gap; an unknown force counts as pressing. After a search without contact it goes
// back to the start of the search, because the cell may have failed to show a force.
Task<Result<>> back_away(const RampStep& step, RunParts& run, RampStep::Progress& progress) {
  const auto force_N = run.meter.present_force_N();
  const bool presses = !force_N || !run.rig.trust.force || run.rig.is_loaded(*force_N);
  const auto from_m = run.rig.contact.searched_from_m, here_m = run.rig.frame.seen.travel_m;
  if (!progress.away_m && !presses && !from_m) {
    run.event(EventKind::skipped,
              "no contact was found, and nothing presses: there is nothing to move away from");
    co_return Result<>();
  }
  if (!here_m) {
    co_return fail(Errc::no_reply, "step {}: the frame sends no travel", run.log.step_id());
  }
  if (!progress.away_m) {
    const FrameCapabilities caps = run.rig.frame.caps;
    const double least_m = device_limits(run.rig.limits, caps).travel_min.si();
    double target_m = presses ? *here_m - run.get(step.to.value) : *here_m;
    if (from_m) target_m = std::min(target_m, *from_m);
    progress.away_m = std::max(least_m, target_m);
  }
  if (*progress.away_m >= *here_m) co_return Result<>();
  const double speed_m_s = run.get(*step.speed);
  const double way_s = (*here_m - *progress.away_m) / speed_m_s;
  const double timeout_s = std::max(run.get(step.timeout), kLongWay * way_s + kLongWayMore_s);
  co_return co_await run.motions.to_travel(*progress.away_m, speed_m_s, timeout_s);
}

}  // namespace

StepPlan RampStep::plan(PlannedRig& rig) const {
  StepPlan out;
  PlannedMotion motion(rig, timeout, out);
  if (!speed) {
    plan_rate(*this, rig, out);
  } else {
    rig.use_speed(*speed, out);
    const bool loading = is_force(to) && rig.force_of(to) > rig.force_N();
    if (is_force(to)) {
      motion.to_force(to, *speed);
    } else {
      motion.to_travel(to, *speed);
    }
    if (loading) motion.check_stop(rig.felt_N(rig.force_of(to)), *speed, std::nullopt, &to.value);
  }
  motion.check_timeout();
  return out;
}

Task<Result<>> RampStep::execute(RunParts& run, StepProgress& remembered) const {
  auto& progress = dynamic_cast<Progress&>(remembered);
  const TimeLimit limit(run.get(timeout), &progress.time);
  if (!is_force(to)) {
    const bool clears = run.interrupts.finishing() && to.kind == TargetKind::gap;
    if (clears && !run.rig.contact.travel_m) co_return co_await back_away(*this, run, progress);
    co_return co_await move_to_place(to, *speed, limit, run);
  }
  const double force_N = run.labels.force_of(to);
  if (speed) co_return co_await run.motions.to_force(force_N, run.get(*speed), limit);
  co_return co_await run.motions.ramp_to_force(force_N, run.get(*force_rate), limit);
}

}  // namespace lcrig
