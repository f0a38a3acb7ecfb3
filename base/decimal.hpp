// SPDX-License-Identifier: Apache-2.0
// Numbers as text with the digits of the stored value, in another power of ten.
#pragma once

#include <cstdint>
#include <string>

namespace lcrig {

// Appends the shortest decimal that reads back as `value`, with its point moved by `power` places:
// 1.84249e-12 and 12 give 1.84249, never 1.8424900000000002. No rounding takes place; the text's
// value is exactly (shortest digits) * 10^power. Plain notation for exponents -6..20, else 1.5e-9.
// Not finite: "inf", "-inf", "nan".
void append_decimal_shift(std::string& out, double value, int power);
// The same for an integer: 1234500000 and -9 give 1.2345.
void append_decimal_shift(std::string& out, std::int64_t value, int power);

// The double nearest to (shortest digits of `value`) * 10^power: 0.065 and -3 give 6.5e-05, which
// 0.065 / 1000 misses. What is not finite stays as it is.
double shift_decimal(double value, int power);

inline std::string decimal_shift(double value, int power) {
  std::string out;
  append_decimal_shift(out, value, power);
  return out;
}

}  // namespace lcrig
