// SPDX-License-Identifier: Apache-2.0
// The walk: steps in the order of execution. What motions may do is in planner_motion.cpp.
#include "protocols/plan/planner.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/expand.hpp"
#include "protocols/file/words.hpp"

namespace lcrig {

namespace {

// Of samples that come in batches, s.
constexpr double kBatch_s = 0.1;
constexpr double kAssumedGap_m = 3e-3;
constexpr double kOperator_s = 15;  // to place a mass and confirm
constexpr double kZero_s = 1;
constexpr double kSetLcr_s = 0.5;  // settings, each read back
constexpr std::int64_t kVisitsMax = 2'000'000;

}  // namespace

Planner::Planner(const Protocol& protocol, Environment environment, const Rig& rig,
                 const BoundLimits& limits, const ApertureChoice& choice)
    : protocol_(protocol),
      env_(std::move(environment)),
      rig_(rig),
      limits_(limits),
      forecast_(make_forecast(rig)) {
  lcr_ = protocol.sample.lcr;
  lcr_.aperture = choice.aperture;
  plan_.lcr = lcr_;
  // What is within the noise is none.
  const double below = -rig.rest_force_N;
  if (below > kNoiseSigmas * force_noise_N(rig).value_or(0)) below_N_ = below;
  plan_.aperture_note = choice.note;
  const auto& start = rig.start_travel;
  const double gap = rig.start_gap ? rig.start_gap->si() : kAssumedGap_m;
  // Known, expected, or counted from there.
  if (rig.start_gap) {
    contact_ = start ? start->si() + gap : 0;
    contact_state_ = Contact::stated;
    placed_ = start.has_value();
  } else if (rig.expected_contact) {
    contact_ = rig.expected_contact->si();
  } else {
    contact_ = start ? start->si() + gap : 0;
  }
  travel_ = start ? start->si() : contact_ - gap;
  if (placed_) limits_.place_contact(contact_);
}

void Planner::refuse(const std::string& pointer, const std::string& id, Refusal refusal) {
  if (refused_) return;
  refused_.emplace();
  refused_->pointer = pointer;
  refused_->id = id;
  refused_->refusal = std::move(refusal);
}

void Planner::assume(const std::string& text) {
  if (std::ranges::find(plan_.assumptions, text) == plan_.assumptions.end()) {
    plan_.assumptions.push_back(text);
  }
}

// The limits must be ones that the machine can keep.
void Planner::check_limits() {
  const Limits& l = protocol_.limits;
  for (const auto* force : {&l.force_min, &l.force_max}) {
    if (!*force) continue;
    if (const auto no = check_force_limit(env_.get(**force), rig_.frame)) {
      auto changes = force == &l.force_max ? at_most(**force, no->end, protocol_)
                                           : at_least(**force, no->end, protocol_);
      refuse("/limits", "limits", Refusal(no->why, std::move(changes)));
    }
  }
  for (const auto* travel : {&l.travel_min, &l.travel_max}) {
    if (!*travel || !rig_.frame.motion) continue;
    if (const auto no = check_travel_limit(env_.get(**travel), rig_.frame)) {
      auto changes = travel == &l.travel_max ? at_most(**travel, no->end, protocol_)
                                             : at_least(**travel, no->end, protocol_);
      refuse("/limits", "limits",
             Refusal(no->why + ": give limits of this frame, or gap_mm, which counts from contact",
                     std::move(changes)));
    }
  }
}

// A motion that nobody can watch is none that may begin.
void Planner::check_channels() {
  if (!rig_.frame.motion || !commands_frame(protocol_)) return;
  const FrameCapabilities& c = rig_.frame;
  const char* missing = !c.force_channel          ? "force"
                        : !c.travel_channel       ? "travel"
                        : !(c.force_max.si() > 0) ? "range of the load cell (force_max_N)"
                                                  : nullptr;
  if (missing == nullptr) return;
  refuse("/steps", "steps",
         Refusal(fmt::format("the frame reports no {}, and no motion can be watched without; no "
                             "change of the protocol can help",
                             missing)));
}

void Planner::check_start() {
  if (const auto why = check_lcr(lcr_, rig_.lcr)) refuse("/sample/lcr", "sample", Refusal(*why));
  const double rate = protocol_.sample.frame_rate_Hz, most = rig_.frame.sample_rate_max_Hz;
  plan_.frame_rate_Hz = rate;
  if (most > 0 && rate > most) {
    plan_.frame_rate_Hz = most;
    assume(fmt::format("{:.6g} samples per second: the frame sends no more", most));
  }
  check_limits();
  check_channels();
  if (!rig_.frame.motion || !rig_.start_travel || !commands_frame(protocol_)) return;
  if (const auto no = check_travel(rig_.start_travel->si(), limits_, rig_)) {
    refuse(
        "/limits", "limits",
        Refusal("the frame stands at " + no->why + ": drive it there first, or change the limits"));
  }
}

void Planner::walk() {
  check_start();
  if (refused_ || !walk_steps(protocol_.steps, false)) return;
  if (!walk_steps(protocol_.finally_steps, true)) return;
  finish_figures();
}

// What a cell that freezes, or a drive that turns round, has pressed when it is noticed.
void Planner::foresee_lies() {
  const WatchFigures& w = plan_.watch;
  const double period_s = plan_.frame_rate_Hz > 0 ? 1 / plan_.frame_rate_Hz : 0;
  const double heard_s = std::max(period_s, kBatch_s) + w.reply_s;
  const auto after = [&](double way_m, double speed_m_s) {
    return forecast_.bound().force_after_N(plan_.worst_force_N,
                                           way_m + stopping_way_m(rig_.frame, speed_m_s));
  };
  if (w.frozen_force_s && pressed_m_s_ > 0) {
    plan_.frozen_force_N = after(pressed_m_s_ * (*w.frozen_force_s + heard_s), pressed_m_s_);
  }
  if (fastest_m_s_ > 0) {
    plan_.reversed_force_N = after(w.against_m + fastest_m_s_ * heard_s, fastest_m_s_);
  }
}

void Planner::finish_figures() {
  plan_.travel_from_contact = moved_ && !rig_.start_travel && !rig_.expected_contact;
  ForceUncertainty& u = plan_.force_uncertainty;
  const double part = rig_.force_class_percent / 100;
  u.class_N = part * std::max(std::abs(limits_.force_min_N), std::abs(limits_.force_max_N));
  // ISO 7500-1: the zero may be off by a tenth of the class, of the largest force of the cell.
  u.zero_N = part / 10 * rig_.frame.force_max.si();
  if (const auto noise = force_noise_N(rig_)) u.noise_N = 4 * *noise;
  plan_.watch =
      watch_figures(rig_.frame, forecast_.bound(), limits_.force_max_N, plan_.frame_rate_Hz,
                    rig_.force_scatter, force_noise_N(rig_).value_or(0));
  if (!moved_) return;
  foresee_lies();
  for (const std::string& text : forecast_assumptions(rig_, forecast_)) assume(text);
  if (!rig_.compression_m) {
    assume("no specimen stated: compression and overshoot are not predicted");
  }
  if (plan_.travel_from_contact) {
    assume("no contact travel stated: travel is counted from contact");
  } else if (!placed_ && !rig_.expected_contact) {
    assume(fmt::format("contact about {:.3g} mm from where the frame stands", kAssumedGap_m * 1e3));
  }
}

bool Planner::walk_steps(const Steps& steps, bool in_finally) {
  StepCursor cursor(steps, env_);
  double begun = plan_.duration_s;
  while (const Step* step = cursor.next()) {
    if (++visits_ > kVisitsMax) {
      refuse(step->pointer, step->id,
             Refusal(fmt::format("more than {} steps in all, expected fewer repeats", kVisitsMax)));
      return false;
    }
    Outcome outcome = visit(*step);
    if (outcome.why) {
      refuse(step->pointer, step->id, std::move(*outcome.why));
      return false;
    }
    account(*step, outcome, in_finally);
  }
  const double took = plan_.duration_s - begun, most = to_seconds(protocol_.finally_timeout);
  if (in_finally && took > most) {
    refuse("/finally", "finally",
           Refusal(fmt::format("takes {:.4g} s, finally_timeout_s is {:.4g}", took, most),
                   {Change("/finally_timeout_s", std::ceil(took), false)}));
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
    out.refuse(Refusal(std::move(*why)));
    return out;
  }
  return std::visit([this](const auto& action) { return on(action); }, step.action);
}

Planner::Outcome Planner::on(const ZeroStep& s) {
  Outcome out;
  out.seconds = kZero_s;
  if (s.travel) {
    contact_ -= travel_;
    limits_.zero_travel(travel_);
    rig_.frame = with_zero_at(rig_.frame, travel_);
    for (auto* place : {&rig_.start_travel, &rig_.expected_contact, &rig_.found_contact}) {
      if (*place) *place = **place - Length::from_si(travel_);
    }
    travel_ = 0;
    contact_state_ = Contact::unknown;
    placed_ = false;
  }
  if (s.force) force_ = below_N_ = 0;
  return out;
}

Planner::Outcome Planner::on(const SetGapStep& s) {
  Outcome out;
  const double gap = env_.get(s.gap);
  contact_ = travel_ + gap;
  contact_N_ = 0;
  contact_state_ = Contact::stated;
  placed_ = rig_.start_travel.has_value();
  if (placed_) limits_.place_contact(contact_);
  add_note(out.note, fmt::format("a gap of {:.4g} mm, as the protocol says", gap * 1e3));
  return out;
}

Planner::Outcome Planner::on(const MeasureStep& s) {
  Outcome out;
  const auto count = std::llround(env_.get(s.count));
  const double within = env_.get(s.within);
  const double each = to_seconds(rig_.lcr.conversion_time(lcr_));
  out.seconds = within;
  if (auto why = check_measure(count, within, lcr_, rig_.lcr)) {
    const double needed = each * static_cast<double>(count);
    out.refuse(Refusal(std::move(*why), at_least(s.within, needed, protocol_)));
  }
  out.note = fmt::format(
      "{} readings in {:.4g} s need a conversion of at most {:.0f} ms; aperture "
      "{} takes {:.0f} ms",
      count, within, std::floor(within / static_cast<double>(count) * 1e3),
      to_string(lcr_.aperture), each * 1e3);
  plan_.measure_readings += count;
  return out;
}

Planner::Outcome Planner::on(const PlaceWeightStep& s) {
  Outcome out;
  out.seconds = kOperator_s;
  const double force = target_force_N(s.load, env_, rig_);
  out.note = fmt::format("{:.4g} g = {:.4g} N; about {:.0f} s for the operator",
                         force / rig_.gravity_m_s2 * 1e3, force, kOperator_s);
  go_to_force(force, s.load.kind == TargetKind::mass ? nullptr : &s.load.value, out);
  foresee(force, 0);
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
  lcr_ = s.change(lcr_, env_);
  if (auto why = check_lcr(lcr_, rig_.lcr)) out.refuse(Refusal(std::move(*why)));
  return out;
}

}  // namespace lcrig
