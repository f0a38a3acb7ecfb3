// SPDX-License-Identifier: Apache-2.0
// What the steps that move the frame, or hold a force, may do to the specimen.
#include <algorithm>
#include <cmath>
#include <limits>

#include "protocols/expand.hpp"
#include "protocols/file/words.hpp"
#include "protocols/plan/planner.hpp"

namespace lcrig {

namespace {

constexpr const char* kNoHelp =
    "no change of the protocol can help: state frame.stiffness_N_mm in the config if the frame is "
    "softer than rigid, or use one that stops sooner";

}  // namespace

double Planner::travel_at(double force) const {
  return contact_ + (rig_.compression_m && force > 0 ? rig_.compression_m(force) : 0);
}

// Largest force the limits know, doubled, bounds the search: beyond it the answer is "too much".
double Planner::force_at(double travel) const {
  if (!rig_.compression_m || travel <= contact_) return 0;
  double low = 0, high = 2 * std::max(std::abs(limits_.force_max_N), 1e-3);
  if (travel_at(high) <= travel) return high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (travel_at(middle) < travel ? low : high) = middle;
  }
  return high;
}

std::optional<double> loaded_time_s(double force, double speed, const Rig& rig) {
  if (!rig.compression_m || force <= 0) return std::nullopt;
  return rig.compression_m(force) / speed;
}

void Planner::go_to_travel(double travel, const Target* to, Outcome& out) {
  const double gap = contact_ - travel;
  const bool is_gap = to != nullptr && to->kind == TargetKind::gap;
  // The end of a window is a travel.
  const auto suggest = [&](double end) {
    if (to == nullptr) return std::vector<Change>();
    const double value = is_gap ? contact_ - end : end;
    return (travel > end) == is_gap ? at_least(to->value, value, protocol_)
                                    : at_most(to->value, value, protocol_);
  };
  // Before contact was found nobody knows its gap, nor where its travel is from there on.
  const bool absolute = rig_.start_travel || rig_.expected_contact;
  if (contact_state_ != Contact::unknown && limits_.gap_min_m && !placed_ &&
      (exceeds(*limits_.gap_min_m, gap) || exceeds(gap, *limits_.gap_max_m))) {
    const double end =
        contact_ - (gap < *limits_.gap_min_m ? *limits_.gap_min_m : *limits_.gap_max_m);
    out.refuse(Refusal(fmt::format("a gap of {:.4g} mm, the limits allow {:.4g} to {:.4g} mm",
                                   gap * 1e3, *limits_.gap_min_m * 1e3, *limits_.gap_max_m * 1e3),
                       suggest(end)));
  }
  const bool given = to != nullptr && !is_gap;
  if (placed_ || (given && absolute) || rig_.expected_contact) {
    if (const auto no = check_travel(travel, limits_, rig_)) {
      out.refuse(Refusal(no->why, suggest(no->end)));
    }
  }
  if (!moved_) plan_.travel_min_m = plan_.travel_max_m = travel_;
  moved_ = true;
  travel_ = travel;
  plan_.travel_min_m = std::min(plan_.travel_min_m, travel);
  plan_.travel_max_m = std::max(plan_.travel_max_m, travel);
}

void Planner::go_to_force(double force, const Number* given, Outcome& out) {
  if (const auto no = check_force(force, limits_, rig_)) {
    std::vector<Change> changes;
    // A pressure is stated over the area of the tip.
    const bool in_N = given != nullptr && rig_.probe_area.si() > 0 &&
                      std::abs(env_.get(*given) - force) <= 1e-9 * std::abs(force);
    const double unit = in_N ? 1 : rig_.probe_area.si();
    if (given != nullptr && unit > 0) changes = at_most(*given, no->end / unit, protocol_);
    out.refuse(Refusal(no->why, std::move(changes)));
  }
  force_ = force;
  plan_.peak_force_N = std::max(plan_.peak_force_N, force);
}

void Planner::use_speed(const Number& speed, Outcome& out) {
  const double v = env_.get(speed);
  fastest_m_s_ = std::max(fastest_m_s_, v);
  const auto no = check_speed(v, limits_, rig_);
  if (!no) return;
  out.refuse(Refusal(no->why, v > no->end ? at_most(speed, no->end, protocol_)
                                          : at_least(speed, no->end, protocol_)));
}

void Planner::foresee(double worst_N, double speed) {
  plan_.worst_force_N = std::max(plan_.worst_force_N, worst_N);
  pressed_m_s_ = std::max(pressed_m_s_, speed);
  // Nobody needs the host for the stop: the device watches force and travel by itself.
  plan_.lost_force_N = std::max(plan_.lost_force_N, worst_N);
  plan_.lost_way_m = std::max(plan_.lost_way_m, speed > 0 ? forecast_.lost_way_m(speed) : 0);
}

Refusal Planner::too_fast(const std::string& why, const Number& speed, double fastest,
                          const Number* timeout) {
  if (!forecast_.bound().is_bounded()) {
    return Refusal(why +
                   ", for nothing bounds how stiff specimen and frame are: state "
                   "frame.stiffness_N_mm in the config, or name a specimen whose file has its "
                   "materials; no change of the protocol can help");
  }
  if (fastest <= 0 || fastest < rig_.frame.speed_min.si()) {
    return Refusal(why + ", and no speed of this frame is slow enough: " + kNoHelp);
  }
  auto changes = at_most(speed, fastest, protocol_);
  if (!changes.empty() && timeout != nullptr) {
    const double to_si = changes.front().parameter
                             ? protocol_.parameters.at(changes.front().place).to_si
                             : speed.to_si;
    const double needed = way_ / (changes.front().value * to_si) + kSearchStop_s;
    if (needed > env_.get(*timeout)) {
      for (Change& c : at_least(*timeout, 1.05 * needed, protocol_)) changes.push_back(c);
    }
  }
  return Refusal(fmt::format("{}: at most {:.3g} mm/s", why, fastest * 1e3), std::move(changes));
}

// A motion that the device stops at a force: where it ends on the stiffest contact that is
// possible, and on the one that the specimen's model expects.
void Planner::check_stop(double felt, const Number& speed, const std::optional<Number>& allowed,
                         const Number& timeout, Outcome& out) {
  const double v = env_.get(speed), limit = limits_.force_max_N;
  const auto [it, is_new] = stops_.try_emplace({felt, v}, 0);
  if (is_new) it->second = forecast_.stop_N(felt, v);
  double worst = it->second;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double measured =
      can_be_measured() ? forecast_.stop_if_measured_N(felt, v).value_or(kNone) : kNone;
  if (exceeds(worst, limit) && !exceeds(measured, limit)) {
    worst = measured;
    add_note(out.note, "if the stiffness that is measured at contact allows it");
    assume(
        fmt::format("beyond contact at most {:.3g} times as stiff as expected; measured at "
                    "contact, else nothing is pressed faster than the stiffest contact allows",
                    Forecast::growth_margin()));
  }
  if (exceeds(worst, limit)) {
    const double fastest = can_be_measured()
                               ? std::max(forecast_.fastest_m_s(felt, limit),
                                          forecast_.fastest_if_measured_m_s(felt, limit))
                               : forecast_.fastest_m_s(felt, limit);
    const std::string why = fmt::format(
        "{:.4g} mm/s to {:.4g} N may end at {:.3g} N on a contact of up to {:.3g} N/mm, "
        "the limit is {:.4g} N",
        v * 1e3, felt, worst, forecast_.bound().stiffness_N_m(worst) * 1e-3, limit);
    out.refuse(too_fast(why, speed, fastest, &timeout));
  }
  add_note(out.note, fmt::format("{:.3g} N at worst", worst));
  check_expected(felt, speed, allowed, timeout, out);
  if (!out.why) foresee(worst, v);
}

// The step's own allowance is judged by what is expected, or, without a model, by the worst.
void Planner::check_expected(double force, const Number& speed,
                             const std::optional<Number>& allowed, const Number& timeout,
                             Outcome& out) {
  const double v = env_.get(speed);
  const auto expected = forecast_.expected_stop_N(force, v);
  const double end = expected ? *expected : forecast_.stop_N(force, v);
  if (expected) plan_.overshoot_N = std::max(plan_.overshoot_N, end - force);
  if (!allowed || !exceeds(end - force, env_.get(*allowed))) return;
  const double most = force + env_.get(*allowed);
  const double fastest =
      expected ? forecast_.expected_fastest_m_s(force, most) : forecast_.fastest_m_s(force, most);
  const std::string why =
      fmt::format("{:.4g} mm/s overshoots by {:.3g} N, the step allows {:.3g} N", v * 1e3,
                  end - force, env_.get(*allowed));
  out.refuse(too_fast(why, speed, fastest, &timeout));
}

// A travel inside the specimen. The device is told to stop at a force from which it cannot go
// beyond the limit, and that must be more than the travel is expected to take.
void Planner::check_pressing(double depth, double expected_N, const Number& speed, Outcome& out) {
  const double v = env_.get(speed), limit = limits_.force_max_N;
  // Gap zero is where the search stood, which is pressed already.
  const double worst = forecast_.bound().force_after_N(contact_N_, depth);
  if (!exceeds(worst, limit)) return foresee(worst, v);
  const double needed =
      1.2 * expected_N + least_trip_N(rig_.frame, force_noise_N(rig_).value_or(0));
  if (forecast_.trip_N(v, limit) >= needed) return foresee(limit, v);
  const std::string why = fmt::format(
      "{:.4g} mm/s, {:.4g} um deep into the specimen: a stop at {:.3g} N may end beyond the limit "
      "of "
      "{:.4g} N",
      v * 1e3, depth * 1e6, needed, limit);
  out.refuse(too_fast(why, speed, forecast_.fastest_m_s(needed, limit), nullptr));
}

// Towards a specimen that may be anywhere: the device stops at a force of its own, which must be
// above its noise and early enough.
void Planner::check_blind(const Number& speed, Outcome& out) {
  const double v = env_.get(speed), limit = limits_.force_max_N,
               trip = least_trip_N(rig_.frame, force_noise_N(rig_).value_or(0));
  add_note(out.note, "towards a specimen that may be anywhere");
  if (forecast_.trip_N(v, limit) >= trip) return foresee(limit, v);
  const std::string why = fmt::format(
      "{:.4g} mm/s towards a specimen whose place is not known yet: a stop at {:.3g} N may end at "
      "{:.3g} N, the limit is {:.4g} N; find_contact first, state the gap (set_gap), or go slower",
      v * 1e3, trip, forecast_.stop_N(trip, v), limit);
  out.refuse(too_fast(why, speed, forecast_.fastest_m_s(trip, limit), nullptr));
}

void Planner::check_timeout(const Number& timeout, Outcome& out) {
  const double most = env_.get(timeout);
  if (out.why || out.seconds <= most) return;
  out.refuse(
      Refusal(fmt::format("takes {:.4g} s ({}), timeout_s is {:.4g}", out.seconds, out.note, most),
              at_least(timeout, 1.02 * out.seconds, protocol_)));
}

void Planner::travel_move(const Target& to, const Number& speed, Outcome& out) {
  const double value = env_.get(to.value), v = env_.get(speed);
  const bool is_gap = to.kind == TargetKind::gap;
  if (is_gap && contact_state_ == Contact::unknown) {
    return out.refuse(
        Refusal("a gap before find_contact, and no gap was stated: find the contact first, or "
                "state the gap "
                "(set_gap, or frame.start_gap_mm in the config)"));
  }
  const double target = is_gap ? contact_ - value : value;
  way_ = std::abs(target - travel_);
  out.seconds = way_ / v;
  add_note(out.note, fmt::format("{:.4g} mm at {:.4g} mm/s", way_ * 1e3, v * 1e3));
  // Of a specimen that may be anywhere nothing is expected: its gap is a guess, made for times.
  const bool somewhere = contact_state_ != Contact::unknown || rig_.expected_contact;
  const double expected = somewhere ? force_at(target) : 0;
  const bool comparable = is_gap || placed_ || rig_.start_travel;
  const bool away = comparable && target <= travel_;
  if (!away && contact_state_ == Contact::unknown) {
    check_blind(speed, out);
  } else if (!away && (is_gap || placed_)) {
    if (target > contact_) check_pressing(target - contact_, expected, speed, out);
  } else if (!is_gap && !placed_ && contact_state_ == Contact::found) {
    add_note(out.note, "checked when the contact was found");
  }
  go_to_travel(target, &to, out);
  if (const auto no = check_force(expected, limits_, rig_)) {
    const double end = travel_at(no->end);
    out.refuse(Refusal(no->why, is_gap ? at_least(to.value, contact_ - end, protocol_)
                                       : at_most(to.value, end, protocol_)));
  }
  go_to_force(expected, nullptr, out);
}

void Planner::force_move(const Target& to, const Number& speed, Outcome& out) {
  const double force = target_force_N(to, env_, rig_), v = env_.get(speed);
  const double target = travel_at(force);
  way_ = std::abs(target - travel_);
  out.seconds = way_ / v;
  add_note(out.note,
           fmt::format("{:.4g} mm at {:.4g} mm/s to {:.4g} N", way_ * 1e3, v * 1e3, force));
  go_to_travel(target, nullptr, out);
  go_to_force(force, &to.value, out);
}

Planner::Outcome Planner::on(const RampStep& s) {
  Outcome out;
  if (s.speed) {
    use_speed(*s.speed, out);
    if (is_force(s.to)) {
      const double force = target_force_N(s.to, env_, rig_);
      const bool loading = force > force_;
      force_move(s.to, *s.speed, out);
      if (loading) check_stop(force + below_N_, *s.speed, std::nullopt, s.timeout, out);
    } else {
      travel_move(s.to, *s.speed, out);
    }
  } else {
    const double force = target_force_N(s.to, env_, rig_), rate = env_.get(*s.force_rate);
    check_ramp(force, s.to, *s.force_rate, out);
    out.seconds = std::abs(force - force_) / rate;
    add_note(out.note, fmt::format("{:.4g} N to {:.4g} N at {:.4g} N/s", force_, force, rate));
    // The force loop closes the gap first, at a speed of its own.
    const double gap = force_ > 0 ? 0 : contact_ - travel_;
    const auto& loop = rig_.frame.force_loop;
    if (loop && loop->approach.si() > 0 && gap > 0) out.seconds += gap / loop->approach.si();
    go_to_travel(travel_at(force), nullptr, out);
    go_to_force(force, &s.to.value, out);
  }
  check_timeout(s.timeout, out);
  return out;
}

Planner::Outcome Planner::on(const MoveUntilStep& s) {
  Outcome out;
  use_speed(s.speed, out);
  if (!is_force(s.until)) {
    travel_move(s.until, s.speed, out);
    check_timeout(s.timeout, out);
    return out;
  }
  const double force = target_force_N(s.until, env_, rig_), speed = env_.get(s.speed);
  const bool loading = force > force_;
  const double from = travel_;
  force_move(s.until, s.speed, out);
  const Number& last = s.final_speed ? *s.final_speed : s.speed;
  if (s.final_speed) {
    use_speed(last, out);
    const double turn = travel_at(env_.get(*s.final_from) * force);
    const double slow = std::min(std::abs(travel_ - from), std::abs(travel_ - turn));
    out.seconds += slow / env_.get(last) - slow / speed;
    if (loading)
      check_stop(env_.get(*s.final_from) * force + below_N_, s.speed, std::nullopt, s.timeout, out);
  }
  if (const auto t = loaded_time_s(force, speed, rig_); loading && t && !s.final_speed) {
    const double each = to_seconds(rig_.lcr.conversion_time(lcr_));
    add_note(out.note, fmt::format("loaded for {:.3g} s: {:.0f} readings of {:.0f} ms", *t,
                                   std::floor(*t / each), each * 1e3));
  }
  if (loading) check_stop(force + below_N_, last, s.overshoot, s.timeout, out);
  check_timeout(s.timeout, out);
  return out;
}

}  // namespace lcrig
