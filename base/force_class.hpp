// SPDX-License-Identifier: Apache-2.0
// The accuracy class of a load cell by ISO 7500-1, and the errors of the shown force that it
// allows. Plan, watch, analysis and the simulated cell get them from here.
#pragma once

#include <array>
#include <cmath>

namespace lcrig {

inline constexpr std::array<double, 4> kForceClasses{0.5, 1, 2, 3};
inline constexpr const char* kForceClassWords = "0.5, 1, 2 or 3 (ISO 7500-1)";

constexpr bool is_force_class(double percent) {
  for (const double known : kForceClasses) {
    if (percent == known) return true;
  }
  return false;
}

class ForceClass {
 public:
  // Precondition: is_force_class(percent).
  explicit constexpr ForceClass(double percent) : percent_(percent) {}
  constexpr double percent() const { return percent_; }
  constexpr double part() const { return percent_ / 100; }  // limit of error, of the reading
  double error_N(double shown_N) const { return part() * std::abs(shown_N); }
  // Limit of the error of zero: a tenth of the class, of the cell's nominal force.
  constexpr double zero_error_N(double nominal_N) const { return part() / 10 * nominal_N; }
  constexpr bool operator==(const ForceClass&) const = default;

 private:
  double percent_;
};

// Taken where nobody states the class. A plan prints that it was assumed.
inline constexpr ForceClass kAssumedForceClass{1};

}  // namespace lcrig
