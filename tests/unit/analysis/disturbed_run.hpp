// SPDX-License-Identifier: Apache-2.0
// A run of levels with known disturbances. Its times, sizes and curve differ from those that the
// simulated bench draws. Used by tests of the analysis.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "analysis/run_data.hpp"

namespace lcrig {

// What disturbs a run. Sizes in fF.
struct Disturbed {
  double white = 0.5, correlation = 0, walk_sqrt_s = 0;
  double hum = 0, period_s = 6.6, phase = 0.3;
  double creep_per_decade = 0;  // share of what the load adds
  double force_noise_N = 0;  // white noise of the force shown
  std::vector<double> slopes = {1, 1, 1};  // relative slopes of the repeats
};

// A baseline, and three repeats of seven levels with a rest after each.
class DisturbedRun {
 public:
  DisturbedRun(const Disturbed& d, std::uint64_t seed) : d_(d), random_(seed) {
    data.run = 1;
    data.area_m2 = kArea_m2;
    data.probe_diameter_m = 3.568e-3;
    data.function = "Cp-D";
    data.steps = {"s"};
    data.rest_force_N = 0;
    for (int i = 0; i < 90; ++i) read(0, 0, 0);
    data.contact_s = t_s_ - 0.5;
    for (std::size_t repeat = 0; repeat < d.slopes.size(); ++repeat) play(repeat);
    data.duration_s = t_s_;
  }
  RunData data;

 private:
  static constexpr double kArea_m2 = 1e-5;

  void play(std::size_t repeat) {
    repeat_ = static_cast<std::int32_t>(repeat) + 1;
    for (int i = 1; i <= 7; ++i) {
      const double kPa = 12.0 * i;
      for (int k = 0; k < 8; ++k) read(kPa - 12 + 1.5 * (k + 0.5), 0, 0);
      reached_s_ = t_s_;
      LevelRow row;
      row.level = static_cast<std::int32_t>(data.levels.size()) + 1;
      row.repeat = repeat_;
      row.index = i;
      row.target_pressure_Pa = kPa * 1e3;
      row.target_force_N = kPa * 1e3 * kArea_m2;
      row.planned_readings = 24;
      row.begin_s = t_s_;
      data.levels.push_back(row);
      for (int k = 1; k <= 24; ++k) read(kPa, row.level, k);
    }
    for (int k = 0; k < 12; ++k) read(84 - 7 * (k + 0.5), 0, 0);
    for (int k = 0; k < 40; ++k) read(0, 0, 0);
  }

  void read(double kPa, std::int32_t level, std::int32_t index) {
    constexpr double kReading_s = 0.14;
    RunReading r;
    r.t_s = t_s_ + kReading_s / 2;
    t_s_ += kReading_s;
    r.force_N = static_cast<float>(kPa * 1e3 * kArea_m2 + d_.force_noise_N * of_cell_(cell_));
    r.level = level;
    r.index = index;
    r.repeat = repeat_;
    r.present = 1;
    data.frame.push_back({r.t_s, r.force_N, 0, false});
    ++data.frame_samples;
    ++data.fresh_readings;
    double fF = 4000 + 7.5 * kPa * d_.slopes[static_cast<std::size_t>(std::max(1, repeat_) - 1)];
    if (level > 0) {
      const double under_load_s = r.t_s - reached_s_ + 0.2;
      fF += (fF - 4000) * d_.creep_per_decade * std::log10(under_load_s);
    }
    noise_ =
        d_.correlation * noise_ + std::sqrt(1 - d_.correlation * d_.correlation) * normal_(random_);
    walk_ += d_.walk_sqrt_s * std::sqrt(kReading_s) * normal_(random_);
    fF += d_.white * noise_ + walk_;
    fF += d_.hum * std::sin(2 * std::numbers::pi * (r.t_s / d_.period_s + d_.phase));
    r.capacitance_F = fF * 1e-15;
    data.readings.push_back(r);
  }

  Disturbed d_;
  std::mt19937_64 random_, cell_{1};
  std::normal_distribution<double> normal_, of_cell_;
  double t_s_ = 0, reached_s_ = 0, noise_ = 0, walk_ = 0;
  std::int32_t repeat_ = 0;
};

}  // namespace lcrig
