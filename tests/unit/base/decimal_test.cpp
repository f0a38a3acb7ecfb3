// SPDX-License-Identifier: Apache-2.0
#include "base/decimal.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/decimal_text.hpp"

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

TEST(RoundToDigits, IsTheNearestDoubleOfTheRoundedDecimal) {
  EXPECT_EQ(round_to_digits(125.50000000000001, 12), 125.5);
  EXPECT_EQ(round_to_digits(1.25e-4 / 1e-6, 12), 125);
  EXPECT_EQ(round_to_digits(-0.0049999999999999, 3), -0.005);
  EXPECT_EQ(round_to_digits(0, 12), 0);
  EXPECT_EQ(round_to_digits(999.9999999999999, 12), 1000);
  EXPECT_TRUE(std::isinf(round_to_digits(std::numeric_limits<double>::infinity(), 12)));
  EXPECT_TRUE(std::isnan(round_to_digits(std::nan(""), 12)));
  std::mt19937_64 random(11);
  for (int i = 0; i < 20'000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(round_to_digits(value, 12), parse(fmt::format("{:.12g}", value)));
  }
}

TEST(DecimalShift, ThereAndBackIsTheSameDouble) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200'000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(parse(decimal_shift(value, 0)), value);
  }
}

// Shifting by +12 gives the same digits as shifting by 0: with e-12 appended, the first text must
// read back as exactly the stored double.
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

TEST(ShiftDecimal, GivesTheDoubleThatTheDigitsMean) {
  EXPECT_EQ(shift_decimal(0.065, -3), 6.5e-05);  // 0.065 / 1000 is another double
  EXPECT_EQ(shift_decimal(1.84249e-12, 12), 1.84249);
  EXPECT_EQ(shift_decimal(-2.5, 3), -2500);
  EXPECT_EQ(shift_decimal(0, 5), 0);
  EXPECT_TRUE(std::isinf(shift_decimal(INFINITY, -3)));
}

TEST(DecimalPlaces, AreThoseOfTheFirstAndTheLastDigit) {
  const auto places = [](double value) {
    const auto p = decimal_places(value).value();
    return std::pair(p.first, p.last);
  };
  EXPECT_EQ(places(0.0124), std::pair(-2, -4));
  EXPECT_EQ(places(-0.0018815), std::pair(-3, -7));
  EXPECT_EQ(places(1), std::pair(0, 0));
  EXPECT_EQ(places(1200), std::pair(3, 2));
  EXPECT_EQ(places(1.5e-300), std::pair(-300, -301));
  EXPECT_FALSE(decimal_places(0));
  EXPECT_FALSE(decimal_places(std::numeric_limits<double>::infinity()));
}

std::string rounded(double value, int place, int power = 0) {
  std::string out;
  append_rounded(out, value, place, power);
  return out;
}

TEST(Rounded, HasNoDigitBehindItsPlace) {
  EXPECT_EQ(rounded(0.12566666666999998, -5), "0.12567");
  EXPECT_EQ(rounded(0.012150000000000001, -5), "0.01215");
  EXPECT_EQ(rounded(966.8662792832642, -1, -3), "0.9669");
  EXPECT_EQ(rounded(-0.00085347715, -5), "-0.00085");
  EXPECT_EQ(rounded(-1e-9, -5), "0");
  EXPECT_EQ(rounded(1234, 2), "1200");
  EXPECT_EQ(rounded(0.25, -400), "0.25") << "no double has a digit there";
  EXPECT_EQ(rounded(0.1, -17), "0.1");
  EXPECT_EQ(rounded(std::numeric_limits<double>::quiet_NaN(), -3), "nan");
}

}  // namespace
}  // namespace lcrig
