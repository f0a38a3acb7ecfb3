// SPDX-License-Identifier: Apache-2.0
// Errors of a real bench, drawn for each seed: gain, offset and noise of the meter beyond the white
// one, class and zero of the load cell, diameter of the probe, drift, and how each loading differs
// from the others. A bench file switches them on by `"realistic": true`, the command line by
// `--realistic`, so that a rehearsal can prove the intervals of an analysis wrong. The limits are
// those of the instruments' papers. They are written down here and not taken from analysis/ or
// budget/, which may not include this file.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <random>
#include <vector>

#include "model/plant.hpp"

namespace lcrig {

// Which errors are on. The two smaller sets make the truths that intervals are judged by.
enum class ErrorScope {
  everything,
  lasting,  // no noise, no drift, no difference between loadings: what `ci95` is about
  specimen  // its creep and hysteresis alone: what the expanded uncertainty is about
};

class BenchErrors {
 public:
  // Standard deviations of each loading.
  static constexpr double kSlope = 0.01, kSeating_F = 1e-15;

  // `rig_seed`: draws what lasts from it, so that runs with other seeds are on the same rig.
  explicit BenchErrors(std::uint64_t seed, ErrorScope scope = ErrorScope::everything,
                       std::optional<std::uint64_t> rig_seed = {});

  // Mounts what the plant and the meter themselves can do: gain and offset of the meter, class and
  // zero of the cell, probe, creep. Outside `everything` it takes nearly all noise away.
  void apply(PlantConfig& config) const;
  double clock_ppm() const { return clock_ppm_; }
  // Standard deviation that the 1/f noise adds to a reading, as the differences of neighbours show
  // it.
  static double noise_between_neighbours_F(double interval_s);
  // The values drawn once for the whole run, for code that judges an interval.
  nlohmann::json to_json() const;

  // Capacitance that the meter is shown when the specimen has `capacitance_F`, and `c0_F` without a
  // load. To be called nearly in the order of time; the same for the same seed and calls.
  double shown_F(MonoTime t, double capacitance_F, double c0_F, double force_N);

 private:
  struct Visit {
    double slope = 0, offset_F = 0;
  };
  double background_F(double t_s);
  double loaded_F(double delta_F, double force_N);

  ErrorScope scope_;
  std::mt19937_64 random_;
  double meter_gain_ = 0, meter_offset_ = 0;  // of what the manual allows
  double creep_ = 0;
  double cell_gain_ = 0, cell_zero_N_ = 0, probe_gain_ = 0;
  double clock_ppm_ = 0, drift_F_s_ = 0, hum_F_ = 0, hum_s_ = 1, hysteresis_ = 0;
  std::optional<MonoTime> begin_;
  // 1/f noise by octave, now. It has no begin: each octave starts as it would be after any time.
  std::vector<double> flicker_F_;
  double walk_F_ = 0;  // begins with the run
  std::vector<double> background_;  // F, each kStep_s
  Visit visit_;  // of the present loading
  double highest_N_ = 0;  // of it; 0: nothing touches
};

}  // namespace lcrig
