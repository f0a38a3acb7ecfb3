// SPDX-License-Identifier: Apache-2.0
// The load cell of the simulated machine (sim_machine.hpp): the force that it shows for the true
// force, with or without lies.
#pragma once

#include <optional>
#include <random>

#include "drivers/zwick/sim.hpp"

namespace lcrig::frame_link {

double quantise(double value, double resolution);  // to a multiple of `resolution`

// Shown values are tared. `scene` and `random` must outlive it. Times must not go backwards.
class SimCell {
 public:
  SimCell(const FrameScene& scene, std::mt19937_64& random) : scene_(scene), random_(random) {}

  void set_lies(MonoTime t, const ZwickSimLies& lies);
  bool is_honest() const {
    return !is_frozen() && !reversed_ && gain_ == 1 && rate_N_s_ == 0 && past_N_ == 0;
  }
  bool is_frozen() const { return frozen_N_ || held_N_ || gain_ == 0; }  // except for noise
  double drift_N_s() const { return rate_N_s_; }  // drift that was injected as a lie

  // One conversion, tared and rounded to digits; nullopt: out of range. `spike_N` acts on the cell,
  // not on the specimen.
  std::optional<double> convert(MonoTime t, double spike_N);
  // Without noise and rounding.
  double shown_N(MonoTime t) const { return cell_N(t) - tare_N_; }
  double unloaded_N(MonoTime t) const { return offset_N(t) - tare_N_; }
  // The true force at which a cell that is not frozen shows `shown_N`.
  double raw_N(MonoTime t, double shown_N) const;
  // When the cell first shows this value, even if the drive disobeys.
  std::optional<MonoTime> crossing(double shown_N, MonoTime from, MonoTime to) const;

  void tare(MonoTime t);
  void forget_tare() { tare_N_ = 0; }

 private:
  double offset_N(MonoTime t) const;
  double cell_N(MonoTime t) const;
  double gauss(double sigma) { return sigma > 0 ? sigma * normal_(random_) : 0.0; }
  std::optional<MonoTime> searched(double shown_N, MonoTime from, MonoTime to) const;

  const FrameScene& scene_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  double tare_N_ = 0;
  std::optional<double> frozen_N_;  // cell value, noise included
  std::optional<double> last_N_;  // cell value of the latest conversion
  std::optional<double> held_N_;  // cell value without noise
  bool reversed_ = false;
  double gain_ = 1;
  double scatter_ = 1;
  double past_N_ = 0, rate_N_s_ = 0;  // drift until `since_`, and the rate after it
  MonoTime since_;
};

}  // namespace lcrig::frame_link
