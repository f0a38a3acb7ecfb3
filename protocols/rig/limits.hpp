// SPDX-License-Identifier: Apache-2.0
// The limits of a protocol as numbers. Used by the plan, the guard and the frame itself.
#pragma once

#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/protocol.hpp"

namespace lcrig {

// True when `v` exceeds `max` by more than rounding: limits are inclusive.
bool exceeds(double v, double max);

// The smallest force at which a device can be told to stop. Below it the noise and the zero of its
// cell, which its class bounds, would stop it. `noise_N`: standard deviation of a sample.
double least_trip_N(const FrameCapabilities& caps, double noise_N);

// The largest force that a motion may be planned to end at. The guard ends a run at the first
// sample beyond the limit, so the noise of the cell needs room below it, at least as far as chance
// reaches (kSampleSigmas). `noise_N` as above, and surely not less.
double largest_end_N(double limit_N, double noise_N);

// The limits in SI, with their parameters bound. Travel and gap each have both ends or none.
struct BoundLimits {
  double force_min_N = 0, force_max_N = 0;  // those of the cell if the protocol states none
  std::optional<double> travel_min_m, travel_max_m, speed_max_m_s;
  std::optional<double> gap_min_m, gap_max_m;

  // Narrows the travel window, once the place of contact is known, to what `travel` and `gap` both
  // allow.
  void place_contact(double contact_travel_m);
  // Shifts the limits to a new zero: `travel_m` becomes 0, and the places in space stay.
  void zero_travel(double travel_m);
};

// Shifts the ends of the machine's travel to a new zero in the same way.
FrameCapabilities with_zero_at(FrameCapabilities caps, double travel_m);

// Errors: invalid_request when a lower limit is not below its upper one.
Result<BoundLimits> bind_limits(const Protocol& protocol, const Environment& env,
                                const FrameCapabilities& caps);

// Limits that the frame watches by itself: those of the protocol, or those of the machine where the
// protocol names none or wider ones.
FrameLimits device_limits(const BoundLimits& limits, const FrameCapabilities& caps);

}  // namespace lcrig
