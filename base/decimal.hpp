// SPDX-License-Identifier: Apache-2.0
// Writes a number in another power of ten with exactly the digits of the stored value, e.g. farads
// as picofarads. Used by CSV export, control messages and the frame link.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace lcrig {

// Appends the shortest decimal that reads back as `value`, with its point moved by `power` places.
// 1.84249e-12 and 12 give 1.84249, not 1.8424900000000002. Nothing is rounded: the text is exactly
// (shortest digits) * 10^power. Plain notation for exponents -6..20, otherwise like 1.5e-9. Values
// that are not finite give "inf", "-inf" or "nan".
void append_decimal_shift(std::string& out, double value, int power);
// The same for an integer: 1234500000 and -9 give 1.2345.
void append_decimal_shift(std::string& out, std::int64_t value, int power);

// The double nearest to (shortest digits of `value`) * 10^power. 0.065 and -3 give 6.5e-05; the
// division 0.065 / 1000 gives a neighbouring double. Infinities and NaN are returned unchanged.
double shift_decimal(double value, int power);

// For computed values: the double nearest to `value` rounded to this number of decimal digits.
// 125.50000000000001 and 12 give 125.5. Infinities and NaN are returned unchanged.
double round_to_digits(double value, int digits);

// The powers of ten of the first and the last digit in the shortest decimal that reads back as
// `value`: -2 and -4 for 0.0124. nullopt: zero, or not finite.
struct DecimalPlaces {
  int first = 0, last = 0;
};
std::optional<DecimalPlaces> decimal_places(double value);

// For computed values: rounds `value` to a multiple of 10^place, then moves its point by `power`
// places. 0.12566666666999998 with -5 and 0 gives 0.12567.
void append_rounded(std::string& out, double value, int place, int power);

}  // namespace lcrig
