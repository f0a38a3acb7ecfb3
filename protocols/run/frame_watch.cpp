// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_watch.hpp"

#include <algorithm>
#include <utility>

namespace lcrig {

namespace {

// A moving frame is stopped when samples are missing for three periods, but at least for two
// batches of the link (100 ms each) with their jitter.
Duration stale_after(double rate_Hz) {
  return std::max<Duration>(from_seconds(3.0 / rate_Hz), std::chrono::milliseconds(500));
}

WatchInputEvent input_of(const Plausibility::Motion& m) {
  WatchInputEvent e(WatchInput::order);
  e.direction = m.direction;
  e.speed_m_s = m.speed_m_s;
  e.rate_N_s = m.rate_N_s;
  e.force_N = m.force_N;
  e.force_known = m.force_known;
  e.rest_N = m.rest_N;
  e.free_N = m.free_N;
  e.against_N = m.against_N;
  e.drift_N_s = m.drift_N_s;
  e.waver_N = m.waver_N;
  e.target_m = m.target_m;
  e.holds = m.holds;
  e.worst_N = m.worst_N;
  return e;
}

Plausibility::Motion motion_of(const WatchInputEvent& e, const FrameCapabilities& caps) {
  Plausibility::Motion m;
  m.direction = e.direction.value_or(0);
  m.speed_m_s = e.speed_m_s.value_or(0);
  m.rate_N_s = e.rate_N_s.value_or(0);
  m.force_N = e.force_N.value_or(0);
  m.force_known = e.force_known.value_or(true);
  m.rest_N = e.rest_N.value_or(0);
  m.free_N = e.free_N;
  m.against_N = e.against_N.value_or(0);
  m.drift_N_s = e.drift_N_s.value_or(0);
  m.waver_N = e.waver_N.value_or(0);
  m.target_m = e.target_m;
  m.holds = e.holds.value_or(false);
  m.worst_N = e.worst_N;
  m.shown_after = shown_after(caps);
  return m;
}

Pressing::Permit permit_of(const WatchInputEvent& e) {
  Pressing::Permit p;
  p.threshold_N = e.threshold_N;
  p.limits.force_max = Force::from_si(e.limit_N.value_or(0));
  p.worst_N = e.worst_N.value_or(0);
  p.expected_N = e.expected_N;
  p.presses = e.presses.value_or(false);
  p.from_m = e.travel_m;
  return p;
}

MotionOutcome outcome_of(const WatchInputEvent& e) {
  MotionOutcome o;
  o.reason = parse_word<MotionEnd>(e.reason.value_or("")).value_or(MotionEnd::fault);
  o.force_N = e.force_N;
  o.travel_m = e.travel_m;
  return o;
}

}  // namespace

FrameWatch::FrameWatch(WatchedRig rig, Pressing* pressing, Hooks hooks)
    : rig_(std::move(rig)),
      pressing_(pressing),
      hooks_(std::move(hooks)),
      guard_(rig_.limits, stale_after(rig_.rate_Hz), rig_.cell),
      truth_(rig_, guard_, pressing_, hooks_.figures) {}

std::optional<Comparison> FrameWatch::add_pressed(std::span<const FrameSample> samples) {
  return pressing_ != nullptr ? pressing_->add(samples) : std::nullopt;
}

std::optional<Contradiction> FrameWatch::check(const FrameSample& sample) {
  auto no = truth_.check(sample);
  return no ? std::move(no) : truth_.check_fall(sample);
}

void FrameWatch::set_prepared(bool yes) {
  if (yes == prepared_) return;
  WatchInputEvent e(WatchInput::prepared);
  e.on = yes;
  record(std::move(e));
}

void FrameWatch::note_stop_pending(bool yes) {
  if (yes == stop_pending_) return;
  WatchInputEvent e(WatchInput::stop_pending);
  e.on = yes;
  record(std::move(e));
}

void FrameWatch::order(const Plausibility::Motion& motion) {
  record(input_of(motion));
}

void FrameWatch::permit(const Pressing::Permit& permit) {
  WatchInputEvent e(WatchInput::permit);
  e.threshold_N = permit.threshold_N;
  e.limit_N = permit.limits.force_max.si();
  e.worst_N = permit.worst_N;
  e.expected_N = permit.expected_N;
  e.presses = permit.presses;
  e.travel_m = permit.from_m;
  record(std::move(e));
}

void FrameWatch::motion_stood(std::optional<double> force_N, std::optional<double> travel_m) {
  WatchInputEvent e(WatchInput::motion_end);
  e.force_N = force_N;
  e.travel_m = travel_m;
  record(std::move(e));
}

void FrameWatch::stand(std::optional<double> travel_m) {
  WatchInputEvent e(WatchInput::standstill);
  e.travel_m = travel_m;
  record(std::move(e));
}

std::optional<Comparison> FrameWatch::compare(const MotionOutcome& outcome, double noise_N) {
  WatchInputEvent e(WatchInput::compared);
  e.reason = std::string(to_string(outcome.reason));
  e.force_N = outcome.force_N;
  e.travel_m = outcome.travel_m;
  e.noise_N = noise_N;
  return record(std::move(e));
}

void FrameWatch::watch_age(bool on) {
  WatchInputEvent e(WatchInput::age_watched);
  e.on = on;
  record(std::move(e));
}

void FrameWatch::allow_return(double noise_N) {
  WatchInputEvent e(WatchInput::retreat);
  e.noise_N = noise_N;
  record(std::move(e));
}

void FrameWatch::learn_rest(const Rest& rest, FrameTruth::Under under) {
  const bool bare = under == FrameTruth::Under::nothing;
  record(
      look(bare ? WatchInput::rest_measurement : WatchInput::rest_measurement_near_contact, rest),
      &rest);
}

void FrameWatch::set_rest_force(const Rest& rest) {
  WatchInputEvent e(WatchInput::zero);
  e.force_N = rest.force_N();
  e.noise_N = rest.scatter_N();
  record(std::move(e));
}

void FrameWatch::distrust_pressing(std::string why) {
  WatchInputEvent e(WatchInput::pressing_locked_out);
  e.reason = std::move(why);
  record(std::move(e));
}

void FrameWatch::know_contact(double travel_m, double felt_N, double least_N_m) {
  WatchInputEvent e(WatchInput::least_stiffness);
  e.travel_m = travel_m;
  e.force_N = felt_N;
  e.stiffness_N_m = least_N_m;
  record(std::move(e));
}

void FrameWatch::measured(double felt_N, double most_N_m) {
  WatchInputEvent e(WatchInput::largest_stiffness);
  e.force_N = felt_N;
  e.stiffness_N_m = most_N_m;
  record(std::move(e));
}

void FrameWatch::not_measured(const std::string& why) {
  if (pressing_ != nullptr) pressing_->not_measured(why);
}

void FrameWatch::record_force(WatchInput what, double force_N) {
  WatchInputEvent e(what);
  e.force_N = force_N;
  record(std::move(e));
}

void FrameWatch::record_travel(WatchInput what, double travel_m) {
  WatchInputEvent e(what);
  e.travel_m = travel_m;
  record(std::move(e));
}

// The samples of the look are stored, so their numbers are enough.
WatchInputEvent FrameWatch::look(WatchInput what, const Rest& rest) {
  WatchInputEvent e(what);
  e.from_sample = rest.from_sample();
  e.to_sample = rest.from_sample() + rest.samples();
  if (rest.shifted_N() != 0) e.shift_N = rest.shifted_N();
  if (const auto& known = rest.known_drift()) {
    e.drift_N_s = known->drift_N_s;
    e.drift_error_N_s = known->error_N_s;
  }
  return e;
}

std::optional<Comparison> FrameWatch::record(WatchInputEvent input, const Rest* rest) {
  input.samples = samples_;
  if (judging_) input.judging = true;
  hooks_.store(input);
  return apply(input, rest, hooks_.now());
}

std::optional<Comparison> FrameWatch::apply(const WatchInputEvent& e, const Rest* rest,
                                            MonoTime at) {
  const double force_N = e.force_N.value_or(0), travel_m = e.travel_m.value_or(0);
  const bool presses = pressing_ != nullptr;
  switch (e.what) {
    case WatchInput::prepared: prepared_ = e.on.value_or(false); break;
    case WatchInput::stop_pending: stop_pending_ = e.on.value_or(false); break;
    case WatchInput::order: truth_.begin(motion_of(e, rig_.frame), at); break;
    case WatchInput::permit:
      if (presses) pressing_->begin(permit_of(e));
      break;
    case WatchInput::compared:
      if (presses) return pressing_->end(outcome_of(e), e.noise_N.value_or(0));
      break;
    case WatchInput::motion_end: guard_.take_standstill(e.force_N, e.travel_m); break;
    case WatchInput::standstill: truth_.stand(at, e.travel_m); break;
    case WatchInput::motion_unknown: truth_.look_away(); break;
    case WatchInput::rest_measurement:
    case WatchInput::rest_measurement_near_contact:
    case WatchInput::noise:
    case WatchInput::live_cell:
      if (rest != nullptr) learn(e.what, *rest);
      break;
    case WatchInput::zero_before_contact: truth_.learn_unpulled(force_N); break;
    case WatchInput::force_zeroed: truth_.zero_force(at); break;
    case WatchInput::zero_hides: guard_.set_zero_under_load(force_N); break;
    case WatchInput::zero_took: truth_.learn_zero_under_load(force_N); break;
    case WatchInput::zero: guard_.set_rest_force(force_N, e.noise_N.value_or(0)); break;
    case WatchInput::force_invalid:
      truth_.distrust_force();
      guard_.distrust_zero(rig_.frame.force_max.si());
      break;
    case WatchInput::pressing_locked_out:
      if (presses) pressing_->distrust(e.reason.value_or(""));
      break;
    case WatchInput::contact:
      truth_.forget_contact();  // unknown until its stiffness is measured
      guard_.place_contact(travel_m);
      break;
    case WatchInput::least_stiffness:
      truth_.know_contact(at, travel_m, force_N, e.stiffness_N_m.value_or(0));
      break;
    case WatchInput::largest_stiffness:
      if (presses) pressing_->measured(force_N, e.stiffness_N_m.value_or(0));
      break;
    case WatchInput::travel_zeroed:
      truth_.zero_travel(travel_m);
      guard_.zero_travel(travel_m);
      break;
    case WatchInput::force_loop:
      if (presses) pressing_->leave_to_loop();
      break;
    case WatchInput::age_watched: guard_.set_watch_age(e.on.value_or(false)); break;
    case WatchInput::age_restarted: guard_.restart_age(at); break;
    case WatchInput::stopping: guard_.expect_standstill(); break;
    case WatchInput::ended: ended_ = true; break;
    case WatchInput::retreat: guard_.allow_return(e.noise_N.value_or(0)); break;
  }
  return std::nullopt;
}

void FrameWatch::learn(WatchInput what, const Rest& rest) {
  switch (what) {
    case WatchInput::rest_measurement: return truth_.learn_rest(rest);
    case WatchInput::rest_measurement_near_contact:
      return truth_.learn_rest(rest, FrameTruth::Under::perhaps_contact);
    case WatchInput::noise: return truth_.learn_scatter(rest);
    default: return truth_.see_alive(rest);
  }
}

WatchSetupEvent FrameWatch::setup_event() const {
  const BoundLimits& limits = rig_.limits;
  WatchSetupEvent e;
  e.commands = rig_.commands;
  e.rate_Hz = rig_.rate_Hz;
  e.force_min_N = limits.force_min_N;
  e.force_max_N = limits.force_max_N;
  e.travel_min_m = limits.travel_min_m;
  e.travel_max_m = limits.travel_max_m;
  e.gap_min_m = limits.gap_min_m;
  e.gap_max_m = limits.gap_max_m;
  e.speed_max_m_s = limits.speed_max_m_s;
  e.cell_class_percent = rig_.cell.percent();
  if (pressing_ == nullptr) return e;
  const auto table = [](const std::optional<ForceBound>& bound) {
    return bound ? std::optional(bound->table_N_m()) : std::nullopt;
  };
  const Forecast& forecast = pressing_->forecast();
  e.at_most_N_m = forecast.bound().table_N_m();
  e.expected_N_m = table(forecast.expected());
  e.if_free_N_m = table(forecast.if_free());
  return e;
}

Result<WatchedRig> rig_of(const WatchSetupEvent& e, FrameCapabilities frame) {
  if (!is_force_class(e.cell_class_percent) || !(e.rate_Hz > 0)) {
    return fail(Errc::garbled,
                "the event `watch_setup` states no class of the load cell, or no rate");
  }
  WatchedRig rig;
  rig.commands = e.commands;
  rig.rate_Hz = e.rate_Hz;
  rig.limits.force_min_N = e.force_min_N;
  rig.limits.force_max_N = e.force_max_N;
  rig.limits.travel_min_m = e.travel_min_m;
  rig.limits.travel_max_m = e.travel_max_m;
  rig.limits.gap_min_m = e.gap_min_m;
  rig.limits.gap_max_m = e.gap_max_m;
  rig.limits.speed_max_m_s = e.speed_max_m_s;
  rig.cell = ForceClass(e.cell_class_percent);
  rig.frame = std::move(frame);
  return rig;
}

std::optional<Pressing> pressing_of(const WatchSetupEvent& e, const WatchedRig& rig) {
  if (!e.at_most_N_m) return std::nullopt;
  const auto bound = [](const std::optional<std::vector<double>>& table) {
    return table ? std::optional(ForceBound::from_table(*table)) : std::nullopt;
  };
  Forecast forecast(rig.frame, ForceBound::from_table(*e.at_most_N_m), bound(e.expected_N_m),
                    bound(e.if_free_N_m));
  return Pressing(std::move(forecast), rig.frame);
}

}  // namespace lcrig
