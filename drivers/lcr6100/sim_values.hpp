// SPDX-License-Identifier: Apache-2.0
// Computes the values that the simulated meter shows for a capacitance: all functions of its menu,
// and noise. Used by sim.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace lcrig::lcr6100 {

// SI values of all functions at one frequency, from parallel capacitance and dissipation.
class Impedance {
 public:
  Impedance(double parallel_F, double dissipation, double frequency_Hz);
  // The value for one word of a function name or a monitor: "Cp", "D", "Rs", "thd", ... (case
  // ignored).
  double value(std::string_view word) const;

 private:
  double cp_, d_, omega_, r_, x_, z2_;
};

// The error that the manual allows for a capacitance of more than 500 ohm, at 18 to 28 degrees,
// without a cable, with the correction measured at the same frequency: A Ar on every value alike,
// and Kb for what remains of the open circuit after its correction (LCR reference 4.1 and 4.2).
struct BasicAccuracy {
  double gain = 0, offset_F = 0;  // limits, +-
};
BasicAccuracy basic_accuracy(bool fast, double frequency_Hz, double level_V);

// Two independent standard normal numbers. A pure function of its arguments, so that a conversion
// has the same noise whether or not anybody reads it.
std::pair<double, double> noise_pair(std::uint64_t seed, std::uint64_t epoch, std::int64_t index);

// Appends one number of a reading as the meter displays it. A resistance above 99.9999 Mohm is an
// overload.
void append_value(std::string& line, std::string_view word, double value);

}  // namespace lcrig::lcr6100
