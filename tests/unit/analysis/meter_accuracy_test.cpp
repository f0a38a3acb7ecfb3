// SPDX-License-Identifier: Apache-2.0
#include "analysis/meter_accuracy.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

MeterSetting at(double frequency_Hz, Aperture aperture) {
  MeterSetting s;
  s.frequency_Hz = frequency_Hz;
  s.aperture = aperture;
  return s;
}

// The table of the reference (section 4.3), to its two or three digits.
TEST(MeterAccuracy, GivesTheReferenceTable) {
  struct Row {
    double pF, Hz, slow_percent, fast_percent;
  };
  for (const Row& row :
       {Row{3.65, 1e3, 4.72, 9.69}, Row{7.29, 1e3, 2.39, 4.90}, Row{10.9, 1e3, 1.61, 3.31},
        Row{3.65, 1e4, 0.52, 1.06}, Row{10.9, 1e4, 0.21, 0.42}, Row{3.65, 1e5, 0.097, 0.196},
        Row{7.29, 1e5, 0.073, 0.148}, Row{10.9, 1e5, 0.066, 0.132}}) {
    const MeterPlace place;
    const double C = row.pF * 1e-12;
    const auto slow = meter_accuracy(at(row.Hz, Aperture::slow), place, C);
    const auto fast = meter_accuracy(at(row.Hz, Aperture::fast), place, C);
    ASSERT_TRUE(slow && fast);
    EXPECT_NEAR(slow->total * 100 / row.slow_percent, 1, 0.025) << row.pF << " pF " << row.Hz;
    EXPECT_NEAR(fast->total * 100 / row.fast_percent, 1, 0.025) << row.pF << " pF " << row.Hz;
  }
}

TEST(MeterAccuracy, OffsetHardlyDependsOnTheCapacitance) {
  const MeterPlace place;
  const auto a = meter_accuracy(at(1e3, Aperture::medium), place, 3.65e-12);
  const auto b = meter_accuracy(at(1e3, Aperture::medium), place, 10.9e-12);
  EXPECT_NEAR(a->offset_F, b->offset_F, 1e-18);
  EXPECT_NEAR(a->offset_F, 170e-15, 1e-15);
  EXPECT_NEAR(a->gain, 5e-4, 1e-9);
}

TEST(MeterAccuracy, GrowsOutsideItsTemperatureAndLevel) {
  MeterPlace warm;
  warm.temperature_C = 30;
  MeterSetting s = at(1e5, Aperture::slow);
  const double cool = meter_accuracy(s, MeterPlace(), 3.65e-12)->total;
  EXPECT_NEAR(meter_accuracy(s, warm, 3.65e-12)->total, 2 * cool, 1e-12);
  s.level_V = 0.1;
  EXPECT_NEAR(meter_accuracy(s, MeterPlace(), 3.65e-12)->gain, 2.5 * 5e-4, 1e-12);
  warm.temperature_C = 50;
  EXPECT_FALSE(meter_accuracy(s, warm, 3.65e-12));
  EXPECT_FALSE(meter_accuracy(s, MeterPlace(), 0));
}

TEST(MeterSetting, IsReadFromTheStoredJsonAndRefusesHalfOfIt) {
  const auto s = parse_meter_setting(
      R"({"function":"Cp-D","frequency_Hz":20000,"level_V":0.5,"aperture":"fast","average":4,)"
      R"("trigger":"internal","conversion_time_s":0.26})");
  ASSERT_TRUE(s);
  EXPECT_EQ(s->frequency_Hz, 20000);
  EXPECT_EQ(s->aperture, Aperture::fast);
  EXPECT_TRUE(s->internal_trigger);
  EXPECT_EQ(s->conversion_s, 0.26);
  EXPECT_NEAR(meter_noise_F(*s), 60e-15 / 20 / 0.5 / 2, 1e-20);
  EXPECT_FALSE(parse_meter_setting(R"({"frequency_Hz":1000})"));
  EXPECT_FALSE(parse_meter_setting("not json"));
}

}  // namespace
}  // namespace lcrig
