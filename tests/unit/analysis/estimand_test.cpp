// SPDX-License-Identifier: Apache-2.0
// Which slope a sensitivity refers to, and how far the slopes of the other choices are from it.
// These parts of the uncertainty have sizes that follow from how the run was made.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/analysis_text.hpp"
#include "tests/unit/analysis/analysed.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

const UncertaintyPart& part_of(const Uncertainty& u, const std::string& name) {
  const auto it = std::ranges::find(u.parts, name, &UncertaintyPart::name);
  EXPECT_NE(it, u.parts.end()) << name;
  static const UncertaintyPart none;
  return it == u.parts.end() ? none : *it;
}
const UncertaintyPart& part_of(const RangeResult& r, const std::string& name) {
  return part_of(r.uncertainty, name);
}
const Uncertainty& uncertainty_of(const RunAnalysis& a, const std::string& quantity) {
  const auto it = std::ranges::find_if(
      a.uncertainties, [&](const Uncertainty& u) { return u.quantity.starts_with(quantity); });
  EXPECT_NE(it, a.uncertainties.end()) << quantity;
  static const Uncertainty none;
  return it == a.uncertainties.end() ? none : *it;
}

// Up through the levels and down again, twice. 1.2 s pass at each level before its readings count.
struct UpAndDown {
  double slope_up = 6, slope_down = 6;  // fF/kPa, about 100 kPa

  RunAnalysis play(bool down) {
    SyntheticRun run;
    run.begin();
    for (int i = 0; i < 100; ++i) run.reading(3.65e-12 + noise(), 0);
    run.event("contact", R"({"travel_m":0.003,"force_N":0.02,"rest_force_N":0})");
    for (int repeat = 1; repeat <= 2; ++repeat) {
      int index = 0;
      for (int k = 1; k <= 10; ++k) stay(run, repeat, ++index, 10.0 * k, slope_up);
      for (int k = 9; down && k >= 1; --k) stay(run, repeat, ++index, 10.0 * k, slope_down);
      for (int i = 0; i < 20; ++i) run.reading(3.65e-12 + noise(), 0);
    }
    run.end();
    return analysed(run);
  }

 private:
  double noise() { return (++readings_ % 3 - 1) * 0.1e-15; }
  void stay(SyntheticRun& run, int repeat, int index, double kPa, double slope) {
    const double force_N = kPa * 1e3 * SyntheticRun::area_m2();
    const double at_F = 3.65e-12 + (600 + slope * (kPa - 100)) * 1e-15;
    for (int i = 0; i < 10; ++i) run.reading(at_F + noise(), force_N);
    run.level(repeat, index, kPa, 20);
    for (int i = 0; i < 20; ++i) run.reading(at_F + noise(), force_N);
    run.end_level();
  }
  int readings_ = 0;
};

TEST(Estimand, NamesTheBranchAndTheTimeUnderLoad) {
  UpAndDown test;
  const auto a = test.play(true);
  // 10 readings of 0.12 s come before the first that counts, and 29 before the last.
  for (const RangeResult& r : a.ranges) {
    EXPECT_EQ(r.sensitivity.estimand,
              "loading branch, from 1.2 to 3.5 s after the load was reached");
  }
  EXPECT_THAT(to_text(a), HasSubstr(a.ranges[0].sensitivity.estimand));
  SyntheticRun cycles;
  cycles.reading_s = 0.065;
  cycles.begin();
  cycles.play(SyntheticRun::Dynamic());
  cycles.end();
  EXPECT_EQ(analysed(cycles).ranges[0].sensitivity.estimand,
            "loading branch, while the load grows, from 3.97 kPa (5 % of the largest force) on");
}

TEST(Estimand, OtherBranchIsThePartByWhichItsSlopeDiffers) {
  UpAndDown test;
  test.slope_down = 5.7;
  const auto a = test.play(true);
  for (const RangeResult& r : a.ranges) {
    EXPECT_NEAR(r.sensitivity.value(), 6, 0.01);
    const UncertaintyPart& other = part_of(r, "other branch");
    EXPECT_NEAR(other.standard_uncertainty, 0.3 / std::sqrt(3.0), 0.01);
    EXPECT_EQ(other.source, ErrorSource::branch);
    EXPECT_GE(r.uncertainty.combined, other.standard_uncertainty);
    EXPECT_TRUE(holds(r.sensitivity, 6)) << "ci95 is for the branch that was measured";
  }
  const auto up_only = test.play(false);
  EXPECT_EQ(part_of(up_only.ranges[0], "other branch").standard_uncertainty, 0);
  EXPECT_THAT(part_of(up_only.ranges[0], "other branch").basis,
              HasSubstr("a hysteresis is not in the uncertainty"));
}

TEST(Estimand, AnotherTimeIsADecadeOfCreep) {
  SyntheticRun::Static s;
  s.noise_F = 0.2e-15;
  s.spoil = [](int, int reading, double v) {
    const double creep = 0.05 * std::log10(reading);  // 5 % a decade, from the first on
    return std::optional(3.65e-12 + (v - 3.65e-12) * (1 + creep));
  };
  const auto a = of_static(s);
  ASSERT_TRUE(a.creep);
  EXPECT_NEAR(a.creep.value(), 5, 1);
  for (const RangeResult& r : a.ranges) {
    const UncertaintyPart& time = part_of(r, "another time");
    EXPECT_NEAR(time.standard_uncertainty,
                a.creep.value() / 100 * r.sensitivity.value() / std::sqrt(3.0), 1e-6);
    EXPECT_EQ(time.source, ErrorSource::time);
  }
  s.spoil = SyntheticRun::Static().spoil;
  const auto steady = of_static(s);
  EXPECT_EQ(part_of(steady.ranges[0], "another time").standard_uncertainty, 0);
  EXPECT_THAT(part_of(steady.ranges[0], "another time").basis, HasSubstr("does not stand out"));
}

TEST(Estimand, OfTheHighestLevelAndOfTheDynamicRangeOfLevels) {
  UpAndDown test;
  const auto a = test.play(true);
  EXPECT_EQ(a.delta_C.estimand,
            "at 100 kPa, loading branch, from 1.2 to 3.5 s after the load was reached, less C0");
  EXPECT_EQ(a.dynamic_range.estimand,
            "at the peak of 1.26 N, from 1.2 to 3.5 s after the load was reached, less the rest "
            "before the cycle");
  EXPECT_NEAR(a.delta_C.value(), 600, 0.1);
  EXPECT_TRUE(holds(a.delta_C, 600));
  for (const char* quantity : {"delta C at 100 kPa", "dynamic range"}) {
    const Uncertainty& u = uncertainty_of(a, quantity);
    EXPECT_FALSE(u.estimand.empty()) << quantity;
    EXPECT_THAT(part_of(u, "other branch").basis, HasSubstr("both branches meet")) << quantity;
    EXPECT_GE(u.expanded, u.least) << quantity;
    EXPECT_THAT(to_text(a), HasSubstr("\n  " + u.estimand)) << quantity;
    EXPECT_EQ(to_json(u)["estimand"], u.estimand);
  }
  const auto json = to_json(a);
  for (const Metric* m : {&a.delta_C, &a.dynamic_range}) {
    EXPECT_EQ(json["metrics"][m->name]["estimand"], m->estimand);
    EXPECT_THAT(to_text(a), HasSubstr("\n    " + m->estimand));
  }
}

TEST(Estimand, AnotherTimeIsAPartOfTheHighestLevelAndOfTheDynamicRange) {
  SyntheticRun::Static s;
  s.noise_F = 0.2e-15;
  s.spoil = [](int, int reading, double v) {
    const double creep = 0.05 * std::log10(reading);
    return std::optional(3.65e-12 + (v - 3.65e-12) * (1 + creep));
  };
  const auto a = of_static(s);
  for (const auto& [quantity, metric] :
       {std::pair("delta C at", &a.delta_C), {"dynamic range", &a.dynamic_range}}) {
    const UncertaintyPart& time = part_of(uncertainty_of(a, quantity), "another time");
    EXPECT_NEAR(time.standard_uncertainty, a.creep.value() / 100 * metric->value() / std::sqrt(3.0),
                1e-6)
        << quantity;
    EXPECT_EQ(time.source, ErrorSource::time);
  }
}

// After the first load the specimen stays 3 fF higher. The rests make this look like a drift.
TEST(Estimand, RecoveryThatIsTakenForDriftIsAPartOfTheHighestLevel) {
  SyntheticRun::Static s;
  s.noise_F = 0.1e-15;
  bool loaded = false;
  s.capacitance_F = [&loaded](double kPa) {
    loaded = loaded || kPa > 0;
    return 3.65e-12 + 6e-15 * kPa + (loaded && kPa <= 0 ? 3e-15 : 0);
  };
  const auto a = of_static(s);
  EXPECT_LT(a.delta_C.value(), 599) << "a part of it is subtracted as drift";
  const UncertaintyPart& part = part_of(uncertainty_of(a, "delta C at"), "recovery at the rests");
  EXPECT_GT(part.standard_uncertainty, (600 - a.delta_C.value()) / std::sqrt(3.0) * 0.8);
  EXPECT_TRUE(holds(a.delta_C, 600)) << a.delta_C.value();
  const auto recovered = of_static(SyntheticRun::Static());
  const double noise = 44 / std::sqrt(20.0);  // of a rest
  EXPECT_LT(part_of(uncertainty_of(recovered, "delta C at"), "recovery at the rests")
                .standard_uncertainty,
            3 * noise);
}

// Unloading lies above loading, and its slope differs most at the ends.
TEST(Estimand, OfTheForceSensitivityIsTheLoadingWithTheOtherBranchAsAPart) {
  SyntheticRun::Dynamic d;
  d.noise_F = 0.2e-15;
  d.branch_s = 20;
  d.capacitance_F = [](double kPa, bool up) {
    return 3.65e-12 + (up ? 2.0 : 1.9) * 1e-15 * kPa + (up ? 0 : 0.1e-15 * 79.577);
  };
  const auto a = of_dynamic(d);
  EXPECT_EQ(a.force_sensitivity.estimand,
            "loading branch, while the load grows, from 0.05 N (5 % of the largest force) up to "
            "the peak of 1 N");
  EXPECT_EQ(a.dynamic_range.estimand,
            "at the peak of 1 N, where the load turns, less the rest before the cycle");
  const Uncertainty& u = uncertainty_of(a, "force sensitivity");
  EXPECT_EQ(u.estimand, a.force_sensitivity.estimand);
  EXPECT_NEAR(part_of(u, "other branch").standard_uncertainty, 0.1 * 79.577 / std::sqrt(3.0), 0.3);
  EXPECT_THAT(part_of(u, "another time").basis, HasSubstr("creep is not known"));
  EXPECT_NEAR(part_of(u, "force").standard_uncertainty, 0.01 * u.value / std::sqrt(3.0), 1e-6);
  EXPECT_GE(u.expanded, u.least);
}

TEST(Estimand, ScatterThatRepeatsShareIsFoundBesideASmoothCurve) {
  const double beside_curve[] = {3, -2, -3, 4, 1, -4, 2, 3, -4, 1};  // fF, the same in all repeats
  SyntheticRun::Static s;
  s.noise_F = 0.2e-15;
  s.spoil = [&](int level, int, double v) {
    return std::optional(v + beside_curve[(level - 1) % 10] * 1e-15);
  };
  const auto a = of_static(s);
  s.spoil = SyntheticRun::Static().spoil;
  const auto without = of_static(s);
  const RangeResult &r = a.ranges[1], &clean = without.ranges[1];
  const UncertaintyPart& shared = part_of(r, "scatter that repeats share");
  EXPECT_EQ(shared.degrees_of_freedom, 6) << "ten levels, and a cubic";
  // Deviations of some 3.5 fF at seven levels from 40 to 100 kPa, 10 kPa apart: Sxx = 2800.
  EXPECT_NEAR(shared.standard_uncertainty, 3.5 / std::sqrt(2800.0), 0.02);
  EXPECT_LT(part_of(clean, "scatter that repeats share").standard_uncertainty, 0.002);
  // Repeats do not show it, so it widens the expanded uncertainty only.
  EXPECT_LT(*r.sensitivity.estimate->standard_error, 0.005);
  EXPECT_GT(r.uncertainty.expanded, clean.uncertainty.expanded);
}

}  // namespace
}  // namespace lcrig
