// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

// A specimen relaxes while it is pressed slowly, and gives back less than it took.
constexpr double kMayRelax = 0.3, kMayGiveBack = 0.05;  // as parts of the felt force
constexpr double kLeastOfLimit = 0.02;

}  // namespace

FrameTruth::FrameTruth(const WatchedRig& rig, const Guard& guard, Pressing* pressing,
                       TellFigures tell)
    : rig_(rig), guard_(guard), pressing_(pressing), tell_(std::move(tell)) {
  if (pressing_ != nullptr && rig_.commands) plausible_.emplace(WatchFigures());
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
      watch_figures(rig_.frame, pressing_->forecast().bound(), rig_.limits.force_max_N,
                    rig_.rate_Hz, scatter_, scatter_.noise_N);
  // The scatter is a new estimate each time, but an earlier promise to notice a frozen cell is
  // kept.
  const WatchFigures& before = plausible_->figures();
  if (before.frozen_samples &&
      figures.frozen_samples.value_or(INT64_MAX) > *before.frozen_samples) {
    figures.frozen_samples = before.frozen_samples;
    figures.frozen_force_s = before.frozen_force_s;
  }
  plausible_->set_figures(figures);
  tell_(plausible_->figures());
}

double FrameTruth::load_doubt_N() const {
  const double noise_N = bare_ ? bare_->scatter_N() : 0;
  return std::max(5 * noise_N, 0.01 * rig_.limits.force_max_N);
}

bool FrameTruth::is_loaded(double force_N) const {
  return force_N - most_bare_N() > load_doubt_N();
}

bool FrameTruth::is_pulled(double force_N) const {
  return bare_N() - force_N - zero_doubt_N() > load_doubt_N();
}

double FrameTruth::zero_doubt_N() const {
  return rig_.cell.zero_error_N(rig_.frame.force_max.si());
}

// The motion with the tolerances that apply from now on.
Plausibility::Motion FrameTruth::motion_now(double direction, double speed_m_s,
                                            const ShownForce& shown) const {
  Plausibility::Motion m;
  m.direction = direction;
  m.speed_m_s = speed_m_s;
  m.force_N = shown.last_N.value_or(0);
  // For a motion into the specimen the last known force counts, however old it is.
  m.force_known = direction >= 0 || shown.is_present;
  m.rest_N = rest_N();
  m.free_N = most_bare_N();
  const double felt_N = std::abs(m.force_N - m.rest_N);
  // The force of a frame that hunts in contact varies by more than the noise of its cell.
  const double noise_N =
      std::max({sure_noise_N(), shown.wavers_N, plausible_ ? plausible_->wavers_N() : 0});
  const double least_N =
      std::max(kDifferenceSigmas * noise_N, kLeastOfLimit * guard_.force_max_N());
  m.against_N = least_N + (direction > 0 ? kMayRelax : kMayGiveBack) * felt_N + zero_doubt_N();
  m.drift_N_s = drift_N_s_;
  m.shown_after = lcrig::shown_after(rig_.frame);
  if (direction > 0) {  // pressing a specimen never makes it pull
    const double room_N = m.force_N - guard_.limits().force_min_N;
    m.against_N = std::min(m.against_N, std::max(room_N, kDifferenceSigmas * noise_N));
  }
  return m;
}

Plausibility::Motion FrameTruth::hold_now(const ShownForce& shown) const {
  Plausibility::Motion m = motion_now(0, 0, shown);
  m.holds = true;
  if (const auto& loop = rig_.frame.force_loop) m.waver_N = loop->ripple.si();
  return m;
}

void FrameTruth::begin(const Plausibility::Motion& motion, MonoTime now) {
  if (plausible_) plausible_->begin(motion, now);
}

void FrameTruth::stand(MonoTime now, std::optional<double> travel_m) {
  if (plausible_) plausible_->stand(now, travel_m);
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

void FrameTruth::know_contact(MonoTime now, double travel_m, double felt_N, double stiffness_N_m) {
  if (!plausible_) return;
  plausible_->press().know(now, travel_m, felt_N, stiffness_N_m);
}

void FrameTruth::zero_travel(double travel_m) {
  forget_contact();
  if (pressing_ != nullptr) pressing_->zero_travel(travel_m);
}

std::optional<double> FrameTruth::furthest_m(MonoTime now, double force_N) const {
  if (!plausible_) return std::nullopt;
  return plausible_->press().furthest_m(
      now, force_N - rest_N(), plausible_->figures().order_force_N, plausible_->travel_doubt_m());
}

}  // namespace lcrig
