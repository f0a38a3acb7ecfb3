// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/planned_rig.hpp"

#include <fmt/format.h>

#include <cmath>

#include "protocols/rig/constants.hpp"

namespace lcrig {

void PlannedRig::note_recording() {
  if (protocol_.sample.lcr_continuous) plan_.read_backs.add_recording(lcr_, rig_.lcr);
}

void PlannedRig::set_meter(LcrSettings settings) {
  lcr_ = std::move(settings);
  note_recording();
}

void PlannedRig::add_level(std::int64_t readings, double within_s) {
  plan_.measure_readings += readings;
  plan_.read_backs.add_level(static_cast<double>(readings), within_s, lcr_, rig_.lcr);
}

PlannedRig::PlannedRig(const Protocol& protocol, const Environment& environment, const Rig& rig,
                       const BoundLimits& limits, Plan& plan)
    : protocol_(protocol),
      environment_(environment),
      rig_(rig),
      limits_(limits),
      forecast_(make_forecast(rig)),
      plan_(plan),
      lcr_(plan.lcr) {
  note_recording();
  // A force within the noise counts as zero.
  const double below = -rig.rest_force_N;
  if (below > kNoiseSigmas * force_noise_N(rig).value_or(0)) below_N_ = below;
  const auto& start = rig.start_travel;
  const double gap = rig.start_gap ? rig.start_gap->si() : kAssumedGap_m;
  // The place of contact is stated, expected, or the origin of all travels.
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

void PlannedRig::assume(const std::string& text) {
  if (std::ranges::find(plan_.assumptions, text) == plan_.assumptions.end()) {
    plan_.assumptions.push_back(text);
  }
}

void PlannedRig::zero_travel() {
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

void PlannedRig::state_gap(double gap_m) {
  contact_ = travel_ + gap_m;
  contact_N_ = 0;
  contact_state_ = Contact::stated;
  placed_ = rig_.start_travel.has_value();
  if (placed_) limits_.place_contact(contact_);
}

void PlannedRig::find_contact(double rise_N, double speed_m_s) {
  if (rig_.found_contact) contact_ = rig_.found_contact->si();
  contact_state_ = Contact::found;
  forecast_.expect_measurement(rise_N);
  contact_N_ = forecast_.stop_N(rise_N, speed_m_s);
  placed_ = placed_ || rig_.found_contact.has_value();
  if (placed_) limits_.place_contact(contact_);
}

double PlannedRig::largest_end_N() const {
  return lcrig::largest_end_N(limits_.force_max_N, sure_force_noise_N(rig_));
}

double PlannedRig::proposed_end_N() const {
  return lcrig::largest_end_N(limits_.force_max_N, sure_force_noise_anew_N(rig_));
}

std::string PlannedRig::limit_text() const {
  const double limit_N = limits_.force_max_N, noise_N = limit_N - largest_end_N();
  std::string text = fmt::format("the limit is {:.4g} N", limit_N);
  if (noise_N > 1e-4 * limit_N) {
    text += fmt::format(" less {:.2g} N for the noise of the cell", noise_N);
  }
  return text;
}

double PlannedRig::travel_at(double force) const {
  return contact_ + (rig_.compression_m && force > 0 ? rig_.compression_m(force) : 0);
}

// The bisection ends at twice the largest allowed force, because anything beyond is too much
// anyway.
double PlannedRig::force_at(double travel) const {
  if (!rig_.compression_m || travel <= contact_) return 0;
  double low = 0, high = 2 * std::max(std::abs(limits_.force_max_N), 1e-3);
  if (travel_at(high) <= travel) return high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (travel_at(middle) < travel ? low : high) = middle;
  }
  return high;
}

double PlannedRig::stop_N(double felt_N, double speed_m_s) {
  const auto [it, is_new] = stops_.try_emplace({felt_N, speed_m_s}, 0);
  if (is_new) it->second = forecast_.stop_N(felt_N, speed_m_s);
  return it->second;
}

void PlannedRig::go_to_travel(double travel, const Target* to, StepPlan& out) {
  const double gap = contact_ - travel;
  const bool is_gap = to != nullptr && to->kind == TargetKind::gap;
  // Converts an end of the travel window for the target.
  const auto suggest = [&](double end) {
    if (to == nullptr) return std::vector<Change>();
    const double value = is_gap ? contact_ - end : end;
    return (travel > end) == is_gap ? at_least(to->value, value, asked())
                                    : at_most(to->value, value, asked());
  };
  // Before contact was found, its gap is unknown, and so is the travel that follows from it.
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
  if (!has_moved()) plan_.travel_min_m = plan_.travel_max_m = travel_;
  ++motions_;
  travel_ = travel;
  plan_.travel_min_m = std::min(plan_.travel_min_m, travel);
  plan_.travel_max_m = std::max(plan_.travel_max_m, travel);
}

void PlannedRig::go_to_force(double force, const Number* given, StepPlan& out) {
  if (const auto no = check_force(force, limits_, rig_)) {
    std::vector<Change> changes;
    const double area_m2 = rig_.pressure.area_m2().value_or(0);
    const bool in_N =
        given != nullptr && area_m2 > 0 && std::abs(get(*given) - force) <= 1e-9 * std::abs(force);
    const double unit = in_N ? 1 : area_m2;
    if (given != nullptr && unit > 0) changes = at_most(*given, no->end / unit, asked());
    out.refuse(Refusal(no->why, std::move(changes)));
  }
  force_ = force;
  plan_.peak_force_N = std::max(plan_.peak_force_N, force);
}

void PlannedRig::use_speed(const Number& speed, StepPlan& out) {
  const double v = get(speed);
  fastest_m_s_ = std::max(fastest_m_s_, v);
  const auto no = check_speed(v, limits_, rig_);
  if (!no) return;
  out.refuse(Refusal(
      no->why, v > no->end ? at_most(speed, no->end, asked()) : at_least(speed, no->end, asked())));
}

void PlannedRig::foresee(double worst_N, double speed) {
  plan_.worst_force_N = std::max(plan_.worst_force_N, worst_N);
  pressed_m_s_ = std::max(pressed_m_s_, speed);
  // Losing the host changes nothing here: the device watches force and travel by itself.
  plan_.lost_force_N = std::max(plan_.lost_force_N, worst_N);
  plan_.lost_way_m = std::max(plan_.lost_way_m, speed > 0 ? forecast_.lost_way_m(speed) : 0);
}

}  // namespace lcrig
