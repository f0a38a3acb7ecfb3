// SPDX-License-Identifier: Apache-2.0
#include "base/decimal.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

namespace lcrig {

namespace {

constexpr std::size_t kLongest = 48;  // sign, 17 digits, point, and zeros or exponent

char* copy(char* to, const char* from, std::size_t count) {
  std::memcpy(to, from, count);
  return to + count;
}

// Digits d0 d1 d2 ... mean d0.d1d2... * 10^exponent. Returns the end of the text.
char* write_digits(char* to, const char* digits, int count, int exponent) {
  while (count > 1 && digits[count - 1] == '0') --count;
  const auto n = static_cast<std::size_t>(count);
  if (exponent < -6 || exponent > 20) {
    *to++ = digits[0];
    if (count > 1) *to++ = '.';
    to = copy(to, digits + 1, n - 1);
    *to++ = 'e';
    return std::to_chars(to, to + 8, exponent).ptr;
  }
  if (exponent < 0) {
    to = copy(to, "0.00000", static_cast<std::size_t>(1 - exponent));
    return copy(to, digits, n);
  }
  if (exponent + 1 >= count) {
    to = copy(to, digits, n);
    const auto zeros = static_cast<std::size_t>(exponent + 1 - count);
    std::memset(to, '0', zeros);
    return to + zeros;
  }
  const auto whole = static_cast<std::size_t>(exponent + 1);
  to = copy(to, digits, whole);
  *to++ = '.';
  return copy(to, digits + whole, n - whole);
}

}  // namespace

void append_decimal_shift(std::string& out, double value, int power) {
  if (value == 0) {
    out += '0';
    return;
  }
  char text[40];
  char* end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific).ptr;
  if (!std::isfinite(value)) {
    out.append(text, end);
    return;
  }
  char number[kLongest];
  char* to = number;
  char* digits = text;
  if (*digits == '-') *to++ = *digits++;
  // The shortest scientific form is d.ddde-07: the 'e' stands four or five characters before the
  // end.
  char* mark = end - (end[-4] == 'e' ? 4 : 5);
  int exponent = 0;
  for (const char* c = mark + 2; c != end; ++c) exponent = exponent * 10 + (*c - '0');
  if (mark[1] == '-') exponent = -exponent;
  auto count = static_cast<int>(mark - digits);
  if (count > 1) {  // the first digit takes the place of the point
    digits[1] = digits[0];
    ++digits;
    --count;
  }
  out.append(number, write_digits(to, digits, count, exponent + power));
}

void append_decimal_shift(std::string& out, std::int64_t value, int power) {
  if (value == 0) {
    out += '0';
    return;
  }
  char text[24];
  const char* end = std::to_chars(text, text + sizeof text, value).ptr;
  char number[kLongest];
  char* to = number;
  const char* digits = text;
  if (*digits == '-') *to++ = *digits++;
  const auto count = static_cast<int>(end - digits);
  out.append(number, write_digits(to, digits, count, count - 1 + power));
}

double shift_decimal(double value, int power) {
  if (value == 0 || !std::isfinite(value)) return value;
  char text[48];
  const auto form = std::chars_format::scientific;
  char* end = std::to_chars(text, text + 40, value, form).ptr;
  char* mark = std::find(text, end, 'e');
  int exponent = 0;
  std::from_chars(mark + (mark[1] == '+' ? 2 : 1), end, exponent);
  end = std::to_chars(mark + 1, text + sizeof text, exponent + power).ptr;
  double out = value;
  std::from_chars(text, end, out);
  return out;
}

double round_to_digits(double value, int digits) {
  char text[48];
  const auto end =
      std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, digits - 1).ptr;
  double out = value;
  std::from_chars(text, end, out);
  return out;
}

std::optional<DecimalPlaces> decimal_places(double value) {
  if (value == 0 || !std::isfinite(value)) return std::nullopt;
  char text[40];
  const char* const begin = text;
  const char* const end =
      std::to_chars(text, text + sizeof text, value, std::chars_format::scientific).ptr;
  const char* const mark = std::find(begin, end, 'e');
  DecimalPlaces out;
  std::from_chars(mark + (mark[1] == '+' ? 2 : 1), end, out.first);
  const auto fraction = mark - std::find(begin, mark, '.');  // including the point
  out.last = out.first - static_cast<int>(std::max<std::ptrdiff_t>(fraction - 1, 0));
  return out;
}

void append_rounded(std::string& out, double value, int place, int power) {
  constexpr double kExact = 9007199254740992;  // 2^53; a larger double has no digit at that place
  const double steps = value * std::pow(10.0, -place);
  if (!(std::abs(steps) < kExact)) return append_decimal_shift(out, value, power);
  append_decimal_shift(out, std::int64_t{std::llround(steps)}, place + power);
}

}  // namespace lcrig
