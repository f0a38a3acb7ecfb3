// SPDX-License-Identifier: Apache-2.0
// frame-link/1 counts in millimetres, the program in metres. For the codec alone.
#pragma once

#include <cmath>
#include <optional>

#include "base/decimal.hpp"

namespace lcrig::frame_link {

// Millimetres to a picometre, so that a decimal travel survives the way through metres.
inline double to_mm(double metres) {
  return shift_decimal(std::round(metres * 1e12) / 1e12, 3);
}
inline double from_mm(double mm) {
  return shift_decimal(mm, -3);
}
inline std::optional<double> to_mm(std::optional<double> metres) {
  return metres ? std::optional<double>(to_mm(*metres)) : std::nullopt;
}

}  // namespace lcrig::frame_link
