// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/planned_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr const char* kNoHelp =
    "no change of the protocol can help: state frame.stiffness_N_mm in the config if the frame is "
    "softer than rigid, or use one that stops sooner";

// The value with enough digits to differ visibly from the limit.
std::string more_than(double limit, double value) {
  const bool is_seen = fmt::format("{:.3g}", value) != fmt::format("{:.3g}", limit);
  return is_seen ? fmt::format("{:.3g}", value) : fmt::format("{:.6g}", value);
}

}  // namespace

Refusal PlannedMotion::too_fast(const std::string& why, const Number& speed, double fastest,
                                bool may_take_longer) {
  if (!rig_.forecast().bound().is_bounded()) {
    return Refusal(why +
                   ", for nothing bounds how stiff specimen and frame are: state "
                   "frame.stiffness_N_mm in the config, or name a specimen whose file has its "
                   "materials; no change of the protocol can help");
  }
  if (fastest <= 0 || fastest < rig_.frame().speed_min.si()) {
    return Refusal(why + ", and no speed of this frame is slow enough: " + kNoHelp);
  }
  auto changes = at_most(speed, fastest, rig_.asked());
  if (!changes.empty() && may_take_longer) {
    const double to_si = changes.front().parameter
                             ? rig_.protocol().parameters.at(changes.front().place).to_si
                             : speed.to_si;
    const double needed = way_m_ / (changes.front().value * to_si) + kSearchStop_s;
    if (needed > rig_.get(timeout_)) {
      for (Change& c : at_least(timeout_, 1.05 * needed, rig_.asked())) changes.push_back(c);
    }
  }
  return Refusal(fmt::format("{}: at most {:.3g} mm/s", why, fastest * 1e3), std::move(changes));
}

Refusal PlannedMotion::too_strong(const std::string& why, double felt, const Number& speed,
                                  const Number& target) {
  const double most = rig_.proposed_end_N(), none = rig_.felt_N(0);
  const double v = speed_of(speed), slowest = std::max(rig_.frame().speed_min.si(), 1e-6);
  const auto largest = [&](double speed_m_s) {
    double good = none, bad = felt;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (good + bad);
      (exceeds(rig_.stop_N(middle, speed_m_s), most) ? bad : good) = middle;
    }
    return good;
  };
  // If this speed leaves almost none of the force, the speed would have to change next. The advice
  // then assumes a slower one.
  double good = largest(v);
  if (good - none < 0.5 * (felt - none)) good = largest(std::min(v, slowest));
  const double share = (good - none) / (felt - none);
  if (!(share > 0)) return too_fast(why, speed, 0, true);
  return Refusal(fmt::format("{}: at most {:.4g} N, or a higher limit", why, good - none),
                 at_most(target, share * rig_.get(target), rig_.asked()));
}

// Checks a motion that the device stops at a force: where it ends on the stiffest possible contact,
// and on the one that the specimen's model expects.
void PlannedMotion::check_stop(double felt, const Number& speed,
                               const std::optional<Number>& allowed, const Number* target) {
  const double v = speed_of(speed), limit = rig_.limits().force_max_N, most = rig_.largest_end_N();
  double worst = rig_.stop_N(felt, v);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double measured =
      rig_.can_be_measured() ? rig_.forecast().stop_if_measured_N(felt, v).value_or(kNone) : kNone;
  if (exceeds(worst, most) && !exceeds(measured, most)) {
    worst = measured;
    add_remark(out_.note, "if the stiffness that is measured at contact allows it");
    rig_.assume(
        fmt::format("beyond contact at most {:.3g} times as stiff as expected; measured at "
                    "contact, else nothing is pressed faster than the stiffest contact allows",
                    Forecast::growth_margin()));
  }
  if (exceeds(worst, most)) {
    const double end = rig_.proposed_end_N();
    const double fastest = rig_.can_be_measured()
                               ? std::max(rig_.forecast().fastest_m_s(felt, end),
                                          rig_.forecast().fastest_if_measured_m_s(felt, end))
                               : rig_.forecast().fastest_m_s(felt, end);
    const std::string why = fmt::format(
        "{:.4g} mm/s to {:.4g} N may end at {} N on a contact of up to {:.3g} N/mm, "
        "{}",
        v * 1e3, felt, more_than(limit, worst), rig_.forecast().bound().stiffness_N_m(worst) * 1e-3,
        rig_.limit_text());
    const bool is_too_slow = fastest <= 0 || fastest < rig_.frame().speed_min.si();
    out_.refuse(target && is_too_slow && rig_.forecast().bound().is_bounded()
                    ? too_strong(why, felt, speed, *target)
                    : too_fast(why, speed, fastest, true));
  }
  add_remark(out_.note, fmt::format("{:.3g} N at worst", worst));
  check_expected(felt, speed, allowed);
  if (!out_.why) rig_.foresee(worst, v);
}

// The step's own allowance is compared with the expected overshoot, or with the worst one if there
// is no model.
void PlannedMotion::check_expected(double force, const Number& speed,
                                   const std::optional<Number>& allowed) {
  const double v = speed_of(speed);
  const auto expected = rig_.forecast().expected_stop_N(force, v);
  const double end = expected ? *expected : rig_.forecast().stop_N(force, v);
  if (expected) rig_.expect_overshoot(end - force);
  if (!allowed || !exceeds(end - force, rig_.get(*allowed))) return;
  const double most = force + rig_.get(*allowed);
  const double fastest = expected ? rig_.forecast().expected_fastest_m_s(force, most)
                                  : rig_.forecast().fastest_m_s(force, most);
  const std::string why =
      fmt::format("{:.4g} mm/s overshoots by {:.3g} N, the step allows {:.3g} N", v * 1e3,
                  end - force, rig_.get(*allowed));
  out_.refuse(too_fast(why, speed, fastest, true));
}

// Checks a travel inside the specimen. The device gets a force at which it stops, so that it cannot
// exceed the limit. That force must be larger than the force that the travel is expected to need.
void PlannedMotion::check_pressing(double depth, const Target& to, const Number& speed) {
  const double v = speed_of(speed), limit = rig_.limits().force_max_N, most = rig_.largest_end_N();
  // Gap zero is where the search stood, and the specimen is pressed there already.
  const auto worst_N = [&](double deep) {
    return rig_.forecast().bound().force_after_N(rig_.contact_N(), deep);
  };
  const auto needed_N = [&](double deep) {
    return 1.2 * rig_.force_at(rig_.contact_m() + deep) +
           least_trip_N(rig_.frame(), force_noise_N(rig_.known()).value_or(0));
  };
  const double worst = worst_N(depth);
  if (!exceeds(worst, most)) return rig_.foresee(worst, v);
  const double needed = needed_N(depth), trip = rig_.forecast().trip_N(v, limit);
  if (trip >= needed) return rig_.foresee(limit, v);
  const std::string why = fmt::format(
      "{:.4g} mm/s, {:.4g} um deep into the specimen: a stop at {:.3g} N may end beyond the limit "
      "of {:.4g} N",
      v * 1e3, depth * 1e6, needed, limit);
  const double fastest = rig_.forecast().fastest_m_s(needed, limit);
  double good = 0, bad = depth;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (good + bad);
    (exceeds(worst_N(middle), rig_.proposed_end_N()) && trip < needed_N(middle) ? bad : good) =
        middle;
  }
  const bool is_too_slow = fastest <= 0 || fastest < rig_.frame().speed_min.si();
  if (!is_too_slow || !(good > 0)) return out_.refuse(too_fast(why, speed, fastest, false));
  const bool is_gap = to.kind == TargetKind::gap;
  out_.refuse(Refusal(fmt::format("{}: at most {:.3g} um deep, or a higher limit", why, good * 1e6),
                      is_gap ? at_least(to.value, -good, rig_.asked())
                             : at_most(to.value, rig_.contact_m() + good, rig_.asked())));
}

// Checks a motion towards a specimen whose place is unknown. The device stops at a force of its
// own, which must be above the noise and still early enough.
void PlannedMotion::check_blind(const Number& speed) {
  const double v = rig_.get(speed), limit = rig_.limits().force_max_N,
               trip = least_trip_N(rig_.frame(), force_noise_N(rig_.known()).value_or(0));
  add_remark(out_.note, "towards a specimen that may be anywhere");
  if (rig_.forecast().trip_N(v, limit) >= trip) return rig_.foresee(limit, v);
  const std::string why = fmt::format(
      "{:.4g} mm/s towards a specimen whose place is not known yet: a stop at {:.3g} N may end at "
      "{:.3g} N, the limit is {:.4g} N; find_contact first, state the gap (set_gap), or go slower",
      v * 1e3, trip, rig_.forecast().stop_N(trip, v), limit);
  out_.refuse(too_fast(why, speed, rig_.forecast().fastest_m_s(trip, limit), false));
}

// For a motion that ends before a specimen whose place is known. If the face has come up by more
// than that gap, the device stops at the limit of the force, and moves on for its stopping way.
void PlannedMotion::warn_of_the_face(double gap_m, double speed_m_s) {
  const double limit = rig_.limits().force_max_N;
  const double worst = rig_.forecast().stop_N(limit, speed_m_s);
  if (!exceeds(worst, limit) || !rig_.forecast().bound().is_bounded()) return;
  add_remark(out_.note,
             fmt::format("a face that has come up by more than {:.3g} mm: up to {:.3g} N",
                         gap_m * 1e3, worst));
  rig_.assume(
      "the specimen's face has not come up since its contact was found, by more than the gaps "
      "at which motions in the air end");
}

void PlannedMotion::check_timeout() {
  const double most = rig_.get(timeout_);
  if (out_.why || out_.seconds <= most) return;
  out_.refuse(Refusal(
      fmt::format("takes {:.4g} s ({}), timeout_s is {:.4g}", out_.seconds, out_.note, most),
      at_least(timeout_, 1.02 * out_.seconds, rig_.asked())));
}

void PlannedMotion::to_travel(const Target& to, const Number& speed) {
  const double value = rig_.get(to.value), v = rig_.get(speed);
  const bool is_gap = to.kind == TargetKind::gap;
  if (is_gap && rig_.contact() == PlannedRig::Contact::unknown) {
    return out_.refuse(
        Refusal("a gap before find_contact, and no gap was stated: find the contact first, or "
                "state the gap (set_gap, or frame.start_gap_mm in the config)"));
  }
  const double target = is_gap ? rig_.contact_m() - value : value;
  way_m_ = std::abs(target - rig_.travel_m());
  out_.seconds += way_m_ / v;
  add_remark(out_.note, fmt::format("{:.4g} mm at {:.4g} mm/s", way_m_ * 1e3, v * 1e3));
  // Where the place of contact is unknown, the gap is a guess for times only, and no force is
  // expected.
  const bool somewhere =
      rig_.contact() != PlannedRig::Contact::unknown || rig_.known().expected_contact;
  const double expected = somewhere ? rig_.force_at(target) : 0;
  const bool comparable = is_gap || rig_.is_placed() || rig_.known().start_travel;
  const bool away = comparable && target <= rig_.travel_m();
  if (!away && rig_.contact() == PlannedRig::Contact::unknown) {
    check_blind(speed);
  } else if (!away && (is_gap || rig_.is_placed())) {
    if (target > rig_.contact_m()) {
      check_pressing(target - rig_.contact_m(), to, speed);
    } else {
      warn_of_the_face(rig_.contact_m() - target, v);
    }
  } else if (!is_gap && !rig_.is_placed() && rig_.contact() == PlannedRig::Contact::found) {
    add_remark(out_.note, "checked when the contact was found");
  }
  rig_.go_to_travel(target, &to, out_);
  if (const auto no = check_force(expected, rig_.limits(), rig_.known())) {
    const double end = rig_.travel_at(no->end);
    out_.refuse(Refusal(no->why, is_gap ? at_least(to.value, rig_.contact_m() - end, rig_.asked())
                                        : at_most(to.value, end, rig_.asked())));
  }
  rig_.go_to_force(expected, nullptr, out_);
}

void PlannedMotion::to_force(const Target& to, const Number& speed) {
  const double force = rig_.force_of(to), v = rig_.get(speed);
  const double target = rig_.travel_at(force);
  way_m_ = std::abs(target - rig_.travel_m());
  out_.seconds += way_m_ / v;
  add_remark(out_.note,
             fmt::format("{:.4g} mm at {:.4g} mm/s to {:.4g} N", way_m_ * 1e3, v * 1e3, force));
  rig_.go_to_travel(target, nullptr, out_);
  rig_.go_to_force(force, &to.value, out_);
}

void check_force_loop(double force, const PlannedRig& rig, StepPlan& out) {
  const auto& loop = rig.frame().force_loop;
  if (!loop) {
    return out.refuse(
        Refusal("this frame does not say what bounds its force loop (its gateway has revision 1 of "
                "frame-link/1): state frame.force_loop in the config, or use speed_mm_s and hold "
                "the travel"));
  }
  if (rig.forecast().loop_can_hold(force)) return;
  if (rig.can_be_measured() && rig.forecast().loop_can_hold_if_measured(force)) {
    return add_remark(out.note, "if the stiffness that is measured at contact allows it");
  }
  out.refuse(Refusal(fmt::format(
      "the contact may be {:.3g} N/mm stiff, the frame's force loop is good for {:.3g} N/mm: use "
      "speed_mm_s and hold the travel",
      rig.forecast().bound().stiffness_N_m(force) * 1e-3, loop->stiffness_max.si() * 1e-3)));
}

}  // namespace lcrig
