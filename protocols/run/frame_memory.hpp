// SPDX-License-Identifier: Apache-2.0
// Whether a frame that comes back (after a lost link, or after a crash of the daemon) is where it
// was. If not, somebody moved it or it forgot its zero, and nothing may be moved any more.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

struct FrameMemory {
  std::optional<double> force_N, travel_m, device_time_s;  // of the last sample
  double speed_m_s = 0;  // of the last samples, a magnitude; 0: it stood
  // After the last sample it may have begun to move, as fast as this: a crash takes along what was
  // not stored yet.
  double begun_m_s = 0;
  std::optional<std::string> origin;  // LoadFrame::origin
  bool zeroed = false;  // the run zeroed force or travel: a restarted machine forgets that

  void feed(std::span<const FrameSample> samples);
};

// How far a frame may go on by itself: the gateway stops after 1 s of silence (docs/frame-link.md).
struct FrameTolerance {
  double travel_m = 10e-6;  // of a frame that stood
  double force_N = 0;  // of a frame that stood
  Duration silence = std::chrono::milliseconds(1200);  // until the gateway stops a moving one
  Acceleration deceleration;
  double rest_N = 0, noise_N = 0;  // of the unloaded cell: mean, and scatter of a sample
  // Largest force that is felt after a way towards the specimen. Empty: nobody knows.
  std::function<double(double felt_N, double way_m)> force_after_N;
};

// Errors: refused, with what differs; nothing may be moved then.
Result<> compare_frame(const FrameMemory& before, const FrameMemory& now,
                       const FrameTolerance& allowed);

}  // namespace lcrig
