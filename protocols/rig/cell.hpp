// SPDX-License-Identifier: Apache-2.0
// What a run knows of the load cell: its zero, its noise and its drift.
#pragma once

#include <algorithm>
#include <optional>

#include "protocols/rig/cell_noise.hpp"
#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

struct Cell {
  CellNoise noise;  // everything seen of the cell at rest
  std::optional<RestMeasurement> zero;  // the last one; it follows the drift
  std::optional<RestMeasurement> unloaded;  // the last one that certainly nothing pressed
  // The zero when nothing had been touched: a specimen that sticks may pull at the probe at
  // `unloaded`.
  std::optional<double> untouched_N;
  double drift_N_s = 0;  // known drift, a magnitude
  // Zeros that this run asked for. Their sum is what all together took from the force; under load,
  // since `unloaded`.
  std::optional<double> zeros_N;
  double zeros_under_load_N = 0;
  double hidden_N = 0;  // by which the lower force limit is lowered, because of them
  // How far the unloaded cell shows below zero: that much of the true force is hidden, so the upper
  // limit is lowered by it.
  double below_zero_N = 0;

  double zero_N() const { return zero ? zero->force_N() : 0; }
  double noise_N() const { return zero ? zero->scatter_N() : 0; }
  // The same for what is compared with every sample: of all measurements, and never too small by
  // chance.
  double noise_bound_N() const { return std::max(noise_N(), noise.sure_noise_N()); }
  // The force that the cell shows when certainly nothing presses.
  double unloaded_N() const { return (unloaded ? unloaded->force_N() : 0) - zeros_under_load_N; }
  double unloaded_at_most_N() const {
    return untouched_N ? std::max(unloaded_N(), *untouched_N - zeros_under_load_N) : unloaded_N();
  }
};

}  // namespace lcrig
