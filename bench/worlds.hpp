// SPDX-License-Identifier: Apache-2.0
// Makes runs whose truth is known, for coverage_worlds_bench and its test. It takes the times and
// forces of a synthetic or recorded run and computes capacitances under one kind of disturbance or
// under all at once. The limits from which errors are drawn are written down here and are not taken
// from analysis/.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig::worlds {

// The specimen: C = C0 + curve(pressure).
struct TrueSpecimen {
  double c0_fF = 3650;
  std::function<double(double kPa)> delta_fF;
};
TrueSpecimen straight_and_bent();  // 9 fF/kPa at first, 5 fF/kPa at the end

struct StaticShape {
  int repeats = 4, levels = 10, readings = 30, baseline = 100;
  double rest_s = 5, settle_s = 1, reading_s = 0.12;
};
// Levels from 10 to 100 kPa in equal steps, with unloading and rest after each repeat. The
// capacitances are 0 at first.
RunData static_run(const StaticShape& shape);

struct DynamicShape {
  int cycles = 5;
  double peak_N = 1, branch_s = 4, rest_s = 5, baseline_s = 20, reading_s = 0.065;
};
RunData dynamic_run(const DynamicShape& shape);

// The disturbances of a world, as standard deviations and limits. By default only the white noise
// of meter and force is on.
struct World {
  std::string name;
  double noise_fF = 0.44;  // white, of one reading
  double ar1 = 0;  // correlation of neighbouring readings in the noise
  double force_noise_N = 0.0005;  // of a sample of the frame
  double noise_per_kPa = 0;  // noise grows by this share per kPa
  double slope_sd = 0;  // relative; drawn for each repeat or cycle
  double offset_sd_fF = 0;  // drawn for each repeat; acts under load
  double walk_fF_sqrt_s = 0;  // random walk
  double flicker_fF = 0;  // 1/f noise: in each octave of time constants from 0.2 to 1600 s
  double drift_fF_h = 0;
  double hum_fF = 0;  // amplitude of a beat with the mains; its period is 5 to 10 s
  double shared_sd_fF = 0;  // of a level; the same in all repeats
  double outlier_share = 0, outlier_fF = 40;
  double gain_limit = 0, force_limit = 0, diameter_limit_mm = 0;  // uniform within +- the limit
  double offset_limit_fF = 0;  // of the meter
  double force_zero_limit_N = 0;
  double creep_per_decade = 0;  // of delta C, relative to its value after 1 s under load
  double hysteresis = 0;  // gap between unloading and loading in the middle, over the span
};

// Errors that are drawn once for each run and that the readings alone cannot reveal.
struct Truth {
  double gain = 0, force = 0, diameter_mm = 0, offset_fF = 0;
  std::vector<double> shared_fF;  // by level index, from 1
};
struct MadeRun {
  RunData data;
  Truth truth;
};
MadeRun rewrite(const RunData& shape, const TrueSpecimen& specimen, const World& world,
                std::uint64_t seed);

// A result with its two intervals and two true values: what this rig would show without noise,
// drift and differences between repeats, and the specimen's own value.
struct Judged {
  std::string result;
  Estimate estimate;
  std::optional<double> expanded;
  double of_rig = 0, own = 0;
};
std::vector<Judged> judge(const MadeRun& run, const TrueSpecimen& specimen, const World& world,
                          const AnalysisOptions& options = {});

// The worlds of the table in docs/analysis.md. The dynamic ones are for cycles.
std::vector<World> static_worlds();
std::vector<World> dynamic_worlds();
// Slow noise of many sizes, to check that no estimator was tuned to one of them.
std::vector<World> slow_worlds();
// All disturbances together, with the limits of the instruments' specifications.
World realistic_world();

}  // namespace lcrig::worlds
