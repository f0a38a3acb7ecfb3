// SPDX-License-Identifier: Apache-2.0
// A sine that no specimen makes is found and subtracted. What the specimen does is left alone.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/analysis_text.hpp"
#include "analysis/metrics.hpp"
#include "tests/unit/analysis/disturbed_run.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;

RunAnalysis analysed_with(const Disturbed& d, std::uint64_t seed) {
  return analyse(DisturbedRun(d, seed).data).value();
}

int count_found(const Disturbed& d, int runs) {
  int found = 0;
  for (int i = 0; i < runs; ++i) {
    found += analysed_with(d, 5'100'000 + static_cast<std::uint64_t>(i)).hum ? 1 : 0;
  }
  return found;
}

TEST(Hum, IsFoundWithItsPeriodAndItsAmplitude) {
  for (const double period_s : {1.7, 4.1, 8.3}) {
    Disturbed d;
    d.hum = 0.6;
    d.period_s = period_s;
    const auto a = analysed_with(d, 1);
    ASSERT_TRUE(a.hum) << period_s;
    EXPECT_NEAR(a.hum->period_s(), period_s, 0.01 * period_s);
    EXPECT_NEAR(a.hum->amplitude_fF(), 0.6, 0.12) << period_s;
  }
}

// The same white noise with and without the sine: the difference is the error of the subtraction.
TEST(Hum, IsSubtractedFromAllReadings) {
  Disturbed d;
  const auto without_it = analysed_with(d, 2);
  d.hum = 4;
  const auto a = analysed_with(d, 2);
  ASSERT_TRUE(a.hum);
  ASSERT_FALSE(without_it.hum);
  for (std::size_t i = 0; i < 2; ++i) {
    const Estimate &with = *a.ranges[i].sensitivity.estimate,
                   &plain = *without_it.ranges[i].sensitivity.estimate;
    EXPECT_NEAR(with.value, plain.value, 0.004);
    EXPECT_LT(*with.standard_error, 0.003);  // 20 times as much with the sine
  }
  EXPECT_NEAR(a.c0.value(), without_it.c0.value(), 2e-4);
}

TEST(Hum, IsSaidInNotesTextAndJson) {
  Disturbed d;
  d.hum = 0.8;
  const auto a = analysed_with(d, 3);
  EXPECT_THAT(a.notes, Contains(HasSubstr("a beat of 6.6")));
  EXPECT_THAT(to_text(a), HasSubstr("was subtracted from all readings"));
  const auto json = to_json(a);
  EXPECT_NEAR(json["hum"]["period_s"].get<double>(), 6.6, 0.05);
  EXPECT_NEAR(json["hum"]["amplitude_fF"].get<double>(), 0.8, 0.15);
  EXPECT_TRUE(to_json(analysed_with({}, 3))["hum"].is_null());
}

TEST(Hum, IsFoundBesideCreepAndSlopesThatDiffer) {
  Disturbed d;
  d.hum = 0.6;
  d.creep_per_decade = 0.06;
  d.slopes = {1, 1.02, 0.97};
  const auto a = analysed_with(d, 4);
  ASSERT_TRUE(a.hum);
  EXPECT_NEAR(a.hum->period_s(), 6.6, 0.1);
  EXPECT_NEAR(a.hum->amplitude_fF(), 0.6, 0.12);
}

TEST(Hum, IsNotFoundWhereThereIsNone) {
  constexpr int kRuns = 60, kMost = 2;
  EXPECT_LE(count_found({}, kRuns), kMost) << "white";
  Disturbed creeps;
  creeps.creep_per_decade = 0.06;
  creeps.slopes = {1, 1.03, 0.95};
  EXPECT_LE(count_found(creeps, kRuns), kMost) << "creep";
  Disturbed correlated;
  correlated.correlation = 0.85;
  EXPECT_LE(count_found(correlated, kRuns), kMost) << "AR(1)";
  Disturbed walks;
  for (const double fF : {0.05, 0.2, 1.5}) {
    walks.walk_sqrt_s = fF;
    EXPECT_LE(count_found(walks, kRuns), kMost) << "walk " << fF;
  }
}

// A specimen whose response to every step rings with the period of the hum keeps its response.
TEST(Hum, WhatFollowsEveryStepAlikeIsTheSpecimens) {
  DisturbedRun run({}, 6);
  for (RunReading& r : run.data.readings) {
    if (r.index == 0) continue;
    const double step_s = 0.14 * r.index;
    r.capacitance_F +=
        3e-15 * std::exp(-step_s / 2) * std::sin(2 * std::numbers::pi * step_s / 1.5);
  }
  EXPECT_FALSE(analyse(run.data).value().hum);
}

TEST(Hum, AFewReadingsTellNothing) {
  Disturbed d;
  d.hum = 5;
  DisturbedRun run(d, 7);
  run.data.readings.resize(95);
  EXPECT_FALSE(analyse(run.data).value().hum);
  run.data.readings.resize(3);
  EXPECT_FALSE(analyse(run.data).value().hum);
}

TEST(Hum, SubtractsItsSine) {
  RunData data;
  data.readings.resize(3);
  for (int i = 0; i < 3; ++i) {
    data.readings[static_cast<std::size_t>(i)].t_s = i;
    data.readings[static_cast<std::size_t>(i)].capacitance_F = 1e-12;
  }
  const Hum hum{0.25, 2, 3};  // 2, 3, -2 fF at 0, 1, 2 s
  const RunData out = without(hum, data);
  EXPECT_NEAR(out.readings[0].capacitance_F, 998e-15, 1e-20);
  EXPECT_NEAR(out.readings[1].capacitance_F, 997e-15, 1e-20);
  EXPECT_NEAR(out.readings[2].capacitance_F, 1002e-15, 1e-20);
  EXPECT_DOUBLE_EQ(hum.period_s(), 4);
}

}  // namespace
}  // namespace lcrig
