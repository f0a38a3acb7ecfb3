// SPDX-License-Identifier: Apache-2.0
#include "protocols/planner.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/expand.hpp"

namespace lcrig {

namespace {

constexpr double kAssumedGap_m = 3e-3;
constexpr double kOperator_s = 15;  // to place a mass and confirm
constexpr double kZero_s = 1;
constexpr double kSetLcr_s = 0.5;  // settings, each read back
constexpr std::int64_t kVisitsMax = 2'000'000;

void add_note(std::string& note, const std::string& text) {
  note += (note.empty() ? "" : "; ") + text;
}

}  // namespace

Planner::Planner(const Protocol& protocol, Environment environment, const Rig& rig,
                 const BoundLimits& limits, const ApertureChoice& choice)
    : protocol_(protocol), env_(std::move(environment)), rig_(rig), limits_(limits) {
  lcr_ = protocol.sample.lcr;
  lcr_.aperture = choice.aperture;
  plan_.lcr = lcr_;
  plan_.aperture_note = choice.note;
  contact_ = rig.contact_travel ? rig.contact_travel->si() : 0;
  travel_ = contact_ - (rig.start_gap ? rig.start_gap->si() : kAssumedGap_m);
  gap_known_ = rig.start_gap.has_value();
}

void Planner::refuse(const std::string& pointer, const std::string& id, std::string why) {
  if (!refused_) refused_ = Refused{pointer, id, std::move(why)};
}

void Planner::assume(const std::string& text) {
  if (std::ranges::find(plan_.assumptions, text) == plan_.assumptions.end()) {
    plan_.assumptions.push_back(text);
  }
}

void Planner::check_start() {
  if (const auto why = check_lcr(lcr_, rig_.lcr)) refuse("/sample/lcr", "sample", *why);
  const double rate = protocol_.sample.frame_rate_Hz, most = rig_.frame.sample_rate_max_Hz;
  if (most > 0 && rate > most) {
    refuse("/sample/frame", "sample",
           fmt::format("{:.6g} samples per second, the frame sends at most {:.6g}", rate, most));
  }
}

void Planner::walk() {
  check_start();
  if (refused_ || !walk_steps(protocol_.steps, false)) return;
  if (!walk_steps(protocol_.finally_steps, true)) return;
  if (moved_ && !rig_.compression_m) {
    assume("no specimen stated: compression and overshoot are not predicted");
  }
  if (moved_ && !rig_.contact_travel) {
    assume("no contact travel stated: travel is counted from contact");
  }
}

bool Planner::walk_steps(const Steps& steps, bool in_finally) {
  StepCursor cursor(steps, env_);
  double begun = plan_.duration_s;
  while (const Step* step = cursor.next()) {
    if (++visits_ > kVisitsMax) {
      refuse(step->pointer, step->id,
             fmt::format("more than {} steps in all, expected fewer repeats", kVisitsMax));
      return false;
    }
    Outcome outcome = visit(*step);
    if (outcome.why) {
      refuse(step->pointer, step->id, *outcome.why);
      return false;
    }
    account(*step, outcome, in_finally);
  }
  const double took = plan_.duration_s - begun, most = to_seconds(protocol_.finally_timeout);
  if (in_finally && took > most) {
    refuse("/finally", "finally",
           fmt::format("takes {:.4g} s, finally_timeout_s is {:.4g}", took, most));
  }
  return !refused_;
}

void Planner::account(const Step& step, const Outcome& outcome, bool in_finally) {
  const auto [it, is_new] = row_of_.try_emplace(step.id, plan_.steps.size());
  if (is_new) {
    PlannedStep row;
    row.id = step.id;
    row.kind = kind_of(step);
    row.start_s = plan_.duration_s;
    row.duration_s = outcome.seconds;
    row.note = outcome.note;
    row.in_finally = in_finally;
    plan_.steps.push_back(std::move(row));
  }
  PlannedStep& row = plan_.steps[it->second];
  ++row.times;
  row.total_s += outcome.seconds;
  plan_.duration_s += outcome.seconds;
}

Planner::Outcome Planner::visit(const Step& step) {
  if (auto why = check_capability(step, rig_.frame)) {
    Outcome out;
    out.why = std::move(why);
    return out;
  }
  return std::visit([this](const auto& action) { return on(action); }, step.action);
}

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

double Planner::stiffness_at(double force) const {
  if (!rig_.compression_m || force <= 0) return 0;
  const double h = 0.01 * force;
  const double ds = rig_.compression_m(force + h) - rig_.compression_m(force - h);
  return ds > 0 ? 2 * h / ds : 0;
}

std::optional<double> loaded_time_s(double force, double speed, const Rig& rig) {
  if (!rig.compression_m || force <= 0) return std::nullopt;
  return rig.compression_m(force) / speed;
}

void Planner::go_to_travel(double travel, Outcome& out) {
  if (!out.why) out.why = check_travel(travel, limits_, rig_);
  if (!moved_) plan_.travel_min_m = plan_.travel_max_m = travel_;
  moved_ = true;
  travel_ = travel;
  plan_.travel_min_m = std::min(plan_.travel_min_m, travel);
  plan_.travel_max_m = std::max(plan_.travel_max_m, travel);
}

void Planner::go_to_force(double force, Outcome& out) {
  if (!out.why) out.why = check_force(force, limits_, rig_);
  force_ = force;
  plan_.peak_force_N = std::max(plan_.peak_force_N, force);
}

void Planner::check_overshoot(double force, double speed, std::optional<double> allowed,
                              Outcome& out) {
  const double k = stiffness_at(force);
  if (k <= 0 || out.why) return;
  const double over = predicted_overshoot_N(k, speed, rig_.frame);
  plan_.overshoot_N = std::max(plan_.overshoot_N, over);
  add_note(out.note, fmt::format("overshoot {:.2g} N predicted ({:.3g} N/mm)", over, k * 1e-3));
  const std::string sum =
      fmt::format("{:.4g} mm/s on {:.3g} N/mm overshoots by {:.3g} N", speed * 1e3, k * 1e-3, over);
  if (allowed && over > *allowed) {
    out.why =
        fmt::format("{}, the step allows {:.3g} N: use a slower (final) speed", sum, *allowed);
  } else if (force + over > limits_.force_max_N) {
    out.why = fmt::format("{} beyond {:.4g} N, the limit is {:.4g} N: use a slower (final) speed",
                          sum, force, limits_.force_max_N);
  }
}

void Planner::check_timeout(const Number& timeout, Outcome& out) {
  const double most = env_.get(timeout);
  if (!out.why && out.seconds > most) {
    out.why = fmt::format("takes {:.4g} s ({}), timeout_s is {:.4g}", out.seconds, out.note, most);
  }
}

void Planner::travel_move(const Target& to, double speed, Outcome& out) {
  const double value = env_.get(to.value);
  if (to.kind == TargetKind::gap && !gap_known_) {
    out.why = "a gap before find_contact, and no gap was stated: find the contact first";
    return;
  }
  const double target = to.kind == TargetKind::gap ? contact_ - value : value;
  const double way = std::abs(target - travel_);
  out.seconds = way / speed;
  add_note(out.note, fmt::format("{:.4g} mm at {:.4g} mm/s", way * 1e3, speed * 1e3));
  go_to_travel(target, out);
  go_to_force(force_at(target), out);
}

void Planner::force_move(double force, double speed, Outcome& out) {
  const double target = travel_at(force);
  const double way = std::abs(target - travel_);
  out.seconds = way / speed;
  add_note(out.note,
           fmt::format("{:.4g} mm at {:.4g} mm/s to {:.4g} N", way * 1e3, speed * 1e3, force));
  go_to_travel(target, out);
  go_to_force(force, out);
}

Planner::Outcome Planner::on(const ZeroStep& s) {
  Outcome out;
  out.seconds = kZero_s;
  if (s.travel) {
    contact_ -= travel_;
    travel_ = 0;
  }
  if (s.force) force_ = 0;
  return out;
}

Planner::Outcome Planner::on(const FindContactStep& s) {
  Outcome out;
  const double speed = env_.get(s.speed), rise = env_.get(s.force), back = env_.get(s.back_off);
  out.why = check_speed(speed, limits_, rig_);
  const double approach = std::max(0.0, contact_ - travel_);
  if (!gap_known_ && approach > 0) {
    add_note(out.note, fmt::format("assumes a gap of {:.3g} mm", approach * 1e3));
  }
  out.seconds = (approach + back) / speed;
  go_to_travel(travel_at(rise), out);
  go_to_force(rise, out);
  check_overshoot(rise, speed, std::nullopt, out);
  check_timeout(s.timeout, out);
  go_to_travel(contact_ - back, out);
  force_ = 0;
  gap_known_ = true;
  return out;
}

Planner::Outcome Planner::on(const RampStep& s) {
  Outcome out;
  if (s.speed) {
    const double speed = env_.get(*s.speed);
    out.why = check_speed(speed, limits_, rig_);
    if (is_force_target(s.to)) {
      const double force = target_force_N(s.to, env_, rig_);
      const bool loading = force > force_;
      force_move(force, speed, out);
      if (loading) check_overshoot(force, speed, std::nullopt, out);
    } else {
      travel_move(s.to, speed, out);
    }
  } else {
    const double force = target_force_N(s.to, env_, rig_), rate = env_.get(*s.force_rate);
    out.seconds = std::abs(force - force_) / rate;
    add_note(out.note, fmt::format("{:.4g} N to {:.4g} N at {:.4g} N/s", force_, force, rate));
    // The force loop closes the gap first, at a speed of its own.
    go_to_travel(travel_at(force), out);
    go_to_force(force, out);
  }
  check_timeout(s.timeout, out);
  return out;
}

Planner::Outcome Planner::on(const MoveUntilStep& s) {
  Outcome out;
  const double speed = env_.get(s.speed);
  out.why = check_speed(speed, limits_, rig_);
  if (!is_force_target(s.until)) {
    travel_move(s.until, speed, out);
    check_timeout(s.timeout, out);
    return out;
  }
  const double force = target_force_N(s.until, env_, rig_);
  const bool loading = force > force_;
  const double from = travel_;
  force_move(force, speed, out);
  double last_speed = speed;
  if (s.final_speed) {
    last_speed = env_.get(*s.final_speed);
    if (!out.why) out.why = check_speed(last_speed, limits_, rig_);
    const double turn = travel_at(env_.get(*s.final_from) * force);
    const double slow = std::min(std::abs(travel_ - from), std::abs(travel_ - turn));
    out.seconds += slow / last_speed - slow / speed;
  }
  if (const auto t = loaded_time_s(force, speed, rig_); loading && t && !s.final_speed) {
    const double each = to_seconds(rig_.lcr.conversion_time(lcr_));
    add_note(out.note, fmt::format("loaded for {:.3g} s: {:.0f} readings of {:.0f} ms", *t,
                                   std::floor(*t / each), each * 1e3));
  }
  const auto allowed = s.overshoot ? std::optional(env_.get(*s.overshoot)) : std::nullopt;
  if (loading) check_overshoot(force, last_speed, allowed, out);
  check_timeout(s.timeout, out);
  return out;
}

Planner::Outcome Planner::on(const HoldStep& s) {
  Outcome out;
  out.seconds = env_.get(s.duration);
  if (!s.at) return out;
  const double force = target_force_N(*s.at, env_, rig_);
  add_note(out.note, fmt::format("holds {:.4g} N", force));
  go_to_travel(travel_at(force), out);
  go_to_force(force, out);
  return out;
}

Planner::Outcome Planner::on(const MeasureStep& s) {
  Outcome out;
  const auto count = std::llround(env_.get(s.count));
  const double within = env_.get(s.within);
  out.seconds = within;
  out.why = check_measure(count, within, lcr_, rig_.lcr);
  out.note = fmt::format(
      "{} readings in {:.4g} s need a conversion of at most {:.0f} ms; aperture "
      "{} takes {:.0f} ms",
      count, within, std::floor(within / static_cast<double>(count) * 1e3),
      to_string(lcr_.aperture), to_seconds(rig_.lcr.conversion_time(lcr_)) * 1e3);
  plan_.measure_readings += count;
  return out;
}

Planner::Outcome Planner::on(const PlaceWeightStep& s) {
  Outcome out;
  out.seconds = kOperator_s;
  const double force =
      s.mass ? env_.get(*s.mass) * rig_.gravity_m_s2 : target_force_N(*s.load, env_, rig_);
  out.note = fmt::format("{:.4g} g = {:.4g} N; about {:.0f} s for the operator",
                         force / rig_.gravity_m_s2 * 1e3, force, kOperator_s);
  go_to_force(force, out);
  return out;
}

Planner::Outcome Planner::on(const RecordStep& s) {
  Outcome out;
  out.seconds = env_.get(s.until_confirmed ? s.timeout : *s.duration);
  if (s.until_confirmed) out.note = "until confirmed, at most this long";
  return out;
}

Planner::Outcome Planner::on(const SetLcrStep& s) {
  Outcome out;
  out.seconds = kSetLcr_s;
  if (s.frequency) lcr_.frequency = Frequency::from_si(env_.get(*s.frequency));
  if (s.level) lcr_.level = Voltage::from_si(env_.get(*s.level));
  if (s.bias) lcr_.bias = Voltage::from_si(env_.get(*s.bias));
  if (s.bias_off) lcr_.bias.reset();
  if (s.average) lcr_.average = static_cast<int>(std::lround(env_.get(*s.average)));
  if (s.aperture) lcr_.aperture = *s.aperture;
  if (s.function) lcr_.function = *s.function;
  if (s.trigger) lcr_.trigger = *s.trigger;
  if (lcr_.trigger == LcrTrigger::bus) lcr_.poll_interval.reset();
  out.why = check_lcr(lcr_, rig_.lcr);
  return out;
}

}  // namespace lcrig
