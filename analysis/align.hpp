// SPDX-License-Identifier: Apache-2.0
// Tells when a reading was measured, and which load the specimen had at that time. The export and
// the analysis both use it, so that they agree.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "analysis/frame_track.hpp"

namespace lcrig {

// Tells how long before its request the measurement of a reading began. With the bus trigger this
// is 0. With the internal trigger the meter converts all the time, and its answer is from a
// conversion that ended before the request.
class WindowBefore {
 public:
  WindowBefore() = default;
  // Takes the settings of the meter (JSON texts) in the order of time. A text that does not name
  // the trigger changes nothing.
  void add(std::int64_t since_mono_ns, std::string_view settings_json);
  std::int64_t at(std::int64_t asked_mono_ns);  // ns; times must not decrease from call to call

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
  // Standard uncertainty of the instant. Its parts: the window and the spacing of the frame's
  // samples around it (both rectangular), and the uncertainty of the frame's clock.
  double uncertainty_s = 0;
};
Result<Aligned> align(FrameTrack& track, std::int64_t before_ns, std::int64_t asked_ns,
                      std::int64_t first_byte_ns);

}  // namespace lcrig
