// SPDX-License-Identifier: Apache-2.0
// The load cell of the simulated machine: what it shows of the true force, honestly or not.
#pragma once

#include <optional>
#include <random>

#include "drivers/zwick/sim.hpp"

namespace lcrig::frame_link {

double quantise(double value, double resolution);  // to a multiple of it

// Shown values are tared. Scene and random numbers must outlive it; times never run backwards.
class SimCell {
 public:
  SimCell(const FrameScene& scene, std::mt19937_64& random) : scene_(scene), random_(random) {}

  void set_lies(MonoTime t, const ZwickSimLies& lies);
  bool is_honest() const {
    return !is_frozen() && !reversed_ && gain_ == 1 && rate_N_s_ == 0 && past_N_ == 0;
  }
  bool is_frozen() const { return frozen_N_ || held_N_ || gain_ == 0; }  // but for its noise
  double drift_N_s() const { return rate_N_s_; }  // of a cell that lies

  // One conversion, tared and in digits; nullopt: beyond the range. `spike_N` is on the cell, not
  // on the specimen.
  std::optional<double> convert(MonoTime t, double spike_N);
  // Free of noise and digits.
  double shown_N(MonoTime t) const;
  double unloaded_N(MonoTime t) const { return offset_N(t) - tare_N_; }
  // The true force at which a cell that still converts shows this one.
  double raw_N(MonoTime t, double shown_N) const;
  // When it first passes this value; whatever the drive does.
  std::optional<MonoTime> crossing(double shown_N, MonoTime from, MonoTime to) const;

  void tare(MonoTime t);
  void forget_tare() { tare_N_ = 0; }

 private:
  double offset_N(MonoTime t) const;
  double cell_N(MonoTime t) const;
  double gauss(double sigma);
  std::optional<MonoTime> searched(double shown_N, MonoTime from, MonoTime to) const;

  const FrameScene& scene_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  double tare_N_ = 0;
  std::optional<double> frozen_N_;  // the cell, noise included
  std::optional<double> last_N_;  // of the latest conversion
  std::optional<double> held_N_;  // the cell, without noise
  bool reversed_ = false;
  double gain_ = 1;
  double scatter_ = 1;
  double past_N_ = 0, rate_N_s_ = 0;  // drift until and since
  MonoTime since_;
};

}  // namespace lcrig::frame_link
