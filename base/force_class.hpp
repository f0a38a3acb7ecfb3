// SPDX-License-Identifier: Apache-2.0
// The accuracy classes of a load cell by ISO 7500-1, each as its error limit in percent of the
// reading. Used by the daemon's config file and the command line.
#pragma once

#include <array>

namespace lcrig {

inline constexpr std::array<double, 4> kForceClasses{0.5, 1, 2, 3};
inline constexpr const char* kForceClassWords = "0.5, 1, 2 or 3 (ISO 7500-1)";

constexpr bool is_force_class(double percent) {
  for (const double known : kForceClasses) {
    if (percent == known) return true;
  }
  return false;
}

}  // namespace lcrig
