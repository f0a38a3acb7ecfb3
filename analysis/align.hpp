// SPDX-License-Identifier: Apache-2.0
// When a reading was measured, and the load at that time: the one place for both, for export and
// analysis alike.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "analysis/frame_track.hpp"

namespace lcrig {

// How long before its request a reading began: nothing with the bus trigger; with the internal
// trigger the meter converts all the time, and an answer is of a conversion that ended before it.
class WindowBefore {
 public:
  WindowBefore() = default;
  // Settings of the meter, JSON texts, in the order of time. A text that says nothing of the
  // trigger leaves things as they were.
  void add(std::int64_t since_mono_ns, std::string_view settings_json);
  std::int64_t at(std::int64_t asked_mono_ns);  // ns; times must not run backwards

 private:
  struct Since {
    std::int64_t mono_ns, conversion_ns;
  };
  std::vector<Since> since_;
  std::size_t next_ = 0;
};

// The load in the middle of the window in which the meter measured.
struct Aligned {
  std::int64_t middle_ns = 0;  // monotonic
  FrameState state;
  // Standard uncertainty of the instant: rectangular over the window and over the spacing of the
  // frame's samples around it, and what the frame's clock leaves.
  double uncertainty_s = 0;
};
Result<Aligned> align(FrameTrack& track, std::int64_t before_ns, std::int64_t asked_ns,
                      std::int64_t first_byte_ns);

}  // namespace lcrig
