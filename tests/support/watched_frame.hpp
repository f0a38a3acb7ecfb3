// SPDX-License-Identifier: Apache-2.0
// The state of a rig and its checks, without a run: a test orders, shows samples, and sees what the
// checks find.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "protocols/checks/check.hpp"

namespace lcrig {

inline FrameCapabilities watched_capabilities() {
  FrameCapabilities c;
  c.motion = c.device_stop = true;
  c.force_max = Force::from_si(20);
  c.speed_max = Velocity::from_si(10e-3);
  c.travel_max = Length::from_si(60e-3);
  c.reaction = std::chrono::milliseconds(8);
  c.deceleration = Acceleration::from_si(0.2);
  return c;
}

inline RigFacts watched_facts(FrameCapabilities caps = watched_capabilities()) {
  RigFacts facts;
  facts.limits.force_min_N = -20;
  facts.limits.force_max_N = 20;
  facts.rate_Hz = 50;
  facts.cell = caps.cell();
  facts.frame = std::move(caps);
  return facts;
}

inline Forecast watched_forecast(double stiffness_N_m = 120e3,
                                 const FrameCapabilities& caps = watched_capabilities()) {
  return Forecast(caps, ForceBound({}, stiffness_N_m), {});
}

// Tolerances in round numbers.
inline Tolerances round_tolerances() {
  Tolerances t;
  t.frozen_samples = 10;
  t.stall_s = 2;
  t.against_m = 3e-6;
  t.standing_m = 5e-6;
  t.order_force_N = 0.01;
  t.contact_force_N = 5e-3;
  return t;
}

// Fifty samples per second of a cell with a noise of 1 mN and a travel that shows nanometres.
class WatchedFrame {
 public:
  explicit WatchedFrame(Tolerances tolerances = round_tolerances(),
                        RigFacts facts = watched_facts())
      : rig(std::move(facts), watched_forecast()) {
    rig.tolerances = tolerances;
    rig.is_prepared = true;
  }
  void order(const Order& order) { apply(to_input(order)); }
  void stand(std::optional<double> travel_m = std::nullopt) {
    WatchInputEvent e(WatchInput::standstill);
    e.travel_m = travel_m;
    apply(e);
  }
  RigState::Applied apply(const WatchInputEvent& input, const RestMeasurement* rest = nullptr) {
    return rig.apply(input, rest, t);
  }
  std::optional<Finding> take(const FrameSample& sample) {
    const auto compared = rig.apply(sample);
    EXPECT_FALSE(rig.broken_invariant()) << *rig.broken_invariant();
    const std::vector<Finding> findings = find(rig, Sight{sample, compared});
    const Finding* worst = most_severe(findings);
    return worst != nullptr ? std::optional(*worst) : std::nullopt;
  }
  std::optional<Finding> show(double travel_m, double force_N, std::uint32_t flags = 0) {
    FrameSample s;
    t += std::chrono::milliseconds(20);
    s.received = t;
    s.travel_m = travel_m;
    s.force_N = is_frozen ? 0.5 : std::round((force_N + noise_(random_)) * 1e5) / 1e5;
    s.flags = flags;
    return take(s);
  }
  // Seconds until something is found. nullopt: not within `most_s`.
  template <class At>
  std::optional<double> until_found(double most_s, At at) {
    const MonoTime begin = t;
    while (to_seconds(t - begin) < most_s) {
      const auto [travel_m, force_N] = at(to_seconds(t - begin) + 0.02);
      found = show(travel_m, force_N);
      if (found) return to_seconds(t - begin);
    }
    return std::nullopt;
  }

  RigState rig;
  MonoTime t = MonoTime() + std::chrono::seconds(100);
  bool is_frozen = false;
  std::optional<Finding> found;

 private:
  std::mt19937 random_{7};
  std::normal_distribution<double> noise_{0, 1e-3};
};

using Place = std::pair<double, double>;  // the travel and the force that a frame shows

// Towards the specimen.
inline Order pressing(double speed_m_s) {
  Order m;
  m.direction = 1;
  m.speed_m_s = speed_m_s;
  m.against_N = 0.02;
  return m;
}

}  // namespace lcrig
