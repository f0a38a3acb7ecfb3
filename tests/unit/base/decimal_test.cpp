// SPDX-License-Identifier: Apache-2.0
#include "base/decimal.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

#include "analysis/csv.hpp"

namespace lcrig {
namespace {

TEST(DecimalShift, KeepsTheDigitsThatTheInstrumentSent) {
  EXPECT_EQ(decimal_shift(1.84249e-12, 12), "1.84249");
  EXPECT_EQ(decimal_shift(-10.9371e-12, 12), "-10.9371");
  EXPECT_EQ(decimal_shift(1.005, 3), "1005");
  EXPECT_EQ(decimal_shift(0.0025, 3), "2.5");
  EXPECT_EQ(decimal_shift(79577.47154594767, -3), "79.57747154594767");
  EXPECT_EQ(decimal_shift(1e-15, 12), "0.001");
  EXPECT_EQ(decimal_shift(3e-20, 12), "3e-8");
  EXPECT_EQ(decimal_shift(100, 0), "100");
  EXPECT_EQ(decimal_shift(1e22, 0), "1e22");
  EXPECT_EQ(decimal_shift(0.0, 12), "0");
  EXPECT_EQ(decimal_shift(-0.0, 12), "0");
  EXPECT_EQ(decimal_shift(std::numeric_limits<double>::infinity(), 3), "inf");
}

std::string shifted(std::int64_t value, int power) {
  std::string out;
  append_decimal_shift(out, value, power);
  return out;
}

TEST(DecimalShift, ShiftsIntegersExactly) {
  EXPECT_EQ(shifted(1'234'500'000, -9), "1.2345");
  EXPECT_EQ(shifted(-1, -9), "-1e-9");
  EXPECT_EQ(shifted(0, -9), "0");
  EXPECT_EQ(shifted(60'000'000'000, -9), "60");
  EXPECT_EQ(shifted(std::numeric_limits<std::int64_t>::min(), -9), "-9223372036.854775808");
}

double parse(const std::string& text) {
  double value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  EXPECT_EQ(ec, std::errc()) << text;
  EXPECT_EQ(end, text.data() + text.size()) << text;
  return value;
}

TEST(DecimalShift, ThereAndBackIsTheSameDouble) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200'000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(parse(decimal_shift(value, 0)), value);
  }
}

// The text shifted by +12 and the text shifted by 0 are the same digits: appending e-12 to the
// first must read back as the stored double, exactly.
TEST(DecimalShift, ShiftingOnlyMovesThePoint) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> mantissa(-10, 10);
  std::uniform_int_distribution<int> exponent(-30, 30);
  for (int i = 0; i < 200'000; ++i) {
    const double value = mantissa(random) * std::pow(10, exponent(random));
    for (const int power : {12, 3, -3}) {
      const std::string text = decimal_shift(value, power);
      const auto e = text.find('e');
      const int own = e == std::string::npos ? 0 : std::stoi(text.substr(e + 1));
      EXPECT_EQ(parse(text.substr(0, e) + "e" + std::to_string(own - power)), value) << text;
    }
  }
}

std::string cell(std::string_view text) {
  std::string out;
  append_text_cell(out, text);
  return out;
}

TEST(TextCell, IsQuotedAsRfc4180HasIt) {
  EXPECT_EQ(cell("plain text"), "plain text");
  EXPECT_EQ(cell("a,b"), "\"a,b\"");
  EXPECT_EQ(cell("say \"no\""), "\"say \"\"no\"\"\"");
  EXPECT_EQ(cell("two\r\nlines"), "\"two\r\nlines\"");
  EXPECT_EQ(cell("OUT ,AUX-NG,NG"), "\"OUT ,AUX-NG,NG\"");
  EXPECT_EQ(cell(""), "");
}

TEST(TextCell, IsNeverAFormula) {
  EXPECT_EQ(cell("=1+1"), "'=1+1");
  EXPECT_EQ(cell("@SUM(A1)"), "'@SUM(A1)");
  EXPECT_EQ(cell("-2"), "'-2");
  EXPECT_EQ(cell("+2"), "'+2");
  EXPECT_EQ(cell("=HYPERLINK(\"a\",\"b\")"), "\"'=HYPERLINK(\"\"a\"\",\"\"b\"\")\"");
  EXPECT_EQ(cell("a=b"), "a=b");
}

}  // namespace
}  // namespace lcrig
