// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_watch.hpp"

#include <algorithm>
#include <utility>

namespace lcrig {

namespace {

WatchInputEvent with_noise(WatchInput what, std::optional<double> force_N, double noise_N) {
  WatchInputEvent e(what);
  e.force_N = force_N;
  e.noise_N = noise_N;
  return e;
}

}  // namespace

FrameWatch::FrameWatch(RigFacts facts, std::optional<Forecast> forecast, Hooks hooks)
    : rig_(std::move(facts), std::move(forecast)), hooks_(std::move(hooks)) {}

std::vector<Finding> FrameWatch::add(FrameSample sample) {
  ++samples_;
  if (sample.force_N) *sample.force_N += 0.0;  // a database has no -0, and the words are compared
  const std::optional<ForceComparison> compared = rig_.apply(sample);
  check_invariants();
  return find(rig_, Sight{sample, compared});
}

void FrameWatch::set_prepared(bool yes) {
  if (yes != rig_.is_prepared) record_switch(WatchInput::prepared, yes);
}

void FrameWatch::note_stop_pending(bool yes) {
  if (yes != rig_.is_stop_pending) record_switch(WatchInput::stop_pending, yes);
}

// A rest measurement names its samples: they are stored, so their numbers are enough.
void FrameWatch::learn(WatchInput what, const RestMeasurement& rest) {
  WatchInputEvent e(what);
  e.from_sample = rest.from_sample();
  e.to_sample = rest.from_sample() + rest.samples();
  if (rest.shifted_N() != 0) e.shift_N = rest.shifted_N();
  if (const auto& known = rest.known_drift()) {
    e.drift_N_s = known->drift_N_s;
    e.drift_error_N_s = known->error_N_s;
  }
  record(std::move(e), &rest);
}

void FrameWatch::learn_zero(const RestMeasurement& rest, Under under) {
  learn(under == Under::nothing ? WatchInput::rest_measurement
                                : WatchInput::rest_measurement_near_contact,
        rest);
  record(with_noise(WatchInput::zero, rest.force_N(), rest.scatter_N()));
}

std::optional<ForceComparison> FrameWatch::compare(const MotionOutcome& outcome, double noise_N) {
  WatchInputEvent e = with_noise(WatchInput::compared, outcome.force_N, noise_N);
  e.reason = std::string(to_string(outcome.reason));
  e.travel_m = outcome.travel_m;
  return record(std::move(e));
}

void FrameWatch::zeroed(const RestMeasurement& before, bool force, bool travel, double pressed_N) {
  fact(WatchInput::force_zeroed, force ? std::optional(before.force_N()) : std::nullopt);
  if (force) fact(WatchInput::zero_hides, pressed_N);
  if (travel) fact(WatchInput::travel_zeroed, std::nullopt, before.travel_m().value_or(0));
}

// If the zero hides a pressing force, the unloaded cell will show that force with the opposite
// sign, which then does not mean a pull.
void FrameWatch::zero_measured(const RestMeasurement& before, const RestMeasurement& after,
                               double pressed_N) {
  if (!(pressed_N > 0)) return learn_zero(after);
  fact(WatchInput::zero_took, before.force_N() - after.force_N());
  record(with_noise(WatchInput::zero, after.force_N(), after.scatter_N()));
}

void FrameWatch::take_over_zeros(bool zeroed, std::optional<double> sum_N) {
  WatchInputEvent e(WatchInput::zeros_taken_over);
  e.on = zeroed;
  e.force_N = sum_N;
  record(std::move(e));
}

void FrameWatch::lock_out_motion(Error why) {
  WatchInputEvent e(WatchInput::motion_locked_out);
  e.reason = why.what;
  record(std::move(e));
  rig_.trust.no_motion = std::move(why);  // with its code, which is not stored
}

void FrameWatch::lock_out_pressing(std::string why) {
  WatchInputEvent e(WatchInput::pressing_locked_out);
  e.reason = std::move(why);
  record(std::move(e));
}

void FrameWatch::fact(WatchInput what, std::optional<double> force_N,
                      std::optional<double> travel_m, std::optional<double> stiffness_N_m) {
  WatchInputEvent e(what);
  e.force_N = force_N;
  e.travel_m = travel_m;
  e.stiffness_N_m = stiffness_N_m;
  record(std::move(e));
}

void FrameWatch::record_switch(WatchInput what, bool on) {
  WatchInputEvent e(what);
  e.on = on;
  record(std::move(e));
}

void FrameWatch::start_retreat() {
  record(with_noise(WatchInput::retreat, std::nullopt, rig_.cell.noise_bound_N()));
}

std::optional<ForceComparison> FrameWatch::record(WatchInputEvent input,
                                                  const RestMeasurement* rest) {
  input.samples = samples_;
  if (answering_) input.judging = true;
  hooks_.store(input);
  return apply(input, rest, hooks_.now());
}

std::optional<ForceComparison> FrameWatch::apply(const WatchInputEvent& input,
                                                 const RestMeasurement* rest, MonoTime at) {
  RigState::Applied done = rig_.apply(input, rest, at);
  if (done.tolerances) hooks_.tolerances(rig_.tolerances);
  check_invariants();
  return std::move(done.compared);
}

// One report is enough.
void FrameWatch::check_invariants() {
  auto broken = rig_.broken_invariant();
  if (!broken || std::exchange(is_broken_, true)) return;
  hooks_.broken("a fault of this program, its state of the rig contradicts itself: " + *broken);
}

WatchSetupEvent FrameWatch::setup_event() const {
  const RigFacts& facts = rig_.facts;
  WatchSetupEvent e;
  e.commands = facts.commands;
  e.rate_Hz = facts.rate_Hz;
  e.force_min_N = facts.limits.force_min_N;
  e.force_max_N = facts.limits.force_max_N;
  e.travel_min_m = facts.limits.travel_min_m;
  e.travel_max_m = facts.limits.travel_max_m;
  e.gap_min_m = facts.limits.gap_min_m;
  e.gap_max_m = facts.limits.gap_max_m;
  e.speed_max_m_s = facts.limits.speed_max_m_s;
  e.cell_class_percent = facts.cell.percent();
  if (!rig_.forecast) return e;
  const auto table = [](const std::optional<ForceBound>& bound) {
    return bound ? std::optional(bound->table_N_m()) : std::nullopt;
  };
  e.at_most_N_m = rig_.forecast->bound().table_N_m();
  e.expected_N_m = table(rig_.forecast->expected());
  e.if_free_N_m = table(rig_.forecast->if_free());
  return e;
}

Result<RigFacts> rig_of(const WatchSetupEvent& e, FrameCapabilities frame) {
  if (!is_force_class(e.cell_class_percent) || !(e.rate_Hz > 0)) {
    return fail(Errc::garbled,
                "the event `watch_setup` states no class of the load cell, or no rate");
  }
  RigFacts facts;
  facts.commands = e.commands;
  facts.rate_Hz = e.rate_Hz;
  facts.limits.force_min_N = e.force_min_N;
  facts.limits.force_max_N = e.force_max_N;
  facts.limits.travel_min_m = e.travel_min_m;
  facts.limits.travel_max_m = e.travel_max_m;
  facts.limits.gap_min_m = e.gap_min_m;
  facts.limits.gap_max_m = e.gap_max_m;
  facts.limits.speed_max_m_s = e.speed_max_m_s;
  facts.cell = ForceClass(e.cell_class_percent);
  facts.frame = std::move(frame);
  return facts;
}

std::optional<Forecast> forecast_of(const WatchSetupEvent& e, const RigFacts& facts) {
  if (!e.at_most_N_m) return std::nullopt;
  const auto bound = [](const std::optional<std::vector<double>>& table) {
    return table ? std::optional(ForceBound::from_table(*table)) : std::nullopt;
  };
  return std::optional<Forecast>(std::in_place, facts.frame, ForceBound::from_table(*e.at_most_N_m),
                                 bound(e.expected_N_m), bound(e.if_free_N_m));
}

}  // namespace lcrig
