// SPDX-License-Identifier: Apache-2.0
#include "model/bench_errors.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace lcrig {

namespace {

// Limits between which all values are equally likely.
constexpr double kCellZero_N = 5e-3;  // left by a tare of a cell of class 1; grows with the class
constexpr double kProbe = 2 * 0.02 / 4;  // area of a tip of 4 mm, turned to +-0.02 mm
constexpr double kClock_ppm = 50;
constexpr double kDrift_F_h = 50e-15;
constexpr double kCreep = 0.01;  // share of the load
constexpr double kHysteresis = 0.01;  // share of delta C
constexpr double kHum_F = 0.2e-15;  // beat with the mains; its period is 5 to 10 s
// Standard deviations.
constexpr double kWalk_F = 0.02e-15;  // after a second; grows with the root of time
constexpr double kFlicker_F = 0.1e-15;  // 1/f noise: in each octave of time constants
constexpr int kOctaves = 13;
constexpr double kShortest_s = 0.2;  // shortest time constant
constexpr double kOutlierShare = 0.002, kOutlier_F = 40e-15;

constexpr std::uint64_t kSalt = 0x6c637269676572ULL;
constexpr double kStep_s = 0.1;
constexpr double kTouch_N = 0.01;

}  // namespace

BenchErrors::BenchErrors(std::uint64_t seed, ErrorScope scope,
                         std::optional<std::uint64_t> rig_seed, ForceClass cell)
    : scope_(scope), random_(rig_seed.value_or(seed) ^ kSalt) {
  const auto within = [this](double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random_);
  };
  meter_gain_ = within(1);
  meter_offset_ = within(1);
  cell_gain_ = within(cell.part());
  probe_gain_ = within(kProbe);
  clock_ppm_ = within(kClock_ppm);
  drift_F_s_ = within(kDrift_F_h) / 3600;
  creep_ = std::abs(within(kCreep));
  hysteresis_ = within(kHysteresis);
  hum_F_ = within(kHum_F);
  hum_s_ = 7.5 + within(2.5);
  cell_zero_N_ = within(kCellZero_N * cell.percent());
  if (rig_seed) random_.seed(seed ^ kSalt);
  std::normal_distribution<double> normal;
  for (int k = 0; k < kOctaves; ++k) flicker_F_.push_back(kFlicker_F * normal(random_));
  if (scope_ != ErrorScope::specimen) return;
  meter_gain_ = meter_offset_ = cell_gain_ = cell_zero_N_ = probe_gain_ = clock_ppm_ = 0;
}

// The analysis divides by the area on the drawing. A tip that is larger therefore acts like a cell
// that shows too much force.
void BenchErrors::apply(PlantConfig& config) const {
  config.force_gain *= (1 + cell_gain_) * (1 + probe_gain_);
  config.force_tare_error_N += cell_zero_N_;
  config.creep_fraction += creep_;
  config.meter_gain_error += meter_gain_;
  config.meter_offset_error += meter_offset_;
  if (scope_ == ErrorScope::everything) return;
  // Some noise must stay. Constant values would be taken for a frozen cell and for readings that
  // are not fresh.
  config.force_noise_N = std::min(config.force_noise_N, config.force_resolution_N);
  for (double& noise_F : config.capacitance_noise_F) noise_F /= 10;
}

double BenchErrors::noise_between_neighbours_F(double interval_s) {
  double variance_F2 = 0, time_s = kShortest_s;
  for (int k = 0; k < kOctaves; ++k, time_s *= 2) {
    variance_F2 += kFlicker_F * kFlicker_F * -std::expm1(-interval_s / time_s);
  }
  return std::sqrt(variance_F2);
}

nlohmann::json BenchErrors::to_json() const {
  return {{"meter_gain", meter_gain_},
          {"meter_offset", meter_offset_},
          {"cell_gain", cell_gain_},
          {"cell_zero_mN", cell_zero_N_ * 1e3},
          {"probe_area", probe_gain_},
          {"clock_ppm", clock_ppm_},
          {"drift_fF_per_h", drift_F_s_ * 3600 * 1e15},
          {"creep", creep_},
          {"hysteresis", hysteresis_},
          {"hum_fF", hum_F_ * 1e15}};
}

double BenchErrors::background_F(double t_s) {
  const auto wanted = static_cast<std::size_t>(std::max(0.0, t_s) / kStep_s);
  std::normal_distribution<double> normal;
  while (background_.size() <= wanted) {
    double sum = walk_F_, time_s = kShortest_s;
    walk_F_ += kWalk_F * std::sqrt(kStep_s) * normal(random_);
    for (double& octave : flicker_F_) {
      sum += octave;
      const double keeps = std::exp(-kStep_s / time_s);
      octave = keeps * octave + kFlicker_F * std::sqrt(1 - keeps * keeps) * normal(random_);
      time_s *= 2;
    }
    background_.push_back(sum);
  }
  return background_[wanted] + drift_F_s_ * t_s +
         hum_F_ * std::sin(2 * std::numbers::pi * t_s / hum_s_);
}

double BenchErrors::loaded_F(double delta_F, double force_N) {
  if (force_N < kTouch_N) highest_N_ = 0;
  if (force_N < kTouch_N) return delta_F;
  if (highest_N_ == 0 && scope_ == ErrorScope::everything) {
    std::normal_distribution<double> normal;
    visit_ = {kSlope * normal(random_), kSeating_F * normal(random_)};
  }
  highest_N_ = std::max(highest_N_, force_N);
  const double falling = 1 - force_N / highest_N_;  // 0 while the load grows
  return delta_F * (1 + visit_.slope) * (1 + hysteresis_ * falling) + visit_.offset_F;
}

double BenchErrors::shown_F(MonoTime t, double capacitance_F, double c0_F, double force_N) {
  if (!begin_) begin_ = t;
  double shown = c0_F + loaded_F(capacitance_F - c0_F, force_N);
  if (scope_ != ErrorScope::everything) return shown;
  shown += background_F(to_seconds(t - *begin_));
  if (std::uniform_real_distribution<double>(0, 1)(random_) < kOutlierShare) {
    shown += kOutlier_F * std::normal_distribution<double>()(random_);
  }
  return shown;
}

}  // namespace lcrig
