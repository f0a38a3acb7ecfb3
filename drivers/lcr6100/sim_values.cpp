// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/sim_values.hpp"

#include <cmath>
#include <numbers>

#include "drivers/lcr6100/codec.hpp"
#include "drivers/lcr6100/words.hpp"

namespace lcrig::lcr6100 {

namespace {

constexpr double kMaxResistance = 99.9999e6;  // ohm, the limit of the display
constexpr double kSentOverload = 1e20;

// splitmix64 (public domain, S. Vigna).
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

// In (0, 1].
double unit(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11U) + 1.0) * 0x1p-53;
}

}  // namespace

// Y = w Cp (D + j), Z = 1/Y.
Impedance::Impedance(double parallel_F, double dissipation, double frequency_Hz)
    : cp_(parallel_F), d_(dissipation), omega_(2 * std::numbers::pi * frequency_Hz) {
  const double b = omega_ * cp_;
  const double y2 = b * b * (1 + d_ * d_);
  r_ = b * d_ / y2;
  x_ = -b / y2;
  z2_ = 1 / y2;
}

double Impedance::value(std::string_view word) const {
  const auto is = [word](std::string_view w) { return same_word(word, w); };
  if (is("Cp")) return cp_;
  if (is("D")) return d_;
  if (is("Q")) return 1 / d_;
  if (is("Cs")) return cp_ * (1 + d_ * d_);
  if (is("Rs") || is("R")) return r_;
  if (is("Rp")) return z2_ / r_;
  if (is("X")) return x_;
  if (is("Z")) return std::sqrt(z2_);
  if (is("thr")) return std::atan2(x_, r_);
  if (is("thd")) return std::atan2(x_, r_) * 180 / std::numbers::pi;
  if (is("Ls")) return x_ / omega_;
  if (is("Lp")) return z2_ / x_ / omega_;
  if (is("G")) return r_ / z2_;
  if (is("B")) return -x_ / z2_;
  if (is("Y")) return 1 / std::sqrt(z2_);
  if (is("DCR")) return kSentOverload;  // a capacitor does not conduct
  return 0;  // deviations (ABS, PER) without a nominal value
}

BasicAccuracy basic_accuracy(bool fast, double frequency_Hz, double level_V) {
  // Ar is 1 from 0.4 V on; below it goes through 1 at 1 V, 1.5 at 0.3 V and 2.5 at 0.1 V.
  const double ar = level_V >= 0.4   ? 1.0
                    : level_V >= 0.3 ? std::lerp(1.5, 1.0, (level_V - 0.3) / 0.7)
                                     : std::lerp(2.5, 1.5, (level_V - 0.1) / 0.2);
  const double low = frequency_Hz < 100 ? 1 + std::sqrt(100 / frequency_Hz) : 1;
  // Kb is a fraction of the reading and grows with Z = 1/(w C). As a capacitance it is therefore
  // the same for all values.
  const double per_ohm = fast ? 2e-9 * (1 + 0.1 / level_V) : 1e-9 * (1 + 0.07 / level_V);
  return {(fast ? 1e-3 : 5e-4) * ar, per_ohm * low / (2 * std::numbers::pi * frequency_Hz)};
}

std::pair<double, double> noise_pair(std::uint64_t seed, std::uint64_t epoch, std::int64_t index) {
  const std::uint64_t key = mix(mix(seed) ^ mix(epoch) ^ static_cast<std::uint64_t>(index));
  const double radius = std::sqrt(-2 * std::log(unit(mix(key))));
  const double angle = 2 * std::numbers::pi * unit(mix(key ^ 0x5851f42d4c957f2dU));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

void append_value(std::string& line, std::string_view word, double value) {
  const char first = word.empty() ? ' ' : word.front();
  const bool resistance = first == 'R' || first == 'r' || first == 'X' || first == 'x' ||
                          first == 'Z' || first == 'z' || same_word(word, "DCR");
  if (!std::isfinite(value) || (resistance && std::abs(value) > kMaxResistance)) {
    value = kSentOverload;
  }
  line += format_number(value);
}

}  // namespace lcrig::lcr6100
