// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/pressing.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lcrig {

bool Pressing::is_beyond(double observed_N, double predicted_N, double noise_N) const {
  return observed_N > predicted_N * (1 + caps_.cell().part()) + kSampleSigmas * noise_N;
}

Pressing::Permit Pressing::away(const State& now) const {
  Permit permit;
  permit.limits = device_limits(now.limits, caps_);
  permit.limits.force_max = Force::from_si(now.force_max_N);
  permit.guard = permit.limits.travel_max;
  permit.worst_N = now.force_N.value_or(0);
  permit.from_m = now.travel_m;
  return permit;
}

Result<> Pressing::check(double worst_N, const State& now, double force_N, double speed_m_s) const {
  if (broken_) return fail(Errc::limit_tripped, "{}", *broken_);
  if (!exceeds(worst_N, now.force_max_N)) return {};
  const double fastest = forecast_.fastest_m_s(force_N - now.rest_N, now.force_max_N - now.rest_N);
  const std::string measured = forecast_.is_measured()
                                   ? "as measured at contact"
                                   : "nothing was measured at contact" + not_measured_;
  return fail(
      Errc::invalid_request,
      "{:.4g} mm/s to {:.4g} N may end at {:.3g} N on a contact of up to {:.3g} N/mm ({}), the "
      "limit is {:.4g} N: {}",
      speed_m_s * 1e3, force_N, worst_N, forecast_.bound().stiffness_N_m(worst_N) * 1e-3, measured,
      now.force_max_N,
      fastest > 0 ? fmt::format("at most {:.3g} mm/s is allowed", fastest * 1e3)
                  : std::string("state frame.stiffness_N_mm in the config"));
}

// The specimen feels the force beyond rest, so the forecast counts from there.
Result<Pressing::Permit> Pressing::to_force(const State& now, double force_N,
                                            double speed_m_s) const {
  Permit permit = away(now);
  const double felt = force_N - now.rest_N;
  permit.threshold_N = force_N;
  permit.presses = true;
  permit.worst_N = now.rest_N + forecast_.stop_N(felt, speed_m_s);
  if (const auto expected = forecast_.expected_stop_N(felt, speed_m_s)) {
    permit.expected_N = now.rest_N + *expected;
  }
  auto allowed = check(permit.worst_N, now, force_N, speed_m_s);
  if (!allowed) return fail(allowed.error());
  // Stopping at the travel limit needs its own way.
  const double way = stopping_way_m(caps_, speed_m_s);
  permit.guard -= Length::from_si(way);
  if (now.travel_m && permit.guard.si() <= *now.travel_m) {
    return fail(Errc::limit_tripped,
                "the travel limits leave no room to press: {:.4f} mm of {:.4f} mm",
                *now.travel_m * 1e3, permit.limits.travel_max.si() * 1e3);
  }
  return permit;
}

Result<Pressing::Permit> Pressing::to_travel(const State& now, double travel_m,
                                             double speed_m_s) const {
  Permit permit = away(now);
  if (now.travel_m && travel_m <= *now.travel_m) return permit;
  const bool known = now.contact_m.has_value();
  const double depth = known ? travel_m - *now.contact_m : 0;
  if (known && depth <= 0) return permit;
  if (broken_) return fail(Errc::limit_tripped, "{}", *broken_);
  permit.presses = true;
  const double pressed = forecast_.bound().force_after_N(now.contact_N, depth);
  permit.worst_N = now.rest_N + pressed;
  if (known && !exceeds(permit.worst_N, now.force_max_N)) return permit;
  // Into the specimen, or towards one whose place is unknown, the device has to stop early.
  const double trip = forecast_.trip_N(speed_m_s, now.force_max_N - now.rest_N);
  const double least = least_trip_N(caps_, now.noise_N);
  if (trip < least) {
    return fail(
        Errc::invalid_request,
        "{:.4g} mm/s towards {}: a stop at {:.3g} N may end beyond the limit of {:.4g} N; at "
        "most {:.3g} mm/s is allowed",
        speed_m_s * 1e3, known ? "the inside of the specimen" : "a specimen that may be anywhere",
        least, now.force_max_N, forecast_.fastest_m_s(least, now.force_max_N - now.rest_N) * 1e3);
  }
  permit.worst_N = now.force_max_N;
  permit.limits.force_max = Force::from_si(std::min(now.force_max_N, now.rest_N + trip));
  return permit;
}

Result<Pressing::Permit> Pressing::ramp(const State& now, double force_N, double rate_N_s) const {
  Permit permit = away(now);
  const double from = now.force_N.value_or(now.rest_N) - now.rest_N;
  const double to = force_N - now.rest_N;
  if (to <= from) return permit;
  if (!caps_.force_loop) {
    return fail(Errc::invalid_request, "nothing is known of what bounds the frame's force loop");
  }
  if (!forecast_.loop_can_hold(to)) {
    return fail(
        Errc::invalid_request,
        "the contact may be {:.3g} N/mm stiff, the frame's force loop is good for {:.3g} N/mm",
        forecast_.bound().stiffness_N_m(to) * 1e-3, caps_.force_loop->stiffness_max.si() * 1e-3);
  }
  permit.threshold_N = force_N;
  permit.presses = true;
  permit.worst_N = now.rest_N + forecast_.ramp_N(from, to, rate_N_s);
  auto allowed = check(permit.worst_N, now, force_N, caps_.force_loop->approach.si());
  if (!allowed) return fail(allowed.error());
  return permit;
}

bool Pressing::explains(double felt_N, double stiffness_N_m, double force_N, double speed_m_s,
                        double noise_N) const {
  Forecast tried = forecast_;
  tried.measured(felt_N, stiffness_N_m);
  return !is_beyond(felt_N, tried.stop_N(force_N, speed_m_s), noise_N);
}

void Pressing::begin(const Permit& permit) {
  open_ = permit;
  peak_N_.reset();
  digit_.begin(permit.from_m);
  if (!permit.presses) return;
  // What the cell still has to show of the last motion may be more than this one presses.
  if (late_) open_->worst_N = std::max(open_->worst_N, late_->first.predicted_N);
  late_.reset();
}

std::optional<Pressing::Comparison> Pressing::add(std::span<const FrameSample> samples) {
  std::optional<Comparison> late;
  for (const FrameSample& s : samples) {
    if (late_ && !late) late = add_late(s);
    if (!open_) continue;
    if (s.travel_m) digit_.add(*s.travel_m);
    if (s.force_N) peak_N_ = std::max(peak_N_.value_or(*s.force_N), *s.force_N);
  }
  return late;
}

std::optional<Pressing::Comparison> Pressing::add_late(const FrameSample& sample) {
  if (!late_->until) late_->until = sample.received + shown_after(caps_);
  const bool over = sample.received > *late_->until;
  if (!over) late_->peak_N = std::max(late_->peak_N, sample.force_N.value_or(0));
  if (!is_beyond(late_->peak_N, late_->first.observed_N, late_->noise_N)) {
    if (over) late_.reset();
    return std::nullopt;
  }
  Comparison c = late_->first;
  c.observed_N = late_->peak_N;
  judge(c, late_->noise_N);
  if (!over && !c.exceeded) return std::nullopt;
  const bool told = std::exchange(late_, std::nullopt)->told;
  if (!told && !c.exceeded) return std::nullopt;
  return c;
}

// Once a prediction was exceeded, nothing is pressed any more.
void Pressing::judge(Comparison& c, double noise_N) {
  c.exceeded = is_beyond(c.observed_N, c.predicted_N, noise_N);
  if (!c.exceeded) return;
  broken_ = fmt::format(
      "the force went to {:.4f} N where at most {:.4f} N was predicted: specimen or frame are not "
      "what they were said to be, and nothing is pressed any more",
      c.observed_N, c.predicted_N);
}

std::optional<Pressing::Comparison> Pressing::end(const MotionOutcome& outcome, double noise_N) {
  const std::optional<Permit> permit = std::exchange(open_, std::nullopt);
  if (permit && outcome.travel_m) digit_.add(*outcome.travel_m);
  if (outcome.force_N) peak_N_ = std::max(peak_N_.value_or(*outcome.force_N), *outcome.force_N);
  if (!permit || !permit->presses || !peak_N_) return std::nullopt;
  Comparison c;
  c.threshold_N = permit->threshold_N.value_or(permit->limits.force_max.si());
  c.predicted_N = permit->worst_N;
  c.expected_N = permit->expected_N;
  c.observed_N = *peak_N_;
  judge(c, noise_N);
  const bool there = permit->threshold_N && outcome.reason == MotionEnd::target;
  if (!c.exceeded) late_.emplace(c, noise_N, there);
  if (!there && !c.exceeded) return std::nullopt;
  return c;
}

}  // namespace lcrig
