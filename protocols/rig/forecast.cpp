// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/forecast.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/rig/constants.hpp"

namespace lcrig {

namespace {

double reaction_s(const FrameCapabilities& caps) {
  return to_seconds(caps.reaction) + (caps.device_stop ? 0 : kHostLatency_s.value);
}

// `reaction` bounds the filter where it is not stated.
Duration filter_of(const FrameCapabilities& caps) {
  return caps.filter.value_or(caps.reaction);
}

}  // namespace

double stopping_way_m(const FrameCapabilities& caps, double speed_m_s) {
  const double v = std::abs(speed_m_s), a = caps.deceleration.si();
  return v * reaction_s(caps) + (a > 0 ? v * v / (2 * a) : 0);
}

double speed_within_m_s(const FrameCapabilities& caps, double way_m) {
  const double tau = reaction_s(caps), a = caps.deceleration.si();
  if (!(way_m > 0)) return 0;
  if (!(a > 0)) return tau > 0 ? way_m / tau : std::numeric_limits<double>::infinity();
  // The root of v tau + v^2/2a = way, in the form without cancellation.
  return 2 * way_m / (tau + std::sqrt(tau * tau + 2 * way_m / a));
}

Duration shown_after(const FrameCapabilities& caps) {
  return kFilterTimes.count() * filter_of(caps) + kUnderWay_s.duration();
}

Duration settles_after(const FrameCapabilities& caps) {
  return std::max<Duration>(Duration::zero(),
                            kSettleTimes.count() * filter_of(caps) - kBatch_s.duration());
}

Forecast::Forecast(FrameCapabilities caps, ForceBound bound, std::optional<ForceBound> expected,
                   std::optional<ForceBound> if_free)
    : caps_(std::move(caps)),
      bound_(std::move(bound)),
      expected_(std::move(expected)),
      if_free_(std::move(if_free)) {}

double Forecast::growth(double from_N, double to_N) const {
  if (to_N <= from_N) return expected_ ? growth_margin() : 1;
  if (!expected_) return std::numeric_limits<double>::infinity();
  double ratio = std::sqrt(to_N / from_N);
  for (const auto* contact : {&expected_, &if_free_}) {
    if (!*contact || !(*contact)->is_bounded()) continue;
    ratio = std::max(ratio, (*contact)->stiffness_N_m(to_N) / (*contact)->stiffness_N_m(from_N));
  }
  return growth_margin() * ratio;
}

// The stiffness was measured on the way back from a force as a slope. Of that way it is the slope
// of the last half, so it belongs to half of the force.
void Forecast::limit_to(ForceBound& bound, double felt_N, double stiffness_N_m) const {
  const double at_N = 0.5 * felt_N;
  bound.limit_to(stiffness_N_m, [&](double force) { return growth(at_N, force); });
}

void Forecast::expect_measurement(double felt_N) {
  if (!expected_) return;
  if_measured_ = bound_;
  limit_to(*if_measured_, felt_N, expected_->stiffness_N_m(0.5 * felt_N));
}

void Forecast::measured(double felt_N, double stiffness_N_m) {
  limit_to(bound_, felt_N, stiffness_N_m);
  measured_ = true;
}

double Forecast::stop_N(double force_N, double speed_m_s) const {
  return bound_.force_after_N(force_N, stopping_way_m(caps_, speed_m_s));
}

std::optional<double> Forecast::expected_stop_N(double force_N, double speed_m_s) const {
  if (!expected_) return std::nullopt;
  return expected_->force_after_N(force_N, stopping_way_m(caps_, speed_m_s));
}

std::optional<double> Forecast::stop_if_measured_N(double force_N, double speed_m_s) const {
  if (!if_measured_) return std::nullopt;
  return if_measured_->force_after_N(force_N, stopping_way_m(caps_, speed_m_s));
}

double Forecast::fastest_m_s(double force_N, double most_N) const {
  return speed_within_m_s(caps_, bound_.way_m(force_N, most_N));
}

double Forecast::fastest_if_measured_m_s(double force_N, double most_N) const {
  if (!if_measured_) return 0;
  return speed_within_m_s(caps_, if_measured_->way_m(force_N, most_N));
}

double Forecast::expected_fastest_m_s(double force_N, double most_N) const {
  if (!expected_) return 0;
  return speed_within_m_s(caps_, expected_->way_m(force_N, most_N));
}

double Forecast::trip_N(double speed_m_s, double most_N) const {
  return bound_.force_before_N(most_N, stopping_way_m(caps_, speed_m_s));
}

double Forecast::ramp_N(double from_N, double to_N, double rate_N_s) const {
  return ramp_N(bound_, from_N, to_N, rate_N_s);
}

std::optional<double> Forecast::ramp_if_measured_N(double from_N, double to_N,
                                                   double rate_N_s) const {
  if (!if_measured_) return std::nullopt;
  return ramp_N(*if_measured_, from_N, to_N, rate_N_s);
}

double Forecast::ramp_N(const ForceBound& bound, double from_N, double to_N,
                        double rate_N_s) const {
  const ForceLoop& loop = caps_.force_loop.value();
  const double ripple = loop.ripple.si();
  double most = std::max(from_N, to_N) + ripple;
  if (to_N > from_N) most = std::max(most, to_N + rate_N_s * to_seconds(loop.lag) + ripple);
  // The probe makes contact at the speed of the approach; the loop closes once the device has felt
  // it.
  if (from_N <= loop.contact.si() && to_N > 0) {
    const double way = stopping_way_m(caps_, loop.approach.si());
    most = std::max(most, bound.force_after_N(loop.contact.si(), way));
  }
  return most;
}

double Forecast::fastest_ramp_N_s(double to_N, double most_N) const {
  const ForceLoop& loop = caps_.force_loop.value();
  const double room = most_N - to_N - loop.ripple.si();
  if (room < 0) return 0;
  const double lag = to_seconds(loop.lag);
  const double most = loop.rate_max.si();
  return lag > 0 ? std::min(most, room / lag) : most;
}

bool Forecast::loop_can_hold(double force_N) const {
  return caps_.force_loop && bound_.stiffness_N_m(force_N) <= caps_.force_loop->stiffness_max.si();
}

bool Forecast::loop_can_hold_if_measured(double force_N) const {
  return caps_.force_loop && if_measured_ &&
         if_measured_->stiffness_N_m(force_N) <= caps_.force_loop->stiffness_max.si();
}

double Forecast::lost_way_m(double speed_m_s) const {
  return std::abs(speed_m_s) * kLinkSilence_s + stopping_way_m(caps_, speed_m_s);
}

}  // namespace lcrig
