// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/cell_noise.hpp"

#include <algorithm>
#include <cmath>

#include "protocols/rig/constants.hpp"
#include "protocols/rig/rest_measurement.hpp"

namespace lcrig {

CellNoise::CellNoise(const RestMeasurement& rest)
    : noise_N(rest.scatter_N()),
      digit_N(rest.digit_N()),
      longest_run(rest.longest_run()),
      alive(rest.is_alive()),
      travel_noise_m(rest.travel_scatter_m()),
      freedoms_(static_cast<double>(std::max<std::int64_t>(0, rest.forces() - 1))),
      last_N_(rest.scatter_N()) {
  squares_N2_ = freedoms_ * noise_N * noise_N;
}

double CellNoise::sure_noise_N() const {
  if (!(freedoms_ > 0)) return 0;
  const double scatter_N = sure_scatter_N(std::sqrt(squares_N2_ / freedoms_), freedoms_);
  return std::max({last_N_, scatter_N, kHidden * digit_N});
}

double CellNoise::sure_noise_anew_N() const {
  return std::max(scatter_anew(freedoms_) * sure_noise_N(), kHiddenAgain * digit_N);
}

void CellNoise::add(const RestMeasurement& rest, std::optional<std::int64_t> frozen) {
  const CellNoise now(rest);
  noise_N = std::max(now.noise_N, kNoiseKnown * noise_N);
  if (digit_N == 0 || (now.digit_N > 0 && now.digit_N < digit_N)) digit_N = now.digit_N;
  // A series of equal samples that is already long may mean that the cell is about to freeze. It
  // must not pass for a habit of the gateway.
  const bool habit = !alive || !frozen || now.longest_run <= *frozen / kFrozenMargin.count();
  if (habit) longest_run = std::max(longest_run, now.longest_run);
  alive = alive || now.alive;
  squares_N2_ += now.squares_N2_;
  freedoms_ += now.freedoms_;
  last_N_ = now.last_N_;
  if (!travel_noise_m) travel_noise_m = now.travel_noise_m;
}

}  // namespace lcrig
