// SPDX-License-Identifier: Apache-2.0
// Draws the errors of a real bench from a seed: gain, offset and slow noise of the meter, class and
// zero of the load cell, diameter of the probe, drift, and how each loading differs from the
// others. A bench file switches them on by `"realistic": true`, the command line by `--realistic`.
// A rehearsal can thereby prove the intervals of an analysis wrong. The limits are those of the
// instruments' papers. They are written down here and not taken from analysis/ or budget/, which
// may not include this file.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <random>
#include <vector>

#include "base/force_class.hpp"
#include "model/plant.hpp"

namespace lcrig {

// Which errors are on. The two smaller sets define the true values by which intervals are judged.
enum class ErrorScope {
  everything,
  lasting,  // no noise, no drift, no difference between loadings: the truth for `ci95`
  specimen  // only its creep and hysteresis: the truth for the expanded uncertainty
};

class BenchErrors {
 public:
  // Standard deviations of what differs from loading to loading.
  static constexpr double kSlope = 0.01, kSeating_F = 1e-15;

  // `rig_seed`: lasting errors are drawn from it, so that runs with other seeds use the same rig.
  // `cell`: class of the load cell, whose limits the shown force keeps.
  explicit BenchErrors(std::uint64_t seed, ErrorScope scope = ErrorScope::everything,
                       std::optional<std::uint64_t> rig_seed = {},
                       ForceClass cell = kAssumedForceClass);

  // Passes the errors that the plant can produce by itself to it: gain and offset of the meter,
  // class and zero of the cell, probe, creep. Except with `everything`, it removes nearly all
  // noise.
  void apply(PlantConfig& config) const;
  double clock_ppm() const { return clock_ppm_; }
  // The part of a reading's standard deviation that comes from the 1/f noise, as it shows in the
  // differences of neighbouring readings.
  static double noise_between_neighbours_F(double interval_s);
  // The values drawn once for the whole run. Code that judges an interval needs them.
  nlohmann::json to_json() const;

  // Capacitance that the meter is shown when the specimen has `capacitance_F`, and `c0_F` without a
  // load. Call it nearly in the order of time. The same seed and calls give the same values.
  double shown_F(MonoTime t, double capacitance_F, double c0_F, double force_N);

 private:
  struct Visit {
    double slope = 0, offset_F = 0;
  };
  double background_F(double t_s);
  double loaded_F(double delta_F, double force_N);

  ErrorScope scope_;
  std::mt19937_64 random_;
  double meter_gain_ = 0, meter_offset_ = 0;  // relative to what the manual allows
  double creep_ = 0;
  double cell_gain_ = 0, cell_zero_N_ = 0, probe_gain_ = 0;
  double clock_ppm_ = 0, drift_F_s_ = 0, hum_F_ = 0, hum_s_ = 1, hysteresis_ = 0;
  std::optional<MonoTime> begin_;
  // 1/f noise by octave, now. Each octave starts in its stationary state, as if it had always run.
  std::vector<double> flicker_F_;
  double walk_F_ = 0;  // the random walk starts at 0 with the run
  std::vector<double> background_;  // F, one value each kStep_s
  Visit visit_;  // of the present loading
  double highest_N_ = 0;  // of the present loading; 0: nothing touches
};

}  // namespace lcrig
