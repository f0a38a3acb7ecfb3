// SPDX-License-Identifier: Apache-2.0
// The limits of a protocol as numbers: for the plan, for the guard and for the frame itself.
#pragma once

#include <optional>

#include "drivers/load_frame.hpp"
#include "protocols/protocol.hpp"

namespace lcrig {

// Limits are inclusive: more than rounding beyond it.
bool exceeds(double v, double max);

// The least force at which a device can be told to stop. Below it a stop would follow the noise
// and the zero of its cell. `noise_N`: standard deviation of a sample.
double least_trip_N(const FrameCapabilities& caps, double noise_N);

// The limits with their parameters bound; SI. Travel and gap have both ends or none.
struct BoundLimits {
  double force_min_N = 0, force_max_N = 0;  // the cell's where the protocol says nothing
  std::optional<double> travel_min_m, travel_max_m, speed_max_m_s;
  std::optional<double> gap_min_m, gap_max_m;

  // The travel window once it is known where contact is: what `travel` and `gap` both allow.
  void place_contact(double contact_travel_m);
  // A new zero of travel: what was this value is 0 from now on, and the places stay.
  void zero_travel(double travel_m);
};

// The machine's ends after a new zero of travel, likewise.
FrameCapabilities with_zero_at(FrameCapabilities caps, double travel_m);

// Errors: invalid_request when a lower limit is not the lower one.
Result<BoundLimits> bind_limits(const Protocol& protocol, const Environment& env,
                                const FrameCapabilities& caps);

// Limits that the frame watches by itself: those of the protocol, and where it names none, those of
// the machine; never more than that.
FrameLimits device_limits(const BoundLimits& limits, const FrameCapabilities& caps);

}  // namespace lcrig
