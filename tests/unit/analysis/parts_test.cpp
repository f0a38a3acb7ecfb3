// SPDX-License-Identifier: Apache-2.0
// Parts of the uncertainty that a result must have, and caveats on what its interval ignores.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

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

// A saturating curve: at 100 kPa its slope is much smaller than the mean slope.
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
  SyntheticRun::Dynamic d;
  d.noise_F = 1e-15;
  d.capacitance_F = [](double kPa, bool) { return bent_F(kPa); };
  const auto a = of_dynamic(d);
  const double kPa = 1e-3 / SyntheticRun::area_m2();
  const double force = slope_fF_per_kPa(kPa) * kPa / 3650 * 100 * 0.01 / std::sqrt(3);
  EXPECT_NEAR(part_of(a, "dynamic range", "force at the peak"), force, 0.1 * force);
}

// With one level, only the slope from the rest to the peak is known.
TEST(Parts, OneLevelTakesTheMeanSlope) {
  SyntheticRun::Static s;
  s.noise_F = 0.4e-15;
  s.kPa = {100};
  const auto a = of_static(s);
  const double force = 600.0 / 3650 * 100 * 0.01 / std::sqrt(3);
  EXPECT_NEAR(part_of(a, "dynamic range", "force at the peak"), force, 0.02 * force);
}

// 9.9 nF in the baseline must not tilt every slope through the drift between the rests.
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
  EXPECT_THAT(a.noise.reason, HasSubstr("are left out: of outliers"));
  EXPECT_NEAR(a.noise.value(), 0.4, 0.06);
  EXPECT_NEAR(*a.noise.estimate->degrees_of_freedom, (99 - 4) / 1.5, 1.5) << "chance correlates";
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("gross outliers"));
}

TEST(Parts, OutliersOfCyclesAreListedAndRemarked) {
  SyntheticRun::Dynamic d;
  d.noise_F = 0.4e-15;
  int loaded = 0;
  d.capacitance_F = [&loaded](double kPa, bool) {
    if (kPa > 0) ++loaded;
    return loaded == 100 || loaded == 101 ? 9.9e-9 : bent_F(kPa);
  };
  const auto a = of_dynamic(d);
  EXPECT_EQ(a.outlier_count, 2);
  for (const Metric* m : {&a.ranges[0].sensitivity, &a.dynamic_range, &a.force_sensitivity,
                          &a.hysteresis.largest_gap, &a.hysteresis.area, &a.limit_of_detection}) {
    EXPECT_THAT(m->reason, HasSubstr("gross outliers among the readings under load")) << m->name;
  }
}

TEST(Parts, CyclesWithoutOutliersHaveNone) {
  for (const double branch_s : {0.4, 1.0, 2.0, 20.0}) {
    SyntheticRun::Dynamic d;
    d.noise_F = 0.4e-15;
    d.branch_s = branch_s;
    d.capacitance_F = [](double kPa, bool) { return bent_F(kPa); };
    EXPECT_EQ(of_dynamic(d).outlier_count, 0) << branch_s;
  }
}

TEST(Parts, OneRepeatSpeaksOfSlowNoise) {
  SyntheticRun::Static s;
  s.repeats = 1;
  const auto a = of_static(s);
  EXPECT_THAT(a.ranges[0].sensitivity.reason, HasSubstr("slower than the correlation"));
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("slower than the correlation"));
}

// Rest and load jump together. The line of drift goes through the jumps and tilts each loading.
TEST(Parts, ForceSensitivityHasTheDrift) {
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
  const auto a = of_dynamic(d);
  const double truth = 2.15 * 1e-3 / SyntheticRun::area_m2();
  EXPECT_TRUE(holds(a.force_sensitivity, truth)) << a.force_sensitivity.value();
}

double part_of(const RunAnalysis& a, const char* quantity, const char* name, double& freedom) {
  for (const Uncertainty& u : a.uncertainties) {
    for (const UncertaintyPart& p : u.parts) {
      if (u.quantity != quantity || p.name != name) continue;
      freedom = p.degrees_of_freedom;
      return p.standard_uncertainty;
    }
  }
  return -1;
}

// A loading of 20 s to 1 N: an error of the drift's rate changes each slope by 20 s/N of it.
TEST(Parts, TheDriftOfTheForceSensitivityIsItsRateTimesTheTimeOfALoading) {
  SyntheticRun::Dynamic d;
  d.noise_F = 0.5e-15;
  d.branch_s = 20;
  const auto a = of_dynamic(d);
  double freedom = 0;
  const double drift = part_of(a, "force sensitivity", "drift of C0", freedom);
  // Five rests of some 38 readings after the baseline of 308, 45 s apart: the rate of a line.
  const double t[] = {10, 63.5, 108.5, 153.5, 198.5, 243.5}, n[] = {308, 38, 38, 38, 38, 38};
  double weights = 0, mean = 0, sxx = 0;
  for (int k = 0; k < 6; ++k) weights += n[k], mean += n[k] * t[k];
  mean /= weights;
  for (int k = 0; k < 6; ++k) sxx += n[k] * (t[k] - mean) * (t[k] - mean);
  const double rate_fF_s = 0.5 / std::sqrt(sxx);
  EXPECT_NEAR(drift / (20 * rate_fF_s), 1, 0.25);
  const auto& parts = a.parts_of_force_sensitivity;
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_NEAR(*a.force_sensitivity.estimate->standard_error, std::hypot(parts[0].se, parts[1].se),
              1e-12);
  // The same for a slope against pressure: 20 s for 79.6 kPa.
  for (const RangeResult& r : a.ranges) {
    ASSERT_EQ(r.parts_of_error.size(), 2U);
    EXPECT_NEAR(r.parts_of_error[1].se / (20 / 79.577 * rate_fF_s), 1, 0.25);
  }
}

// The last turn overshoots, so its peak is 2 % higher, and there the specimen gives 5 % less.
TEST(Parts, MullinsIsAtEqualForce) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  SyntheticRun::Dynamic d;
  d.noise_F = 0.2e-15;
  d.baseline_s = 10;
  d.cycles = 1;
  const double heights[] = {1, 0.95};
  for (const double height : heights) {
    d.peak_N = height < 1 ? 1.015 : 1;
    d.capacitance_F = [height](double kPa, bool) {
      return 3.65e-12 + height * (bent_F(kPa) - bent_F(0));
    };
    run.play(d);
  }
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.cycles.size(), 2U);
  ASSERT_TRUE(a.mullins) << a.mullins.reason;
  EXPECT_NEAR(a.mullins.value(), 5, 0.2) << "not " << (1 - 0.95 * 1.007) * 100;
  EXPECT_TRUE(holds(a.mullins, 5));
}

// The ramp to the level comes within 2 % of its force half a second before it.
TEST(Parts, AHeldPeakIsThatOfTheLevelWithoutItsRamp) {
  SyntheticRun run;
  run.begin();
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto at = [&](double force_N) {
    run.reading(bent_F(force_N / SyntheticRun::area_m2() * 1e-3) + 0.05e-15 * normal(random),
                force_N);
  };
  for (int i = 0; i < 100; ++i) at(0);
  run.event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
  const double top_N = 100e3 * SyntheticRun::area_m2();
  for (int repeat = 1; repeat <= 3; ++repeat) {
    for (const double part : {0.3, 0.6}) at(part * top_N);
    for (int i = 0; i < 12; ++i) at((0.981 + 0.001 * i) * top_N);
    run.level(repeat, 1, 100, 20);
    for (int i = 0; i < 20; ++i) at(top_N);
    run.end_level();
    for (int i = 0; i < 20; ++i) at(0);
  }
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.cycles.size(), 3U);
  for (const CycleResult& c : a.cycles) {
    EXPECT_EQ(c.peak_method, PeakMethod::plateau);
    EXPECT_NEAR(c.delta_C_fF, (bent_F(100) - bent_F(0)) * 1e15, 0.1) << "1 fF less with the ramp";
    EXPECT_NEAR(c.peak_force_N / top_N, 1, 1e-6);
  }
}

TEST(Parts, TheEstimandOfCyclesNamesBothEnds) {
  SyntheticRun run;
  run.reading_s = 0.065;
  run.begin();
  run.play(SyntheticRun::Dynamic());
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.ranges[0].sensitivity.estimand,
              HasSubstr("from 3.97 kPa (5 % of the largest force) on"));
  EXPECT_THAT(a.ranges[1].sensitivity.estimand, HasSubstr("up to the peak of 79.4 kPa"));
}

// A digit of 1 fF, with less noise than that.
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

TEST(Parts, TheDigitOfTheMeterIsItsStep) {
  for (const double step_fF : {2.0, 2.5, 5.0, 20.0}) {
    SyntheticRun run;
    run.begin();
    SyntheticRun::Static s;
    s.noise_F = 0;
    s.capacitance_F = [&](double kPa) {
      return std::round(bent_F(kPa) * 1e15 / step_fF) * step_fF * 1e-15;
    };
    run.play(s);
    run.end();
    const auto a = analysed(run);
    EXPECT_THAT(a.c0.reason,
                HasSubstr(fmt::format("less than the meter's digit of {:g} fF", step_fF)));
    EXPECT_NEAR(part_of(a, "C0", "resolution of the meter"), step_fF * 1e-3 / std::sqrt(12), 1e-6);
  }
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

// The search for contact saw a force, but the run saw none.
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
