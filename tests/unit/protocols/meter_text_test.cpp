// SPDX-License-Identifier: Apache-2.0
#include "protocols/file/meter_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace lcrig {
namespace {

using testing::HasSubstr;

const std::string kText = R"({ "format": "load-protocol/1", "name": "look",
  "title": "Blicke auf ein Gerät",  // "aperture": "slow"
  "parameters": { "for_s": { "default": 10, "min": 1, "max": 100 } },
  "limits": {},
  "sample": { "lcr": { "function": "Cp-D", "frequency_kHz": 20, "level_V": 1,
                       "aperture": "fast" } },
  "steps": [ { "id": "record", "do": "record", "for_s": "$for_s" } ], "finally": [] })";

TEST(MeterText, ChangesFrequencyAndApertureAndNothingElse) {
  ParameterValues values{{"frequency_Hz", "1e5"}, {"aperture", "slow"}, {"for_s", 20.0}};
  const auto changed = with_meter_values(kText, "look", values);
  ASSERT_TRUE(changed) << changed.error().what;
  EXPECT_EQ(values.size(), 1U) << "the protocol's own parameter stays";
  const auto protocol = parse_protocol(*changed, "look");
  ASSERT_TRUE(protocol) << protocol.error().what;
  EXPECT_EQ(protocol->sample.lcr.frequency.si(), 1e5);
  EXPECT_EQ(protocol->sample.lcr.aperture, Aperture::slow);
  std::string expected = kText;
  const auto replace = [&expected](const std::string& from, const std::string& to) {
    expected.replace(expected.find(from), from.size(), to);
  };
  replace(R"("frequency_kHz": 20)", R"("frequency_Hz": 1e5)");
  replace(R"("aperture": "fast")", R"("aperture": "slow")");
  EXPECT_EQ(*changed, expected);
}

TEST(MeterText, AParameterOfTheProtocolKeepsItsName) {
  std::string own = kText;
  own.insert(own.find(R"("for_s")"), R"("aperture": { "default": 1, "min": 0, "max": 2 }, )");
  ParameterValues values{{"aperture", "2"}};
  EXPECT_EQ(with_meter_values(own, "look", values).value(), own);
  EXPECT_EQ(values.size(), 1U);
}

TEST(MeterText, OfTwoKeysNoneIsReplacedAndBothAreToldOf) {
  std::string two = kText;
  two.insert(two.find(R"("level_V")"), R"("frequency_kHz": 30, )");
  ParameterValues values{{"frequency_Hz", "1e5"}};
  const auto parsed = parse_protocol(with_meter_values(two, "look", values).value(), "look");
  ASSERT_FALSE(parsed);
  EXPECT_THAT(parsed.error().what, HasSubstr("`frequency_kHz` for the second time"));
}

// A text from a program that ends lines with CR alone.
TEST(MeterText, FindsItsPlaceWhateverEndsALine) {
  std::string text = kText;
  std::ranges::replace(text, '\n', '\r');
  ParameterValues values{{"frequency_Hz", "1e5"}};
  const auto protocol = parse_protocol(with_meter_values(text, "look", values).value(), "look");
  ASSERT_TRUE(protocol) << protocol.error().what;
  EXPECT_EQ(protocol->sample.lcr.frequency.si(), 1e5);
}

TEST(MeterText, WhatIsNoFrequencyIsRefused) {
  ParameterValues values{{"frequency_Hz", R"(1, "bias_V": 2)"}};
  MeterValue wrong = MeterValue::none;
  const auto changed = with_meter_values(kText, "look", values, &wrong);
  ASSERT_FALSE(changed);
  EXPECT_EQ(wrong, MeterValue::frequency);
  EXPECT_THAT(changed.error().what, HasSubstr("is no number"));
  ParameterValues word{{"aperture", "quick"}};
  const auto refused = with_meter_values(kText, "look", word, &wrong);
  ASSERT_FALSE(refused);
  EXPECT_EQ(wrong, MeterValue::aperture);
  ASSERT_FALSE(with_meter_values("{", "look", word, &wrong));
  EXPECT_EQ(wrong, MeterValue::none);
  EXPECT_EQ(refused.error().what, "aperture: \"quick\", expected one of fast, medium, slow, auto");
  ParameterValues comma{{"frequency_Hz", "1,5"}};
  EXPECT_EQ(with_meter_values(kText, "look", comma).error().what,
            "frequency_Hz: \"1,5\" is no number: a decimal number is written with a point: 1.5");
}

}  // namespace
}  // namespace lcrig
