// SPDX-License-Identifier: Apache-2.0
// What was seen of the noise of a load cell, over all rest measurements of a run. The tolerances of
// the watch and the noise in a plan come from it.
#pragma once

#include <cstdint>
#include <optional>

namespace lcrig {

class RestMeasurement;

// The scatter of the force of an unloaded cell, sample by sample.
class CellNoise {
 public:
  CellNoise() = default;
  explicit CellNoise(const RestMeasurement& rest);
  // Adds another look at the same cell. A run of equal forces counts as normal only if it is far
  // shorter than `frozen`.
  void add(const RestMeasurement& rest, std::optional<std::int64_t> frozen);
  double noise_N = 0;  // standard deviation
  // From all looks together, and at least that of the last one, so much larger that chance does not
  // reach kSampleSigmas of it. Noise below half a digit may show as nothing, so it is never less
  // than that. 0: nothing was seen.
  double sure_noise_N() const;
  // The most that sure_noise_N of another look at the same cell, with as many samples, will be.
  double sure_noise_anew_N() const;
  double digit_N = 0;  // smallest difference of two samples
  std::int64_t longest_run = 1;  // of consecutive equal forces
  bool alive = false;
  // Standard deviation at the first look. Later looks are not used, because the frame may creep
  // then.
  std::optional<double> travel_noise_m;

 private:
  double squares_N2_ = 0, freedoms_ = 0;  // of all looks
  double last_N_ = 0;
};

}  // namespace lcrig
