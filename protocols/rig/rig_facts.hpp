// SPDX-License-Identifier: Apache-2.0
// What is known of a rig before a run, stored with it (event `watch_setup`).
#pragma once

#include <algorithm>

#include "drivers/load_frame.hpp"
#include "protocols/rig/constants.hpp"
#include "protocols/rig/limits.hpp"

namespace lcrig {

struct RigFacts {
  bool commands = true;  // false: the frame is only observed
  BoundLimits limits;  // of the protocol
  double rate_Hz = 0;  // of the samples
  ForceClass cell = kAssumedForceClass;
  FrameCapabilities frame;
};

// A moving frame is stopped when samples are missing for three periods, but at least for two
// batches of the link (100 ms each) with their jitter.
inline Duration stale_after(double rate_Hz) {
  return std::max<Duration>(from_seconds(kSilentPeriods / rate_Hz), kSilent_s.duration());
}

// How long samples from before a zero may still arrive.
inline Duration old_samples(double rate_Hz) {
  return std::max<Duration>(kOldSamples_s.duration(), from_seconds(kNewSamples / rate_Hz));
}

}  // namespace lcrig
