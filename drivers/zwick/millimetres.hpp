// SPDX-License-Identifier: Apache-2.0
// Converts between the millimetres of frame-link/1 and the program's metres. Used by the codec
// only.
#pragma once

#include <cmath>
#include <optional>

#include "base/decimal.hpp"

namespace lcrig::frame_link {

// Rounds to a picometre, so that a decimal travel survives the conversion to metres and back.
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
