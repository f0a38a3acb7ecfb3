// SPDX-License-Identifier: Apache-2.0
// Compares a frame that comes back (after a lost link, or after a crash of the daemon) with its
// last known state. If it differs, somebody moved the frame or it lost its zero, and nothing may be
// moved any more. Used after a loss and when a run is continued.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "drivers/load_frame.hpp"

namespace lcrig {

struct LastSeen {
  std::optional<double> force_N, travel_m, device_time_s;  // of the last sample
  double speed_m_s = 0;  // magnitude, from the last samples; 0: it stood
  // Speed at which it may have begun to move after the last stored sample: a crash loses what was
  // not stored yet.
  double begun_m_s = 0;
  std::optional<std::string> origin;  // LoadFrame::origin
  bool zeroed = false;  // the run zeroed force or travel, which a restarted machine forgets

  void feed(const FrameSample& sample);
  // Everything except whether the run zeroed the frame.
  void forget() {
    LastSeen next;
    next.zeroed = zeroed;
    *this = std::move(next);
  }
};

// How far a frame may differ after the loss. A moving one goes on until the gateway stops it, after
// 1 s of silence (docs/frame-link.md).
struct FrameTolerance {
  double travel_m = 10e-6;  // for a frame that stood
  double force_N = 0;  // for a frame that stood
  Duration silence = std::chrono::milliseconds(1200);  // until the gateway stops a moving frame
  Acceleration deceleration;
  ForceClass cell = kAssumedForceClass;
  double rest_N = 0, noise_N = 0;  // of the unloaded cell: mean, and scatter of one sample
  // The largest force after a way towards the specimen. Empty: unknown.
  std::function<double(double felt_N, double way_m)> force_after_N;
};

// Errors: refused, saying what differs; then nothing may be moved.
Result<> compare_frame(const LastSeen& before, const LastSeen& now, const FrameTolerance& allowed);

}  // namespace lcrig
