// SPDX-License-Identifier: Apache-2.0
// Parts of the uncertainty that a result must have, and words for what its interval does not know.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/analysis_text.hpp"
#include "tests/unit/analysis/analysed.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

double part_of(const RunAnalysis& a, const std::string& quantity, const std::string& name) {
  for (const Uncertainty& u : a.uncertainties) {
    if (!u.quantity.starts_with(quantity)) continue;
    for (const UncertaintyPart& p : u.parts) {
      if (p.name == name) return p.standard_uncertainty;
    }
  }
  return -1;
}

// Saturates: at 100 kPa the slope is much less than in the mean.
double bent_F(double kPa) {
  return 3.65e-12 + 800e-15 * kPa / (kPa + 60);
}
double slope_fF_per_kPa(double kPa) {
  return 800 * 60 / ((kPa + 60) * (kPa + 60));
}

// A run whose readings are all taken on levels has no slope of its loadings.
TEST(Parts, TheDynamicRangeOfLevelsKnowsItsForceAndProbe) {
  SyntheticRun::Static s;
  s.noise_F = 0.4e-15;
  s.capacitance_F = bent_F;
  const auto a = of_static(s);
  ASSERT_FALSE(a.force_sensitivity.estimate);
  const double percent = slope_fF_per_kPa(100) * 100 / 3650 * 100;
  const double force = percent * 0.01 / std::sqrt(3), probe = percent * 0.01 / std::sqrt(3);
  EXPECT_NEAR(part_of(a, "dynamic range", "force at the peak"), force, 0.07 * force);
  EXPECT_NEAR(part_of(a, "dynamic range", "area of the probe"), probe, 0.07 * probe);
  EXPECT_NEAR(part_of(a, "delta C at 100", "force"), slope_fF_per_kPa(100) / std::sqrt(3),
              0.07 * slope_fF_per_kPa(100) / std::sqrt(3));
}

TEST(Parts, TheDynamicRangeOfCyclesTakesTheSlopeAtThePeak) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  SyntheticRun::Dynamic d;
  d.noise_F = 1e-15;
  d.capacitance_F = [](double kPa, bool) { return bent_F(kPa); };
  run.play(d);
  run.end();
  const auto a = analysed(run);
  const double kPa = 1e-3 / SyntheticRun::area_m2();
  const double force = slope_fF_per_kPa(kPa) * kPa / 3650 * 100 * 0.01 / std::sqrt(3);
  EXPECT_NEAR(part_of(a, "dynamic range", "force at the peak"), force, 0.1 * force);
}

// One level: no other slope than that from the rest to the peak.
TEST(Parts, OneLevelTakesTheMeanSlope) {
  SyntheticRun::Static s;
  s.noise_F = 0.4e-15;
  s.kPa = {100};
  const auto a = of_static(s);
  const double force = 600.0 / 3650 * 100 * 0.01 / std::sqrt(3);
  EXPECT_NEAR(part_of(a, "dynamic range", "force at the peak"), force, 0.02 * force);
}

// 9.9 nF in the baseline: the drift between the rests must not turn every slope.
TEST(Parts, OutliersOfTheBaselineDoNotTurnTheDrift) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  s.noise_F = 0.4e-15;
  int n = 0;
  s.capacitance_F = [&n](double kPa) {
    ++n;
    return n == 30 || n == 60 ? 9.9e-9 : 3.65e-12 + 6e-15 * kPa;
  };
  run.play(s);
  run.end();
  const auto a = analysed(run);
  EXPECT_EQ(a.outlier_count, 2);
  EXPECT_LT(std::abs(a.drift.value()), 20);
  EXPECT_NEAR(a.ranges[0].robust->slope_fF_per_kPa, 6, 0.05);
  EXPECT_NEAR(a.ranges[0].sensitivity.value(), 6, 0.05);
  EXPECT_THAT(a.limit_of_detection.reason, HasSubstr("outliers among the readings without load"));
  EXPECT_THAT(a.noise.reason, HasSubstr("outliers"));
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("gross outliers"));
}

TEST(Parts, OutliersOfCyclesAreListedAndRemarked) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  SyntheticRun::Dynamic d;
  d.noise_F = 0.4e-15;
  int loaded = 0;
  d.capacitance_F = [&loaded](double kPa, bool) {
    if (kPa > 0) ++loaded;
    return loaded == 100 || loaded == 101 ? 9.9e-9 : bent_F(kPa);
  };
  run.play(d);
  run.end();
  const auto a = analysed(run);
  EXPECT_EQ(a.outlier_count, 2);
  for (const Metric* m : {&a.ranges[0].sensitivity, &a.dynamic_range, &a.force_sensitivity,
                          &a.hysteresis.largest_gap, &a.hysteresis.area, &a.limit_of_detection}) {
    EXPECT_THAT(m->reason, HasSubstr("gross outliers among the readings under load")) << m->name;
  }
}

TEST(Parts, CyclesWithoutOutliersHaveNone) {
  for (const double branch_s : {0.4, 1.0, 2.0, 20.0}) {
    SyntheticRun run;
    run.reading_s = 0.065;
    run.begin();
    SyntheticRun::Dynamic d;
    d.noise_F = 0.4e-15;
    d.branch_s = branch_s;
    d.capacitance_F = [](double kPa, bool) { return bent_F(kPa); };
    run.play(d);
    run.end();
    EXPECT_EQ(analysed(run).outlier_count, 0) << branch_s;
  }
}

TEST(Parts, OneRepeatSpeaksOfSlowNoise) {
  SyntheticRun::Static s;
  s.repeats = 1;
  const auto a = of_static(s);
  EXPECT_THAT(a.ranges[0].sensitivity.reason, HasSubstr("slower than the correlation"));
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("slower than the correlation"));
}

// Rest and load step alike: the line of drift goes through steps, and turns all loadings alike.
TEST(Parts, ForceSensitivityHasTheDrift) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  SyntheticRun::Dynamic d;
  d.noise_F = 0.1e-15;
  d.branch_s = 20;
  const double steps_fF[] = {0, 20, -15, 10, -25, 18};
  bool loaded = false;
  int cycle = 0;
  d.capacitance_F = [&](double kPa, bool) {
    if (kPa > 0 && !loaded) ++cycle;
    loaded = kPa > 0;
    return 3.65e-12 + 2.15e-15 * kPa + 1e-15 * steps_fF[cycle];
  };
  run.play(d);
  run.end();
  const auto a = analysed(run);
  const double truth = 2.15 * 1e-3 / SyntheticRun::area_m2();
  EXPECT_TRUE(holds(a.force_sensitivity, truth)) << a.force_sensitivity.value();
}

TEST(Parts, TheEstimandOfCyclesNamesBothEnds) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  run.play(SyntheticRun::Dynamic());
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.ranges[0].estimand, HasSubstr("from 3.97 kPa (5 % of the largest force) on"));
  EXPECT_THAT(a.ranges[1].estimand, HasSubstr("up to the peak of 79.4 kPa"));
}

// A digit of 1 fF, and less noise.
TEST(Parts, TheDigitOfTheMeterIsAPart) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  s.noise_F = 0;
  s.capacitance_F = [](double kPa) { return std::round(bent_F(kPa) * 1e15) * 1e-15; };
  run.play(s);
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.c0.reason, HasSubstr("less than the meter's digit of 1 fF"));
  EXPECT_NEAR(part_of(a, "C0", "resolution of the meter"), 1e-3 / std::sqrt(12), 1e-6);
  EXPECT_NEAR(part_of(a, "sensitivity 35-100", "resolution of the meter"),
              1 / std::sqrt(12) / std::sqrt(2800), 1e-6);
  EXPECT_EQ(part_of(of_static(SyntheticRun::Static()), "C0", "resolution of the meter"), -1);
}

TEST(Parts, FewLevelsSayWhatIsMissing) {
  SyntheticRun::Static s;
  s.kPa = {10, 20, 30, 50, 90};
  EXPECT_THAT(of_static(s).ranges[0].sensitivity.reason, HasSubstr("fewer than six levels"));
  s.kPa = {10, 20, 30, 50, 70, 90};
  EXPECT_THAT(of_static(s).ranges[0].sensitivity.reason, Not(HasSubstr("fewer than six levels")));
}

TEST(Parts, ANumberThatIsNoCapacitanceIsLeftOut) {
  for (const double bad : {1e300, HUGE_VAL, -2.0}) {
    SyntheticRun::Static s;
    s.spoil = [bad](int level, int i, double v) { return level == 3 && i == 5 ? bad : v; };
    const auto a = of_static(s);
    EXPECT_THAT(a.notes, Contains(HasSubstr("1 readings are numbers that no meter measures")));
    EXPECT_EQ(to_json(a).dump().find("nan"), std::string::npos);
    EXPECT_TRUE(holds(a.ranges[1].sensitivity, 6));
  }
}

// The search for contact saw a force, the run none.
TEST(Parts, AForceOfExactlyZeroIsNoLoading) {
  SyntheticRun run;
  run.begin();
  for (int i = 0; i < 50; ++i) run.reading(3.65e-12 + 1e-15 * (i % 3), 0);
  run.event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":-0.001})");
  for (int i = 0; i < 200; ++i) run.reading(3.75e-12 + 1e-15 * (i % 3), 0);
  run.end();
  const auto a = analysed(run);
  EXPECT_FALSE(a.dynamic_range.estimate);
  for (const Uncertainty& u : a.uncertainties) EXPECT_TRUE(std::isfinite(u.combined)) << u.quantity;
}

TEST(Parts, ReadingsThatAreAlikeSayThatTheirIntervalSaysNothing) {
  SyntheticRun::Static s;
  s.noise_F = 0;
  const auto a = of_static(s);
  EXPECT_THAT(a.c0.reason, HasSubstr("do not scatter at all"));
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("do not scatter at all"));
}

}  // namespace
}  // namespace lcrig
