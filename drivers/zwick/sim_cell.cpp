// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim_cell.hpp"

#include <cmath>

namespace lcrig::frame_link {

namespace {

constexpr int kLooks = 400;  // steps of the search for a crossing when the cell lies

}  // namespace

// The result is the double nearest to its decimal form.
double quantise(double value, double resolution) {
  if (resolution <= 0) return value;
  const double steps = std::round(value / resolution);
  const double per_unit = std::round(1 / resolution);
  const bool decimal = resolution < 1 && std::abs(per_unit * resolution - 1) < 1e-9;
  return decimal ? steps / per_unit : steps * resolution;
}

void SimCell::set_lies(MonoTime t, const ZwickSimLies& lies) {
  if (!lies.force_frozen) frozen_N_.reset();
  if (!lies.force_held) held_N_.reset();
  past_N_ += rate_N_s_ * to_seconds(t - since_);
  since_ = t;
  rate_N_s_ = lies.force_drift_N_s;
  reversed_ = lies.force_reversed;
  gain_ = lies.force_gain;
  scatter_ = lies.force_scatter;
  if (lies.force_held && !held_N_) held_N_ = cell_N(t);
  if (lies.force_frozen && !frozen_N_) frozen_N_ = last_N_ ? *last_N_ : cell_N(t);
}

double SimCell::offset_N(MonoTime t) const {
  const PlantConfig& p = scene_.config();
  const double own = p.force_offset_N + p.force_drift_N_s * to_seconds(t.time_since_epoch());
  return own + past_N_ + rate_N_s_ * to_seconds(t - since_);
}

double SimCell::cell_N(MonoTime t) const {
  if (frozen_N_) return *frozen_N_;
  if (held_N_) return *held_N_;
  const double felt = gain_ * scene_.config().force_gain * scene_.force_N(t);
  return (reversed_ ? -felt : felt) + offset_N(t);
}

std::optional<double> SimCell::convert(MonoTime t, double spike_N) {
  const PlantConfig& p = scene_.config();
  double cell = cell_N(t);
  if (!frozen_N_) cell += spike_N + gauss(p.force_noise_N * scatter_);
  last_N_ = cell;
  if (std::abs(cell) > p.force_nominal_N) return std::nullopt;
  return quantise(cell - tare_N_, p.force_resolution_N);
}

double SimCell::raw_N(MonoTime t, double shown_N) const {
  const double gain = gain_ * scene_.config().force_gain;
  return (shown_N + tare_N_ - offset_N(t)) / (reversed_ ? -gain : gain);
}

// The zero of the cell may drift during the motion, so the first estimate is refined once.
std::optional<MonoTime> SimCell::crossing(double shown_N, MonoTime from, MonoTime to) const {
  if (!is_honest()) return searched(shown_N, from, to);
  auto at = scene_.force_crossing(raw_N(from, shown_N), from, to);
  if (at && scene_.config().force_drift_N_s != 0) {
    const auto later = scene_.force_crossing(raw_N(*at, shown_N), from, to);
    if (later) at = later;
  }
  return at;
}

std::optional<MonoTime> SimCell::searched(double wanted_N, MonoTime from, MonoTime to) const {
  if (is_frozen() || to <= from) return std::nullopt;
  const auto is_above = [&](MonoTime t) { return shown_N(t) >= wanted_N; };
  const bool above = is_above(from);
  MonoTime low = from, high = from;
  for (int i = 1; i <= kLooks && is_above(high) == above; ++i) {
    low = high;
    high = from + (to - from) / kLooks * i;
  }
  if (is_above(high) == above) return std::nullopt;
  while (high - low > Duration(1)) {
    const MonoTime middle = low + (high - low) / 2;
    (is_above(middle) == above ? low : high) = middle;
  }
  return high;
}

// Taring averages about twenty conversions.
void SimCell::tare(MonoTime t) {
  const double cell = cell_N(t);
  tare_N_ = cell - scene_.config().force_tare_error_N;
  if (!frozen_N_) tare_N_ += gauss(scene_.config().force_noise_N * scatter_ / std::sqrt(20.0));
}

}  // namespace lcrig::frame_link
