// SPDX-License-Identifier: Apache-2.0
// What the simulated meter computes from a capacitance: every function of its menu, and its noise.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace lcrig::lcr6100 {

// SI values of all functions at one frequency, from the parallel capacitance and the dissipation.
class Impedance {
 public:
  Impedance(double parallel_F, double dissipation, double frequency_Hz);
  // Value of one word of a function name or a monitor: "Cp", "D", "Rs", "thd", ... (case ignored).
  double value(std::string_view word) const;

 private:
  double cp_, d_, omega_, r_, x_, z2_;
};

// Two independent standard normal numbers, a pure function of its arguments: a conversion has its
// noise whether or not anybody asks for it.
std::pair<double, double> noise_pair(std::uint64_t seed, std::uint64_t epoch, std::int64_t index);

// One number of a reading, as the meter shows it: a resistance beyond 99.9999 Mohm is an overload.
void append_value(std::string& line, std::string_view word, double value);

}  // namespace lcrig::lcr6100
