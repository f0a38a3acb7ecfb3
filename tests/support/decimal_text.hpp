// SPDX-License-Identifier: Apache-2.0
// append_decimal_shift as a value, for comparisons in tests.
#pragma once

#include <string>

#include "base/decimal.hpp"

namespace lcrig {

inline std::string decimal_shift(double value, int power) {
  std::string out;
  append_decimal_shift(out, value, power);
  return out;
}

}  // namespace lcrig
