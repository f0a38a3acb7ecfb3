// SPDX-License-Identifier: Apache-2.0
// Computes the worst that a motion can do to the specimen. Plan and run share it, on a bench and on
// a rig.
#pragma once

#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/rig/force_bound.hpp"

namespace lcrig {

// The longest way in which the device stops: v tau + v^2/2a (docs/frame-link.md, section 2). A
// frame that cannot stop by itself also needs the host's time.
double stopping_way_m(const FrameCapabilities& caps, double speed_m_s);
// The fastest speed that stops within this way; 0: none.
double speed_within_m_s(const FrameCapabilities& caps, double way_m);
// How long after the end of a motion the force shown may still follow it. The time constant of the
// cell's filter is stated, or bounded by `reaction_s`; after three of them 95 % of a step are
// shown. A sample may be 0.2 s on its way (docs/frame-link.md, sections 2 and 5).
Duration shown_after(const FrameCapabilities& caps);
// How long to wait after a motion, beyond the 0.1 s in which its samples arrive anyway, until the
// cell shows less than a hundredth of the force that it lost.
Duration settles_after(const FrameCapabilities& caps);

class Forecast {
 public:
  // `expected`: the contact by the model of the specimen, if there is one. `if_free`: the same if
  // nothing held the specimen sideways.
  Forecast(FrameCapabilities caps, ForceBound bound, std::optional<ForceBound> expected,
           std::optional<ForceBound> if_free = {});

  const ForceBound& bound() const { return bound_; }
  const std::optional<ForceBound>& expected() const { return expected_; }
  const std::optional<ForceBound>& if_free() const { return if_free_; }
  // Takes a stiffness that was measured, as an upper bound, on the way back from `felt_N`. From
  // there on the contact is assumed to stiffen at most 1.5 times as much as the model's does, or as
  // that of the free specimen, or as the root of the force. F = k x (1 + c x) stiffens at most like
  // that root, whatever its c, and a Hertzian contact (cube root) less.
  void measured(double felt_N, double stiffness_N_m);
  static double growth_margin() { return 1.5; }
  // Announces that a search will stop at this force and measure the stiffness that the model
  // expects.
  void expect_measurement(double felt_N);
  bool is_measured() const { return measured_; }

  // Largest force of a motion at this speed that the device stops at `force_N`.
  double stop_N(double force_N, double speed_m_s) const;
  // The same for the expected contact; nullopt without a model.
  std::optional<double> expected_stop_N(double force_N, double speed_m_s) const;
  // The same as stop_N if a measurement finds the expected stiffness; nullopt without a model.
  std::optional<double> stop_if_measured_N(double force_N, double speed_m_s) const;
  // The highest speed at which a stop at `force_N` ends at no more than `most_N`; 0: none. For the
  // stiffest possible contact, for the contact after a measurement, and for the expected one.
  double fastest_m_s(double force_N, double most_N) const;
  double fastest_if_measured_m_s(double force_N, double most_N) const;
  double expected_fastest_m_s(double force_N, double most_N) const;
  // The largest force at which the device may begin to stop and still end at no more than `most_N`.
  double trip_N(double speed_m_s, double most_N) const;
  // Largest force of a force-controlled ramp, including its approach. The loop must be known.
  double ramp_N(double from_N, double to_N, double rate_N_s) const;
  // The fastest ramp whose force stays within `most_N`; 0: none.
  double fastest_ramp_N_s(double to_N, double most_N) const;
  std::optional<double> ramp_if_measured_N(double from_N, double to_N, double rate_N_s) const;
  // Whether the force loop can control a contact as stiff as this one may be at `force_N`.
  bool loop_can_hold(double force_N) const;
  bool loop_can_hold_if_measured(double force_N) const;
  // How far a frame moves on after nobody commands it any more (docs/frame-link.md, section 6).
  double lost_way_m(double speed_m_s) const;

 private:
  double growth(double from_N, double to_N) const;
  void limit_to(ForceBound& bound, double felt_N, double stiffness_N_m) const;
  double ramp_N(const ForceBound& bound, double from_N, double to_N, double rate_N_s) const;

  FrameCapabilities caps_;
  ForceBound bound_;
  std::optional<ForceBound> expected_, if_free_;
  std::optional<ForceBound> if_measured_;
  bool measured_ = false;
};

}  // namespace lcrig
