// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan/check.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

// Factors on a noise, for the next look. The first applies to a noise that is known without a look:
// one of 20 samples may find 1.5 times as much, and takes 1.8 times that to be sure.
constexpr double kByALook = 2.8, kAtLeastAnew = 2;

// Tries slower settings first.
Aperture usable_aperture(const LcrSettings& settings, const LcrCapabilities& caps, double longest_s,
                         bool& found) {
  for (const Aperture a : {Aperture::slow, Aperture::medium, Aperture::fast}) {
    LcrSettings s = settings;
    s.aperture = a;
    found = !exceeds(to_seconds(caps.conversion_time(s)), longest_s);
    if (found) return a;
  }
  return Aperture::fast;
}

}  // namespace

std::optional<double> force_noise_N(const Rig& rig) {
  if (rig.force_noise_N || !rig.noise) return rig.force_noise_N;
  return rig.noise->force_N;
}

double sure_force_noise_N(const Rig& rig) {
  const double seen_N = rig.force_scatter ? rig.force_scatter->sure_noise_N() : 0;
  return std::max(seen_N, force_noise_N(rig).value_or(0));
}

double sure_force_noise_anew_N(const Rig& rig) {
  const double noise_N = sure_force_noise_N(rig);
  if (!rig.force_scatter) return kByALook * noise_N;
  return std::max(kAtLeastAnew * noise_N, rig.force_scatter->sure_noise_anew_N());
}

double target_force_N(const Target& target, const Environment& env, const Rig& rig) {
  return target_force_N(target, env,
                        LoadFactors(rig.pressure.area_m2().value_or(0), rig.gravity_m_s2));
}

Rig rig_for(const Protocol& protocol, Rig rig) {
  rig.pressure.on = protocol.pressure_on;
  return rig;
}

MaybeOutside check_force(double force, const BoundLimits& limits, const Rig& rig) {
  const bool high = exceeds(force, limits.force_max_N);
  if (high || exceeds(-force, -limits.force_min_N)) {
    return Outside(fmt::format("a force of {:.4g} N, the limits allow {:.4g} to {:.4g} N", force,
                               limits.force_min_N, limits.force_max_N),
                   high ? limits.force_max_N : limits.force_min_N);
  }
  const double cell = rig.frame.force_max.si();
  if (cell > 0 && exceeds(std::abs(force), cell)) {
    return Outside(fmt::format("a force of {:.4g} N, the load cell ends at {:.4g} N", force, cell),
                   std::copysign(cell, force));
  }
  return std::nullopt;
}

MaybeOutside check_travel(double travel, const BoundLimits& limits, const Rig& rig) {
  const bool high = limits.travel_min_m && exceeds(travel, *limits.travel_max_m);
  if (high || (limits.travel_min_m && exceeds(-travel, -*limits.travel_min_m))) {
    return Outside(
        fmt::format("a travel of {:.4g} mm, the limits allow {:.4g} to {:.4g} mm", travel * 1e3,
                    *limits.travel_min_m * 1e3, *limits.travel_max_m * 1e3),
        high ? *limits.travel_max_m : *limits.travel_min_m);
  }
  const double lowest = rig.frame.travel_min.si(), highest = rig.frame.travel_max.si();
  if (lowest < highest && (exceeds(travel, highest) || exceeds(-travel, -lowest))) {
    return Outside(fmt::format("a travel of {:.4g} mm, the frame reaches {:.4g} to {:.4g} mm",
                               travel * 1e3, lowest * 1e3, highest * 1e3),
                   travel > highest ? highest : lowest);
  }
  return std::nullopt;
}

MaybeOutside check_speed(double speed, const BoundLimits& limits, const Rig& rig) {
  if (limits.speed_max_m_s && exceeds(speed, *limits.speed_max_m_s)) {
    return Outside(fmt::format("a speed of {:.4g} mm/s, the limits allow {:.4g} mm/s", speed * 1e3,
                               *limits.speed_max_m_s * 1e3),
                   *limits.speed_max_m_s);
  }
  const double low = rig.frame.speed_min.si(), high = rig.frame.speed_max.si();
  if (high > 0 && (exceeds(speed, high) || exceeds(low, speed))) {
    return Outside(fmt::format("a speed of {:.4g} mm/s, the frame moves at {:.4g} to {:.4g} mm/s",
                               speed * 1e3, low * 1e3, high * 1e3),
                   speed > high ? high : low);
  }
  return std::nullopt;
}

MaybeOutside check_force_limit(double force, const FrameCapabilities& caps) {
  const double cell = caps.force_max.si();
  if (!(cell > 0) || !exceeds(std::abs(force), cell)) return std::nullopt;
  return Outside(
      fmt::format("a limit of {:.4g} N, the load cell is good for {:.4g} N", force, cell),
      std::copysign(cell, force));
}

MaybeOutside check_travel_limit(double travel, const FrameCapabilities& caps) {
  const double low = caps.travel_min.si(), high = caps.travel_max.si();
  if (low >= high || (!exceeds(travel, high) && !exceeds(-travel, -low))) return std::nullopt;
  return Outside(fmt::format("a limit of {:.4g} mm, this frame goes from {:.4g} to {:.4g} mm",
                             travel * 1e3, low * 1e3, high * 1e3),
                 travel > high ? high : low);
}

Words check_lcr(const LcrSettings& s, const LcrCapabilities& caps) {
  const auto outside = [](double v, double low, double high, std::string_view what,
                          std::string_view unit) -> Words {
    if (!exceeds(v, high) && !exceeds(low, v)) return std::nullopt;
    return fmt::format("a {} of {:.6g} {}, the meter offers {:.6g} to {:.6g} {}", what, v, unit,
                       low, high, unit);
  };
  if (std::find(caps.functions.begin(), caps.functions.end(), s.function) == caps.functions.end()) {
    return fmt::format("the function {}, which this meter does not have", to_string(s.function));
  }
  if (auto r = outside(s.frequency.si(), caps.frequency_min.si(), caps.frequency_max.si(),
                       "frequency", "Hz")) {
    return r;
  }
  if (auto r = outside(s.level.si(), caps.level_min.si(), caps.level_max.si(), "level", "V")) {
    return r;
  }
  if (s.bias) {
    if (auto r = outside(s.bias->si(), caps.bias_min.si(), caps.bias_max.si(), "bias", "V")) {
      return r;
    }
  }
  return outside(s.average, 1, caps.average_max, "number of averages", "readings");
}

Words check_measure(std::int64_t count, double within_s, const LcrSettings& s,
                    const LcrCapabilities& caps) {
  const double longest = within_s / static_cast<double>(count);
  const double takes = to_seconds(caps.conversion_time(s));
  const double every = reading_interval_s(s, caps);
  if (!exceeds(every, longest)) return std::nullopt;
  if (!exceeds(takes, longest)) {
    return fmt::format(
        "{} readings in {:.4g} s need one every {:.0f} ms, the meter is polled every {:.0f} ms: "
        "use a shorter poll_interval_ms, fewer readings or a longer time",
        count, within_s, std::floor(longest * 1e3 + 1e-9), every * 1e3);
  }
  bool found = false;
  const Aperture better = usable_aperture(s, caps, longest, found);
  const std::string average =
      s.average > 1 ? fmt::format(" with {} averages", s.average) : std::string();
  const std::string advice = found           ? fmt::format("use {}", to_string(better))
                             : s.average > 1 ? "use fewer averages, fewer readings or a longer time"
                                             : "use fewer readings or a longer time";
  return fmt::format(
      "{} readings in {:.4g} s need a conversion of at most {:.0f} ms; aperture {}{} takes {:.0f} "
      "ms: {}",
      count, within_s, std::floor(longest * 1e3 + 1e-9), to_string(s.aperture), average,
      takes * 1e3, advice);
}

double reading_interval_s(const LcrSettings& settings, const LcrCapabilities& caps) {
  return to_seconds(
      std::max(caps.conversion_time(settings), settings.poll_interval.value_or(Duration::zero())));
}

Words check_capability(const Step& step, const FrameCapabilities& caps) {
  const StepFacts facts = facts_of(step);
  if (facts.moves && !caps.motion) {
    return fmt::format("{} needs a frame that moves; this rig {}", kind_of(step),
                       caps.weights ? "has dead weights: use place_weight, as static-weights does"
                                    : "cannot move");
  }
  if (facts.places_weight && !caps.weights) {
    return fmt::format(
        "{} needs a dead-weight rig; this frame loads by motion: use ramp or move_until, as "
        "static-frame does",
        kind_of(step));
  }
  return std::nullopt;
}

}  // namespace lcrig
