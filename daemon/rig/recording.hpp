// SPDX-License-Identifier: Apache-2.0
// Reads a recording of both instruments, which is played back through the wires of the simulated
// instruments. Used by the benches `replay:DIR` (docs/bench-file.md, "A recording as a bench").
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

// Times are seconds on one axis for both instruments; 0 is where playing starts.
struct RecordedReading {
  double t_s = 0;
  double primary = 0, secondary = 0;  // as the meter sends them: 1e20 is an overload
};
struct RecordedSample {
  double t_s = 0, travel_m = 0, force_N = 0;
};

struct Recording {
  std::vector<RecordedReading> readings;
  std::vector<RecordedSample> samples;
  // What the time of a reading means: the middle of the window in which the meter measured it, or
  // (false) its arrival, which is the end of that window.
  bool of_middle = false;
  double zero_s = 0;  // what the files call the time 0
  std::string words;  // what is played, what is not, and what the times mean
  std::size_t not_played = 0;  // rows of one file where the other one has none
  double duration_s() const;
};

// `directory` holds lcr.csv (t_s or t_middle_s, Cp_F, Rp_ohm) and frame.csv (t_s, travel_mm,
// force_N); other columns are ignored. Both count their times from one zero, which may be anything.
// Rows of one file where the other one has none cannot be paired; they are left out, and `words`
// says so. Errors name file and line, what was expected, and what to do.
Result<Recording> load_recording(const std::string& directory);

}  // namespace lcrig
