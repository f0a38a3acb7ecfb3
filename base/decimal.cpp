// SPDX-License-Identifier: Apache-2.0
#include "base/decimal.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace lcrig {

namespace {

// Digits d0 d1 d2 ... mean d0.d1d2... * 10^exponent.
void append_digits(std::string& out, std::string_view digits, int exponent) {
  while (digits.size() > 1 && digits.back() == '0') digits.remove_suffix(1);
  const auto count = static_cast<int>(digits.size());
  if (exponent < -6 || exponent > 20) {
    out += digits.front();
    if (count > 1) out.append(".").append(digits.substr(1));
    char text[8];
    const auto end = std::to_chars(text, text + sizeof text, exponent).ptr;
    out.append("e").append(text, end);
  } else if (exponent < 0) {
    out.append("0.").append(static_cast<std::size_t>(-exponent - 1), '0').append(digits);
  } else if (exponent + 1 >= count) {
    out.append(digits).append(static_cast<std::size_t>(exponent + 1 - count), '0');
  } else {
    const auto whole = static_cast<std::size_t>(exponent + 1);
    out.append(digits.substr(0, whole)).append(".").append(digits.substr(whole));
  }
}

}  // namespace

void append_decimal_shift(std::string& out, double value, int power) {
  if (value == 0) {
    out += '0';
    return;
  }
  char text[40];
  const auto end =
      std::to_chars(text, text + sizeof text, value, std::chars_format::scientific).ptr;
  std::string_view s(text, static_cast<std::size_t>(end - text));
  if (!std::isfinite(value)) {
    out += s;
    return;
  }
  if (s.front() == '-') {
    out += '-';
    s.remove_prefix(1);
  }
  const auto e = s.find('e');
  int exponent = 0;  // to_chars writes e+05, from_chars takes no plus
  const char* from = s.data() + e + (s[e + 1] == '+' ? 2 : 1);
  std::from_chars(from, s.data() + s.size(), exponent);
  char digits[24];
  std::size_t count = 0;
  for (const char c : s.substr(0, e)) {
    if (c != '.') digits[count++] = c;
  }
  append_digits(out, std::string_view(digits, count), exponent + power);
}

void append_decimal_shift(std::string& out, std::int64_t value, int power) {
  if (value == 0) {
    out += '0';
    return;
  }
  char text[24];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  std::string_view s(text, static_cast<std::size_t>(end - text));
  if (s.front() == '-') {
    out += '-';
    s.remove_prefix(1);
  }
  append_digits(out, s, static_cast<int>(s.size()) - 1 + power);
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

}  // namespace lcrig
