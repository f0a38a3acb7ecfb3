// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// A specimen relaxes while it is pressed slowly, and gives back less than it took.
constexpr double kMayRelax = 0.3, kMayGiveBack = 0.05;  // as parts of the felt force
constexpr double kLeastOfLimit = 0.02;
constexpr double kSettles = 0.1;  // part of the force, from the stop to the next sample

// Whether a single force value shows that the target was reached from the side of `direction`.
bool is_there(double force_N, double target_N, int direction, double allowed_N) {
  if (direction == 0) return std::abs(force_N - target_N) <= allowed_N;
  return direction > 0 ? force_N >= target_N - allowed_N : force_N <= target_N + allowed_N;
}

}  // namespace

FrameTruth::FrameTruth(const RunSetup& setup, const EventLog& log, const Guard& guard,
                       Pressing* pressing, const FrameView& view)
    : setup_(setup), log_(log), guard_(guard), pressing_(pressing), view_(view) {
  if (pressing_ != nullptr && setup_.commands) plausible_.emplace(WatchFigures());
}

// Learns the unloaded cell, and with it everything that is derived from it.
void FrameTruth::learn_rest(const Rest& rest, Under under) {
  // If a cell that was alive shows a single value, it may just have frozen. Nothing is learned from
  // it.
  if (plausible_ && scatter_.alive && !rest.is_alive()) return;
  rest_ = rest;
  if (under == Under::nothing) {
    bare_ = rest;
    moved_zero_N_ = 0;
    unpulled_N_.reset();
  }
  if (!plausible_) return;
  if (rest.drifts()) {
    drift_N_s_ = std::abs(rest.drift_N_s()) + kSureOfDrift * rest.drift_error_N_s();
  }
  learn_scatter(rest);
}

void FrameTruth::learn_scatter(const Rest& rest) {
  if (!plausible_) return;
  scatter_.add(rest, plausible_->figures().frozen_samples);
  WatchFigures figures =
      watch_figures(setup_.frame.capabilities(), pressing_->forecast().bound(),
                    setup_.limits.force_max_N, setup_.frame_rate_Hz, scatter_, scatter_.noise_N);
  // The scatter is a new estimate each time, but an earlier promise to notice a frozen cell is
  // kept.
  const WatchFigures& before = plausible_->figures();
  if (before.frozen_samples &&
      figures.frozen_samples.value_or(INT64_MAX) > *before.frozen_samples) {
    figures.frozen_samples = before.frozen_samples;
    figures.frozen_force_s = before.frozen_force_s;
  }
  plausible_->set_figures(figures);
  log_.event(EventKind::watch, to_json(plausible_->figures()).dump());
}

double FrameTruth::load_doubt_N() const {
  const double noise_N = bare_ ? bare_->scatter_N() : 0;
  return std::max(5 * noise_N, 0.01 * setup_.limits.force_max_N);
}

bool FrameTruth::is_loaded(double force_N) const {
  return force_N - most_bare_N() > load_doubt_N();
}

bool FrameTruth::is_pulled(double force_N) const {
  return bare_N() - force_N - zero_doubt_N() > load_doubt_N();
}

double FrameTruth::zero_doubt_N() const {
  return setup_.cell.zero_error_N(setup_.frame.capabilities().force_max.si());
}

// The motion with the tolerances that apply from now on.
Plausibility::Motion FrameTruth::motion_now(double direction, double speed_m_s) const {
  Plausibility::Motion m;
  m.direction = direction;
  m.speed_m_s = speed_m_s;
  m.force_N = view_.force_N().value_or(0);
  // For a motion into the specimen the last known force counts, however old it is.
  m.force_known = direction >= 0 || view_.shows_force();
  m.rest_N = rest_N();
  m.free_N = most_bare_N();
  const double felt_N = std::abs(m.force_N - m.rest_N);
  // The force of a frame that hunts in contact varies by more than the noise of its cell.
  const double noise_N =
      std::max({sure_noise_N(), view_.wavers_N(), plausible_ ? plausible_->wavers_N() : 0});
  const double least_N =
      std::max(kDifferenceSigmas * noise_N, kLeastOfLimit * guard_.force_max_N());
  m.against_N = least_N + (direction > 0 ? kMayRelax : kMayGiveBack) * felt_N + zero_doubt_N();
  m.drift_N_s = drift_N_s_;
  m.shown_after = shown_after(setup_.frame.capabilities());
  if (direction > 0) {  // pressing a specimen never makes it pull
    const double room_N = m.force_N - guard_.limits().force_min_N;
    m.against_N = std::min(m.against_N, std::max(room_N, kDifferenceSigmas * noise_N));
  }
  return m;
}

void FrameTruth::begin(const Plausibility::Motion& motion) {
  if (plausible_) plausible_->begin(motion, setup_.clock.now());
}

void FrameTruth::begin_hold() {
  Plausibility::Motion m = motion_now(0, 0);
  m.holds = true;
  if (const auto& loop = setup_.frame.capabilities().force_loop) m.waver_N = loop->ripple.si();
  begin(m);
}

void FrameTruth::stand(std::optional<double> travel_m) {
  if (plausible_) plausible_->stand(setup_.clock.now(), travel_m);
}

double FrameTruth::still_m() const {
  return plausible_ ? plausible_->still_m() : kStanding_m;
}

std::optional<Contradiction> FrameTruth::check(const FrameSample& sample) {
  if (!plausible_) return std::nullopt;
  return plausible_->check(sample);
}

// Distinguishes a specimen that pulls, which is left to a person, from a cell that lies. A lying
// cell is not believed, and the probe moves away.
std::optional<Contradiction> FrameTruth::check_fall(const FrameSample& sample) const {
  const double least_N = guard_.limits().force_min_N;
  if (!plausible_ || sample.force_N.value_or(least_N) >= least_N) return std::nullopt;
  const double felt_N = std::max(guard_.peak_force_N(), guard_.force_max_N());
  const double stiffness_N_m = pressing_->forecast().bound().stiffness_N_m(felt_N);
  if (plausible_->changed_sign(stiffness_N_m)) {
    return Contradiction(
        Disbelief::force,
        fmt::format("the force falls to {:.4f} N at once, which is what it was with the other "
                    "sign: the load cell is connected the wrong way",
                    *sample.force_N));
  }
  if (plausible_->may_pull()) return std::nullopt;
  return Contradiction(
      Disbelief::force,
      fmt::format("the force falls to {:.4f} N though the frame does not move away from the "
                  "specimen, which can only pull then: the load cell is connected the wrong way, "
                  "or lost its zero",
                  *sample.force_N));
}

// How far the frame is from the intended end of the motion, by its own report and by its samples.
// Empty when both agree with it.
std::string FrameTruth::disagreement(const MotionOrder& order, const MotionOutcome& outcome) const {
  const WatchFigures& f = plausible_->figures();
  if (order.travel_m) {
    for (const auto& x : {outcome.travel_m, view_.shown_travel_m()}) {
      if (!x || std::abs(*x - *order.travel_m) <= f.order_travel_m) continue;
      return fmt::format("it was to go to {:.4f} mm, and shows {:.4f} mm", *order.travel_m * 1e3,
                         *x * 1e3);
    }
  }
  if (!order.force_N || guard_.is_distrusted()) return {};
  const double felt_N =
      std::max(std::abs(*order.force_N - rest_N()), std::abs(order.motion.force_N - rest_N()));
  const double allowed_N = f.order_force_N + order.waver_N + kSettles * felt_N + zero_doubt_N();
  for (const auto& force : {outcome.force_N, view_.shown_force_N()}) {
    if (!force || is_there(*force, *order.force_N, order.side, allowed_N)) continue;
    return fmt::format("it was to go to {:.4f} N, and shows {:.4f} N", *order.force_N, *force);
  }
  return {};
}

Task<Result<>> FrameTruth::believe(const MotionOrder& order, const MotionOutcome& outcome) const {
  if (!plausible_ || outcome.reason != MotionEnd::target) co_return Result<>();
  const MonoTime limit = setup_.clock.now() + from_seconds(plausible_->figures().settled_s);
  std::string why = disagreement(order, outcome);
  while (!why.empty() && setup_.clock.now() < limit) {
    co_await setup_.clock.wait_for(10ms);
    why = disagreement(order, outcome);
  }
  if (why.empty()) co_return Result<>();
  log_.event(EventKind::contradiction, why);
  co_return fail(Errc::refused, "step {}: the frame says DONE, but that is not true: {}",
                 log_.step_id(), why);
}

void FrameTruth::know_contact(double travel_m, double felt_N, double stiffness_N_m) {
  if (!plausible_) return;
  plausible_->press().know(setup_.clock.now(), travel_m, felt_N, stiffness_N_m);
}

void FrameTruth::zero_travel(double travel_m) {
  forget_contact();
  if (pressing_ != nullptr) pressing_->zero_travel(travel_m);
}

std::optional<double> FrameTruth::furthest_m(double force_N) const {
  if (!plausible_) return std::nullopt;
  return plausible_->press().furthest_m(setup_.clock.now(), force_N - rest_N(),
                                        plausible_->figures().order_force_N,
                                        plausible_->travel_doubt_m());
}

}  // namespace lcrig
