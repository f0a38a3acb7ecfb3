// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "drivers/lcr6100/codec.hpp"

namespace lcrig::lcr6100 {
namespace {

TEST(ReadingLine, NumbersAreExactAndWordsAreKept) {
  const auto r = parse_reading("+4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG");
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->primary, 4.64627e-10);
  EXPECT_EQ(r->secondary, 3.88413e-03);
  EXPECT_EQ(r->flags, 0U);
  EXPECT_EQ(r->values, "+4.64627e-10,+3.88413e-03");
  EXPECT_EQ(r->status, "OUT ,AUX-NG,NG");
}

TEST(ReadingLine, AnOverloadIsNoNumber) {
  const auto r = parse_reading("+1.938e-12,+1.000e+20,OUT ,AUX-OK,NG");
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->primary, 1.938e-12);
  EXPECT_EQ(r->secondary, std::nullopt);
  EXPECT_EQ(r->flags, lcr_flag::kSecondaryOverload);
  const auto both = parse_reading("-9.90000e+19,+1.00000e+20,OUT ,AUX-OK,NG");
  ASSERT_TRUE(both);
  EXPECT_EQ(both->primary, std::nullopt);
  EXPECT_EQ(both->flags, lcr_flag::kPrimaryOverload | lcr_flag::kSecondaryOverload);
}

TEST(Switch, IsOnOrOffInAnyDialect) {
  for (const char* on : {"on", "ON", "1", " On "}) EXPECT_EQ(parse_switch(on), true) << on;
  for (const char* off : {"off", "OFF", "0"}) EXPECT_EQ(parse_switch(off), false) << off;
  for (const char* neither : {"", "2", "onn", "+1.00000e+00"}) {
    EXPECT_EQ(parse_switch(neither), std::nullopt) << neither;
  }
}

TEST(ReadingLine, DcrHasOneNumberAndNoAuxiliaryWord) {
  const auto r = parse_reading("+4.92312e+03,OUT ,OK");
  ASSERT_TRUE(r);
  EXPECT_EQ(r->numbers, 1);
  EXPECT_EQ(r->primary, 4923.12);
  EXPECT_EQ(r->secondary, std::nullopt);
  EXPECT_EQ(r->status, "OUT ,OK");
  EXPECT_EQ(parse_reading("+1.23434e+05")->numbers, 1);
}

TEST(ReadingLine, MonitorsAndBinsAreUnderstood) {
  const auto r =
      parse_reading("+2.61788e-11,+5.45442e-01,+3.88651e+05,+0.00000e+00,BIN1,AUX-OK,OK");
  ASSERT_TRUE(r);
  EXPECT_EQ(r->numbers, 4);
  EXPECT_EQ(r->status, "BIN1,AUX-OK,OK");
  EXPECT_EQ(parse_reading("-3.11391e-03,-2.33504e-02,OUT ,AUX-NG,NG")->secondary, -2.33504e-02);
}

TEST(ReadingLine, NonsenseIsGarbled) {
  for (const char* line :
       {"",
        "OUT ,AUX-NG,NG",
        "hello",
        "FETC?",
        "*E00",
        "+1.00000e-12,,OUT",
        "nan,nan",
        "inf",
        "+inf,+1.00000e+00,OUT ,AUX-NG,NG",
        "+4.64627e-1,+3.88413e-03,OUT ,AUX-NG,NG",
        "+4.6462e-10,+3.88413e-03,OUT ,AUX-NG,NG",
        "4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG",
        "+4.64627e-10+3.88413e-03,OUT ,AUX-NG,NG",
        "+4.64627e-10,+3.88413e-03,OU ,AUX-NG,NG",
        "+4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG,NG",
        "+4.64627e-10,+3.88413e-03,",
        "+4.64627e-10,+3.88413e-03,OUT ,+1.00000e+00",
        "+0x1p-3,OUT ,OK",
        "+-1.0000e+00",
        "+4.64627e-100,+3.88413e-03,OUT ,AUX-NG,NG",
        "+1.00000e+00,+1.00000e+00,+1.00000e+00,+1.00000e+00,+1.00000e+00,OUT ,OK,OK"}) {
    const auto r = parse_reading(line);
    ASSERT_FALSE(r) << line;
    EXPECT_EQ(r.error().code, Errc::garbled);
  }
}

TEST(ReadingLine, EveryLostByteIsNoticed) {
  const std::string good = "+4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG";
  for (std::size_t i = 0; i < good.find("OUT"); ++i) {
    std::string bad = good;
    bad.erase(i, 1);
    EXPECT_FALSE(parse_reading(bad)) << bad;
  }
}

TEST(ReadingLine, RandomBytesNeverCrash) {
  std::mt19937 random(3);
  for (int round = 0; round < 20000; ++round) {
    std::string line = "+4.64627e-10,+3.88413e-03,OUT ,AUX-NG,NG";
    for (int hit = 0; hit < 4; ++hit) {
      line[random() % line.size()] = static_cast<char>(random() % 256);
    }
    const auto r = parse_reading(line);
    EXPECT_TRUE(!r || r->numbers >= 1);
    static_cast<void>(parse_identity(line));
    static_cast<void>(parse_with_unit(line));
  }
}

TEST(Identity, TheMakerHasACommaOfItsOwn) {
  const auto id = parse_identity("LCR-6100,REV E8.13,GEZ883880,Good Will Instrument Co., Ltd.");
  ASSERT_TRUE(id);
  EXPECT_EQ(id->model, "LCR-6100");
  EXPECT_EQ(id->firmware, "REV E8.13");
  EXPECT_EQ(id->serial, "GEZ883880");
  EXPECT_EQ(id->maker, "Good Will Instrument Co., Ltd.");
  EXPECT_TRUE(is_supported_model(id->model));
  EXPECT_TRUE(is_supported_model("LCR-76200"));
  EXPECT_FALSE(is_supported_model("E4980A"));
  EXPECT_FALSE(parse_identity("garbage"));
  EXPECT_FALSE(parse_identity(",,,"));
}

TEST(Numbers, AreWrittenAsTheMeterWritesThem) {
  EXPECT_EQ(format_number(4.64627e-10), "+4.64627e-10");
  EXPECT_EQ(format_number(-1e20), "-1.00000e+20");
  EXPECT_EQ(format_number(0), "+0.00000e+00");
  EXPECT_EQ(format_parameter(0.1), "0.1");
  EXPECT_EQ(format_parameter(1000), "1000");
}

TEST(Numbers, UnitsMayBeGluedToThem) {
  EXPECT_EQ(parse_with_unit("1.000e-01V"), 0.1);
  EXPECT_EQ(parse_with_unit("+2.50V"), 2.5);
  EXPECT_EQ(parse_with_unit("1.000000e+03"), 1000.0);
  EXPECT_EQ(parse_with_unit("-2.5 V"), -2.5);
  EXPECT_EQ(parse_with_unit("20ms"), 0.02);
  for (const char* text : {"OFF", "", "V", "1.0W", "+", "+-1", "nan", "1.0V1", "0x10"}) {
    EXPECT_EQ(parse_with_unit(text), std::nullopt) << text;
  }
}

const Setting& find(const std::vector<Setting>& all, SettingId id) {
  for (const auto& s : all) {
    if (s.id == id) return s;
  }
  throw std::logic_error("no such setting");
}

TEST(SetUp, ReadBacksMatchInEveryStyleTheMeterHas) {
  LcrSettings s;
  s.bias = Voltage::from_si(2.5);
  s.aperture = Aperture::fast;
  s.average = 4;
  const auto all = settings_for(s);
  EXPECT_TRUE(matches(find(all, SettingId::page), "meas"));
  EXPECT_TRUE(matches(find(all, SettingId::function), "cp-d"));
  EXPECT_TRUE(matches(find(all, SettingId::level), "1.000e+00V"));
  EXPECT_FALSE(matches(find(all, SettingId::level), "1.010e+00V"));
  EXPECT_TRUE(matches(find(all, SettingId::bias), "+2.50V"));
  EXPECT_FALSE(matches(find(all, SettingId::bias), "OFF"));
  EXPECT_TRUE(matches(find(all, SettingId::frequency), "1.000000e+03"));
  EXPECT_FALSE(matches(find(all, SettingId::frequency), "1.000100e+03"));
  EXPECT_TRUE(matches(find(all, SettingId::aperture), "FAST,4"));
  EXPECT_TRUE(matches(find(all, SettingId::average), "FAST,4"));
  EXPECT_FALSE(matches(find(all, SettingId::average), "FAST"));
  EXPECT_FALSE(matches(find(all, SettingId::function), ""));
  EXPECT_EQ(all.back().id, SettingId::trigger);
  EXPECT_EQ(all.back().set, "TRIG:SOUR BUS");
}

TEST(SetUp, OffIsNotANumber) {
  const auto all = settings_for(LcrSettings());
  EXPECT_EQ(find(all, SettingId::bias).set, "BIAS OFF");
  EXPECT_TRUE(matches(find(all, SettingId::bias), "OFF"));
  EXPECT_FALSE(matches(find(all, SettingId::bias), "+0.00V"));
}

}  // namespace
}  // namespace lcrig::lcr6100
