// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocols/expand.hpp"
#include "protocols/rig/constants.hpp"

namespace lcrig {

namespace {

// Time between batches of samples, s.

}  // namespace

Planner::Planner(const Protocol& protocol, Environment& environment, const Rig& rig,
                 const BoundLimits& limits, Plan& plan)
    : protocol_(protocol),
      environment_(environment),
      plan_(plan),
      rig_(protocol, environment, rig, limits, plan),
      places_(environment) {}

void Planner::refuse(const std::string& pointer, const std::string& id, Refusal refusal) {
  if (refused_) return;
  refused_.emplace();
  refused_->pointer = pointer;
  refused_->id = id;
  refused_->refusal = std::move(refusal);
}

// Refuses limits that the machine cannot keep.
void Planner::check_limits() {
  const Limits& l = protocol_.limits;
  for (const auto* force : {&l.force_min, &l.force_max}) {
    if (!*force) continue;
    if (const auto no = check_force_limit(rig_.get(**force), rig_.frame())) {
      auto changes = force == &l.force_max ? at_most(**force, no->end, rig_.asked())
                                           : at_least(**force, no->end, rig_.asked());
      refuse("/limits", "limits", Refusal(no->why, std::move(changes)));
    }
  }
  for (const auto* travel : {&l.travel_min, &l.travel_max}) {
    if (!*travel || !rig_.frame().motion) continue;
    if (const auto no = check_travel_limit(rig_.get(**travel), rig_.frame())) {
      auto changes = travel == &l.travel_max ? at_most(**travel, no->end, rig_.asked())
                                             : at_least(**travel, no->end, rig_.asked());
      refuse("/limits", "limits",
             Refusal(no->why + ": give limits of this frame, or gap_mm, which counts from contact",
                     std::move(changes)));
    }
  }
}

// Refuses motions whose force or travel nobody could watch.
void Planner::check_channels() {
  if (!rig_.frame().motion || !commands_frame(protocol_)) return;
  const FrameCapabilities& c = rig_.frame();
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

// Proposes a frequency that the meter has. -p changes it in every protocol without a parameter of
// that name.
std::vector<Change> Planner::possible_frequency() const {
  constexpr const char* kName = "frequency_Hz";
  const LcrCapabilities& meter = rig_.known().lcr;
  const double wanted = plan_.lcr.frequency.si();
  const double can = std::clamp(wanted, meter.frequency_min.si(), meter.frequency_max.si());
  if (can == wanted || protocol_.parameters.contains(kName)) return {};
  return {Change(kName, can, true)};
}

void Planner::check_start() {
  if (const auto why = check_lcr(plan_.lcr, rig_.known().lcr)) {
    refuse("/sample/lcr", "sample", Refusal(*why, possible_frequency()));
  }
  const double rate = protocol_.sample.frame_rate_Hz, most = rig_.frame().sample_rate_max_Hz;
  plan_.frame_rate_Hz = rate;
  if (most > 0 && rate > most) {
    plan_.frame_rate_Hz = most;
    rig_.assume(fmt::format("{:.6g} samples per second: the frame sends no more", most));
  }
  check_limits();
  check_channels();
  if (!rig_.frame().motion || !rig_.known().start_travel || !commands_frame(protocol_)) return;
  if (const auto no = check_travel(rig_.known().start_travel->si(), rig_.limits(), rig_.known())) {
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

// Computes the force that a frozen cell, or a drive that runs the wrong way, has caused by the time
// it is noticed.
void Planner::foresee_lies() {
  const Tolerances& w = plan_.watch;
  const double period_s = plan_.frame_rate_Hz > 0 ? 1 / plan_.frame_rate_Hz : 0;
  const double heard_s = std::max(period_s, kBatch_s.value) + w.reply_s;
  const auto after = [&](double way_m, double speed_m_s) {
    return rig_.forecast().bound().force_after_N(plan_.worst_force_N,
                                                 way_m + stopping_way_m(rig_.frame(), speed_m_s));
  };
  if (w.frozen_force_s && rig_.pressed_m_s() > 0) {
    plan_.frozen_force_N =
        after(rig_.pressed_m_s() * (*w.frozen_force_s + heard_s), rig_.pressed_m_s());
  }
  if (rig_.fastest_m_s() > 0) {
    plan_.reversed_force_N = after(w.against_m + rig_.fastest_m_s() * heard_s, rig_.fastest_m_s());
  }
}

void Planner::finish_figures() {
  plan_.travel_from_contact =
      rig_.has_moved() && !rig_.known().start_travel && !rig_.known().expected_contact;
  plan_.weights = rig_.frame().weights;
  if (plan_.weights) return;
  ForceUncertainty& u = plan_.force_uncertainty;
  const ForceClass cell = rig_.frame().cell();
  u.class_N =
      std::max(cell.error_N(rig_.limits().force_min_N), cell.error_N(rig_.limits().force_max_N));
  u.zero_N = cell.zero_error_N(rig_.frame().force_max.si());
  if (const auto noise = force_noise_N(rig_.known())) u.noise_N = 4 * *noise;
  const auto& scatter = rig_.known().force_scatter;
  plan_.watch = tolerances_of(rig_.frame(), rig_.forecast().bound(), rig_.limits().force_max_N,
                              plan_.frame_rate_Hz, scatter ? &*scatter : nullptr,
                              force_noise_N(rig_.known()).value_or(0));
  if (!rig_.has_moved()) return;
  foresee_lies();
  if (!rig_.frame().force_class) {
    rig_.assume(
        fmt::format("load cell of class {:g} (ISO 7500-1): neither frame.force_class nor "
                    "the frame states one",
                    cell.percent()));
  }
  for (const std::string& text : rig_.known().frame_differences) rig_.assume(text);
  for (const std::string& text : forecast_assumptions(rig_.known(), rig_.forecast())) {
    rig_.assume(text);
  }
  if (!rig_.known().compression_m) {
    rig_.assume("no specimen stated: compression and overshoot are not predicted");
  }
  if (plan_.travel_from_contact) {
    rig_.assume("no contact travel stated: travel is counted from contact");
  } else if (!rig_.is_placed() && !rig_.known().expected_contact) {
    rig_.assume(fmt::format("contact about {:.3g} mm from where the frame stands",
                            PlannedRig::kAssumedGap_m * 1e3));
  }
}

bool Planner::walk_steps(const Steps& steps, bool in_finally) {
  StepCursor cursor(steps, environment_);
  double begun = plan_.duration_s;
  while (const Step* step = cursor.next()) {
    if (++visits_ > kStepsMax) {
      refuse(step->pointer, step->id,
             Refusal(fmt::format("more than {} steps in all, expected fewer repeats", kStepsMax)));
      return false;
    }
    StepPlan adds = visit(*step);
    if (adds.why) {
      refuse(step->pointer, step->id, std::move(*adds.why));
      return false;
    }
    account(*step, adds, in_finally);
    if (!in_finally) count_places(cursor, *step);
  }
  const double took = plan_.duration_s - begun, most = to_seconds(protocol_.finally_timeout);
  if (in_finally && took > most) {
    refuse("/finally", "finally",
           Refusal(fmt::format("takes {:.4g} s, finally_timeout_s is {:.4g}", took, most),
                   {Change("/finally_timeout_s", std::ceil(took), false)}));
  }
  return !refused_;
}

void Planner::account(const Step& step, const StepPlan& adds, bool in_finally) {
  const auto [it, is_new] = row_of_.try_emplace(step.id, plan_.steps.size());
  if (is_new) {
    PlannedStep row;
    row.id = step.id;
    row.kind = kind_of(step);
    row.start_s = plan_.duration_s;
    row.duration_s = adds.seconds;
    row.note = adds.note;
    row.in_finally = in_finally;
    row.by_hand = adds.by_hand;
    plan_.steps.push_back(std::move(row));
  }
  PlannedStep& row = plan_.steps[it->second];
  ++row.times;
  row.total_s += adds.seconds;
  plan_.duration_s += adds.seconds;
  if (adds.by_hand) plan_.hand_s += adds.seconds;
}

void Planner::count_places(const StepCursor& cursor, const Step& step) {
  PlannedPlaces& p = plan_.places;
  ++p.steps;
  p.levels += places_.ends(StopPlace::level, cursor, step) ? 1 : 0;
  p.cycles += places_.ends(StopPlace::cycle, cursor, step) ? 1 : 0;
  p.repeats += places_.ends(StopPlace::repeat, cursor, step) ? 1 : 0;
  if (!step.safe_point) return;
  const auto known =
      std::ranges::find(p.safe_points, step.id, &decltype(p.safe_points)::value_type::first);
  if (known == p.safe_points.end()) {
    p.safe_points.emplace_back(step.id, 1);
  } else {
    ++known->second;
  }
}

StepPlan Planner::visit(const Step& step) {
  if (auto why = check_capability(step, rig_.frame())) {
    StepPlan out;
    out.refuse(Refusal(std::move(*why)));
    return out;
  }
  const std::int64_t before = rig_.motions();
  StepPlan out = step.action->plan(rig_);
  // The facts of a step decide whether a run commands the frame. If they missed a motion, a frame
  // that is only observed would move and never be stopped.
  if (rig_.motions() != before && !facts_of(step).commands_frame()) {
    out.why =
        Refusal("a bug: its plan moves the frame, its facts say that it commands none: report it");
  }
  return out;
}

}  // namespace lcrig
