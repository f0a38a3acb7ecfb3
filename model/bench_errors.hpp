// SPDX-License-Identifier: Apache-2.0
// What a real bench errs by, drawn for each seed: gain, offset and noise of the meter beyond the
// white one, class of the load cell, diameter of the probe, drift, and how each loading differs
// from the others. On by `"realistic": true` in a bench file, so that a rehearsal can prove the
// intervals of an analysis wrong. The limits are those of the instruments' papers, written down
// here and not taken from analysis/ or budget/.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "model/plant.hpp"

namespace lcrig {

class BenchErrors {
 public:
  explicit BenchErrors(std::uint64_t seed);

  // Mounts what the plant itself can do: class of the cell, probe, creep.
  void apply(PlantConfig& config) const;
  double clock_ppm() const { return clock_ppm_; }

  // What the meter answers to where the specimen has `capacitance_F`, `c0_F` without a load.
  // Nearly in the order of time; the same for the same seed and calls.
  double shown_F(MonoTime t, double capacitance_F, double c0_F, double force_N);

 private:
  struct Visit {
    double slope = 0, offset_F = 0;
  };
  double background_F(double t_s);
  double loaded_F(double delta_F, double force_N);

  std::mt19937_64 random_;
  double meter_gain_ = 0, meter_offset_F_ = 0, cell_gain_ = 0, probe_gain_ = 0, creep_ = 0;
  double clock_ppm_ = 0, drift_F_s_ = 0, hum_F_ = 0, hum_s_ = 1, hysteresis_ = 0;
  std::optional<MonoTime> begin_;
  std::vector<double> flicker_F_;  // of each octave, now
  double walk_F_ = 0;
  std::vector<double> background_;  // F, each kStep_s
  Visit visit_;  // of the present loading
  double highest_N_ = 0;  // of it; 0: nothing touches
};

}  // namespace lcrig
