// SPDX-License-Identifier: Apache-2.0
// Reads a recording of both instruments, which is played back through the wires of the simulated
// instruments. Used by the benches `replay:DIR`.
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

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
  double duration_s() const;
};

// `directory` holds lcr.csv (t_s, Cp_F, Rp_ohm) and frame.csv (t_s, travel_mm, force_N); other
// columns are ignored. Times must not decrease. Errors name file, line and column.
Result<Recording> load_recording(const std::string& directory);

}  // namespace lcrig
