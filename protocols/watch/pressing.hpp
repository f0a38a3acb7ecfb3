// SPDX-License-Identifier: Apache-2.0
// Knows the force on the specimen before each motion: whether the motion may begin, what the device
// has to watch meanwhile, and, afterwards, whether the prediction held. Pure logic, used by Motions
// and FrameTruth.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/result.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/plan/forecast.hpp"
#include "protocols/plan/limits.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

class Pressing {
 public:
  Pressing(Forecast forecast, FrameCapabilities caps)
      : forecast_(std::move(forecast)), caps_(std::move(caps)) {}

  // One motion that may begin.
  struct Permit {
    Permit() = default;
    FrameLimits limits;  // of the device, while it lasts
    Length guard;  // travel at which a search for a force has to stand
    std::optional<double> threshold_N;  // where the device shall stop; absent: not at a force
    double worst_N = 0;  // largest force until it stands
    std::optional<double> expected_N;
    bool presses = false;  // may end in the specimen
  };
  struct State {  // that a motion begins in
    State() = default;
    BoundLimits limits;  // placed, if contact is known
    double force_max_N = 0;  // of the limits, less what the cell shows below zero at rest
    double rest_N = 0, noise_N = 0;  // of an unloaded cell: mean, and scatter of a sample
    std::optional<double> travel_m, force_N;  // now
    std::optional<double> contact_m;  // machine travel of gap zero
    double contact_N = 0;  // beyond rest, there
  };
  // Errors: invalid_request, with the speed that would be allowed; nothing has moved.
  Result<Permit> to_force(const State& now, double force_N, double speed_m_s) const;
  Result<Permit> to_travel(const State& now, double travel_m, double speed_m_s) const;
  Result<Permit> ramp(const State& now, double force_N, double rate_N_s) const;
  // Away from the specimen, with the limits as they are.
  Permit away(const State& now) const;

  // A stiffness found at contact, on the way back from this force.
  void measured(double felt_N, double stiffness_N_m) { forecast_.measured(felt_N, stiffness_N_m); }
  // Whether the force may have gone to `felt_N`, from where that was measured, in a motion that was
  // to stop at `force_N`. All of them beyond rest.
  bool explains(double felt_N, double stiffness_N_m, double force_N, double speed_m_s,
                double noise_N) const;
  // A new zero of travel.
  void zero_travel(double travel_m) { caps_ = with_zero_at(caps_, travel_m); }
  const Forecast& forecast() const { return forecast_; }

  // The motion begins; every sample until `end` belongs to it.
  void begin(const Permit& permit);
  void add(std::span<const FrameSample> samples);
  // The last digit of the travel, as far as motions showed it; 0: not known.
  double travel_digit_m() const { return digit_.digit_m(); }
  struct Comparison {
    double threshold_N = 0, predicted_N = 0, observed_N = 0;
    std::optional<double> expected_N;
    bool exceeded = false;
    template <EventKind kind>
    OvershootOf<kind> event() const {
      return {threshold_N, predicted_N, expected_N, observed_N};
    }
  };
  // nullopt when there is nothing to compare: the motion was not to stop at a force, or it ended
  // before and kept its bound.
  std::optional<Comparison> end(const MotionOutcome& outcome, double noise_N);
  // The force that is shown means nothing any more.
  void distrust(std::string why) { broken_ = std::move(why); }
  // Why nothing may be pressed any more in this run.
  const std::optional<std::string>& broken() const { return broken_; }

 private:
  Result<> check(double worst_N, const State& now, double force_N, double speed_m_s) const;

  Forecast forecast_;
  FrameCapabilities caps_;
  std::optional<Permit> open_;
  std::optional<double> peak_N_;
  TravelDigit digit_;
  std::optional<std::string> broken_;
};

}  // namespace lcrig
