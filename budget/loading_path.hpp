// SPDX-License-Identifier: Apache-2.0
// Computes the pressures at which the readings of a loading at constant speed will be taken.
// Private to budget/.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "budget/prediction.hpp"

namespace lcrig {

// Where the last reading before a peak falls is chance. Predictions are averaged over these parts
// of the interval between readings.
inline constexpr double kPhases[] = {0.1, 0.3, 0.5, 0.7, 0.9};

// The pressure at the readings' instants, in a loading from contact to peak or in an unloading.
class LoadingPath {
 public:
  LoadingPath(const PlannedRun& run, double peak_kPa, double seconds)
      : run_(run),
        peak_kPa_(peak_kPa),
        seconds_(seconds),
        peak_N_(peak_kPa * 1e3 * run.area_m2),
        way_m_(run.compression_m(peak_N_)) {}
  // Pressures of the readings of a branch. The first of them is `nearest_s` away from the peak.
  std::vector<double> kPa(double nearest_s) const {
    std::vector<double> out;
    for (double t = nearest_s; t <= seconds_; t += run_.interval_s) {
      out.push_back(at(1 - t / seconds_));
    }
    return out;
  }
  // How far the pressure `seconds` before the peak is below that at the peak.
  double short_of_peak_kPa(double seconds) const { return peak_kPa_ - at(1 - seconds / seconds_); }
  // Rate of pressure `seconds` before the peak.
  double rate_kPa_s(double seconds) const {
    const double h = 1e-3 * seconds_;
    const double before = std::min(seconds + h, seconds_), after = std::max(seconds - h, 0.0);
    return (at(1 - after / seconds_) - at(1 - before / seconds_)) / (before - after);
  }
  // Time between the peak and the nearest reading that a slope uses. The window of that reading,
  // together with the error of a sample's instant, must not reach over the peak.
  double first_s(double phase) const {
    const double t = phase * run_.interval_s;
    const double window_s = std::hypot(run_.meter.conversion_s.value_or(0), run_.sample_s);
    return 2 * t < window_s ? t + run_.interval_s : t;
  }

 private:
  // Pressure after this part of the travel, over which the drive moves at constant speed.
  double at(double part) const;
  const PlannedRun& run_;
  double peak_kPa_, seconds_, peak_N_, way_m_;
};

// Most cycles of a protocol are alike; then the result for one of them is used again.
inline bool same_loading(const PlannedCycle& a, const PlannedCycle& b) {
  return a.peak_kPa == b.peak_kPa && a.loading_s == b.loading_s && a.falling_s == b.falling_s &&
         a.rising == b.rising;
}

}  // namespace lcrig
