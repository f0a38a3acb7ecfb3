// SPDX-License-Identifier: Apache-2.0
// What the frame's force loop may do to the specimen: ramps, and forces that are held.
#include <algorithm>
#include <cmath>

#include "protocols/file/words.hpp"
#include "protocols/plan/planner.hpp"

namespace lcrig {

void Planner::check_loop(double force, Outcome& out) {
  const auto& loop = rig_.frame.force_loop;
  if (!loop) {
    return out.refuse(
        Refusal("this frame does not say what bounds its force loop (its gateway has revision 1 of "
                "frame-link/1): state frame.force_loop in the config, or use speed_mm_s and hold "
                "the travel"));
  }
  if (forecast_.loop_can_hold(force)) return;
  if (can_be_measured() && forecast_.loop_can_hold_if_measured(force)) {
    return add_note(out.note, "if the stiffness that is measured at contact allows it");
  }
  out.refuse(Refusal(fmt::format(
      "the contact may be {:.3g} N/mm stiff, the frame's force loop is good for {:.3g} N/mm: use "
      "speed_mm_s and hold the travel",
      forecast_.bound().stiffness_N_m(force) * 1e-3, loop->stiffness_max.si() * 1e-3)));
}

void Planner::check_ramp(double force, const Target& to, const Number& rate, Outcome& out) {
  check_loop(force, out);
  if (out.why) return;
  const ForceLoop& loop = *rig_.frame.force_loop;
  const double r = env_.get(rate), limit = limits_.force_max_N;
  if (exceeds(r, loop.rate_max.si())) {
    return out.refuse(Refusal(
        fmt::format("{:.4g} N/s, the frame's force loop follows {:.4g} N/s", r, loop.rate_max.si()),
        at_most(rate, loop.rate_max.si(), protocol_)));
  }
  const double from = force_ + below_N_, felt = force + below_N_;
  double worst = forecast_.ramp_N(from, felt, r);
  if (exceeds(worst, limit) && can_be_measured()) {
    worst = forecast_.ramp_if_measured_N(from, felt, r).value_or(worst);
    add_note(out.note, "if the stiffness that is measured at contact allows it");
  }
  add_note(out.note, fmt::format("{:.3g} N at worst", worst));
  if (!exceeds(worst, limit)) return foresee(worst, loop.approach.si());
  const double fastest = forecast_.fastest_ramp_N_s(felt, limit);
  const std::string why = fmt::format(
      "{:.4g} N/s to {:.4g} N may end at {:.3g} N, the limit is {:.4g} N", r, force, worst, limit);
  if (fastest > 0 && fastest < r) {
    return out.refuse(Refusal(fmt::format("{}: at most {:.3g} N/s", why, fastest),
                              at_most(rate, fastest, protocol_)));
  }
  if (fastest <= 0) {
    return out.refuse(Refusal(
        why + ": a held force may be off by its ripple",
        at_most(to.value,
                env_.get(to.value) * (limit - below_N_ - loop.ripple.si()) / std::max(force, 1e-9),
                protocol_)));
  }
  out.refuse(
      Refusal(fmt::format("{}: the frame approaches with {:.3g} mm/s by itself; press the "
                          "specimen with move_until first, or use speed_mm_s",
                          why, loop.approach.si() * 1e3)));
}

Planner::Outcome Planner::on(const HoldStep& s) {
  Outcome out;
  out.seconds = env_.get(s.duration);
  const bool loop = s.mode == HoldMode::force && !rig_.frame.weights;
  const double before = force_;
  const double force = s.at ? target_force_N(*s.at, env_, rig_) : force_;
  if (s.at) {
    add_note(out.note, fmt::format("holds {:.4g} N", force));
    go_to_travel(travel_at(force), nullptr, out);
    go_to_force(force, &s.at->value, out);
  }
  if (loop) check_loop(force, out);
  if (!loop || out.why) return out;
  const ForceLoop& l = *rig_.frame.force_loop;
  const double worst = std::max(force, before) + below_N_ + l.ripple.si() +
                       (force > before ? l.rate_max.si() * to_seconds(l.lag) : 0);
  if (!exceeds(worst, limits_.force_max_N)) {
    foresee(worst, 0);
    return out;
  }
  out.refuse(Refusal(
      fmt::format("holding {:.4g} N may end at {:.3g} N, the limit is {:.4g} N: ramp to the force "
                  "first, or hold the travel",
                  force, worst, limits_.force_max_N)));
  return out;
}

}  // namespace lcrig
