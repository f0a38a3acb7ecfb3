// SPDX-License-Identifier: Apache-2.0
// Predicts the force on the specimen before each motion: decides whether it may begin, sets the
// limits that the device watches meanwhile, and afterwards compares the prediction with the force.
// Pure logic, used by Motions and FrameTruth.
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

  // Permission for one motion.
  struct Permit {
    Permit() = default;
    FrameLimits limits;  // limits of the device during the motion
    Length guard;  // travel at which a search for a force must stop
    std::optional<double> threshold_N;  // force at which the device has to stop; absent: it does
                                        // not stop at a force
    double worst_N = 0;  // largest force until it stands
    std::optional<double> expected_N;
    bool presses = false;  // it may end in the specimen
    std::optional<double> from_m;  // travel at its beginning
  };
  struct State {  // at the start of a motion
    State() = default;
    BoundLimits limits;  // with the gap limits applied, if contact is known
    double force_max_N = 0;  // of the limits, less the amount by which the cell at rest shows below
                             // zero
    double rest_N = 0, noise_N = 0;  // of the unloaded cell: mean, and scatter of a sample
    std::optional<double> travel_m, force_N;  // at present
    std::optional<double> contact_m;  // machine travel of gap zero
    double contact_N = 0;  // force at gap zero, beyond rest
  };
  // Errors: invalid_request, with the speed that would be allowed; nothing has moved.
  Result<Permit> to_force(const State& now, double force_N, double speed_m_s) const;
  Result<Permit> to_travel(const State& now, double travel_m, double speed_m_s) const;
  Result<Permit> ramp(const State& now, double force_N, double rate_N_s) const;
  // Motion away from the specimen, with unchanged limits.
  Permit away(const State& now) const;

  // Takes a stiffness that was measured at contact, on the way back from this force.
  void measured(double felt_N, double stiffness_N_m) { forecast_.measured(felt_N, stiffness_N_m); }
  // The search measured none. `why`: in a few words.
  void not_measured(const std::string& why) { not_measured_ = ": " + why; }
  // Whether a contact of this stiffness explains that a motion, ordered to stop at `force_N`, ended
  // at `felt_N`. All forces are beyond rest.
  bool explains(double felt_N, double stiffness_N_m, double force_N, double speed_m_s,
                double noise_N) const;
  // A new zero of travel.
  void zero_travel(double travel_m) { caps_ = with_zero_at(caps_, travel_m); }
  const Forecast& forecast() const { return forecast_; }

  struct Comparison {
    double threshold_N = 0, predicted_N = 0, observed_N = 0;
    std::optional<double> expected_N;
    bool exceeded = false;
    template <EventKind kind>
    OvershootOf<kind> event() const {
      return {threshold_N, predicted_N, expected_N, observed_N};
    }
  };
  // A motion begins. Every sample until `end` belongs to it.
  void begin(const Permit& permit);
  // The cell may show the largest force only after the end, so the samples of the next
  // shown_after() are compared, too, until a motion presses again. Returns a second comparison if
  // they show clearly more than the first one said: at once if that is more than was predicted,
  // else when the time is over.
  std::optional<Comparison> add(std::span<const FrameSample> samples);
  // The force loop may raise the force from now on, so it tells nothing of the last motion.
  void leave_to_loop() { late_.reset(); }
  // The last digit of the travel, as coarse as motions allow; 0: fine.
  double travel_digit_m() const { return digit_.digit_m(); }
  bool is_sure_of_digit() const { return digit_.is_sure(); }
  // nullopt: there is nothing to compare, because the motion was not meant to stop at a force, or
  // it ended earlier and within its bound.
  std::optional<Comparison> end(const MotionOutcome& outcome, double noise_N);
  // The shown force no longer means anything.
  void distrust(std::string why) { broken_ = std::move(why); }
  // Why this run may not press any more.
  const std::optional<std::string>& broken() const { return broken_; }

 private:
  Result<> check(double worst_N, const State& now, double force_N, double speed_m_s) const;
  void judge(Comparison& c, double noise_N);
  bool is_beyond(double observed_N, double predicted_N, double noise_N) const;
  std::optional<Comparison> add_late(const FrameSample& sample);

  Forecast forecast_;
  FrameCapabilities caps_;
  std::optional<Permit> open_;
  std::optional<double> peak_N_;
  struct Late {  // the last motion that pressed, while the cell may still follow it
    Late(const Comparison& c, double n, bool t) : first(c), noise_N(n), told(t) {}
    Comparison first;
    double noise_N;
    bool told;  // `first` was returned
    std::optional<MonoTime> until;  // counts from the first sample after its end
    double peak_N = 0;
  };
  std::optional<Late> late_;
  TravelDigit digit_;
  std::string not_measured_;
  std::optional<std::string> broken_;
};

}  // namespace lcrig
