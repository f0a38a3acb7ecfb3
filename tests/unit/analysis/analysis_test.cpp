// SPDX-License-Identifier: Apache-2.0
// Metrics of synthetic runs whose truth is known.
#include "analysis/analysis.hpp"
#include "analysis/comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "storage/writer_lock.hpp"
#include "tests/unit/analysis/analysed.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST(Analyse, FindsTheSlopeC0AndNoiseOfAStraightSpecimen) {
  const auto a = of_static(SyntheticRun::Static());
  EXPECT_NEAR(a.c0.value(), 3.65, 4 * 0.044 / 10);
  // 44 fF/sqrt(100), plus the slow noise that such a baseline cannot exclude.
  EXPECT_GT(*a.c0.estimate->standard_error, 0.0044 * 0.8);
  EXPECT_LT(*a.c0.estimate->standard_error, 0.0044 * 4);
  EXPECT_NEAR(a.noise.value(), 44, 10);
  ASSERT_EQ(a.ranges.size(), 2U);
  for (const RangeResult& r : a.ranges) {
    const double se = *r.sensitivity.estimate->standard_error;
    EXPECT_NEAR(r.sensitivity.value(), 6, 4 * se);
    EXPECT_GT(r.robust->standard_error, 0);
  }
  // Noise of a level 44/sqrt(30) fF; pressures 10, 20, 30 in four repeats: sxx = 4 * 200. The rests
  // add their noise, and the slopes of four repeats know the scatter to a third.
  EXPECT_NEAR(*a.ranges[0].sensitivity.estimate->standard_error, 8.03 / std::sqrt(800), 0.2);
  EXPECT_EQ(a.ranges[0].points, 12);
  EXPECT_EQ(a.ranges[0].pressures, 3);
  EXPECT_EQ(a.ranges[0].sensitivity.rows, 12 * 30);
  EXPECT_EQ(a.curve.size(), 10U);
  EXPECT_EQ(a.outlier_count, 0);
}

TEST(Analyse, WithoutNoiseTheSlopeIsExact) {
  SyntheticRun::Static s;
  s.noise_F = 0;
  const auto a = of_static(s);
  EXPECT_NEAR(a.ranges[0].sensitivity.value() / 6, 1, 1e-7);
  EXPECT_NEAR(a.ranges[1].sensitivity.value() / 6, 1, 1e-7);
  EXPECT_NEAR(*a.curve.back().delta_C_fF, 600, 1e-6);
}

TEST(Analyse, ResolvesOneFemtofaradOnFortyPicofarad) {
  SyntheticRun::Static s;
  s.noise_F = 0.05e-15;
  s.capacitance_F = [](double kPa) { return 40e-12 + 1e-17 * kPa; };  // 1 fF at 100 kPa
  const auto a = of_static(s);
  EXPECT_NEAR(a.ranges[1].sensitivity.value(), 0.01, 1e-4);
  EXPECT_TRUE(holds(a.ranges[1].sensitivity, 0.01));
}

TEST(Analyse, TwoLevelsGiveASlopeAndOneLevelDoesNot) {
  SyntheticRun::Static s;
  s.kPa = {10, 30};
  const auto two = of_static(s);
  EXPECT_TRUE(holds(two.ranges[0].sensitivity, 6));
  EXPECT_FALSE(two.ranges[1].sensitivity);
  EXPECT_THAT(two.ranges[1].sensitivity.reason, HasSubstr("two different ones"));
  s.kPa = {20};
  const auto one = of_static(s);
  EXPECT_FALSE(one.ranges[0].sensitivity);
}

TEST(Analyse, AllPressuresEqualIsRefused) {
  SyntheticRun::Static s;
  s.kPa = {20, 20, 20};
  const auto a = of_static(s);
  EXPECT_FALSE(a.ranges[0].sensitivity);
  EXPECT_THAT(a.ranges[0].sensitivity.reason, HasSubstr("1 of the run's pressures"));
}

TEST(Analyse, OneReadingPerLevelUsesTheScatterBetweenRepeats) {
  SyntheticRun::Static s;
  s.readings = 1;
  s.repeats = 6;
  const auto a = of_static(s);
  EXPECT_EQ(*a.ranges[0].sensitivity.estimate->degrees_of_freedom, 5);
  EXPECT_TRUE(holds(a.ranges[0].sensitivity, 6));
  s.repeats = 1;
  const auto once = of_static(s);
  EXPECT_THAT(once.ranges[0].scatter_basis, HasSubstr("about the line"));
  s.kPa = {10, 30};
  const auto exact = of_static(s);
  EXPECT_FALSE(exact.ranges[0].sensitivity.estimate->standard_error);
  EXPECT_THAT(exact.ranges[0].sensitivity.reason, HasSubstr("no interval"));
}

TEST(Analyse, OverloadsAreCountedAndNeverBecomeNumbers) {
  SyntheticRun::Static s;
  s.spoil = [](int level, int i, double v) {
    return level == 3 || i % 5 == 0 ? std::nullopt : std::optional(v);
  };
  const auto a = of_static(s);
  EXPECT_TRUE(holds(a.ranges[0].sensitivity, 6));
  EXPECT_EQ(a.levels.size(), 39U);
  EXPECT_EQ(a.levels[0].readings, 24);
  EXPECT_EQ(a.levels[0].missing, 6);
  EXPECT_THAT(a.notes, Contains(HasSubstr("overloads")));
  EXPECT_THAT(a.notes, Contains(HasSubstr("1 levels have no usable reading")));
}

TEST(Analyse, AnAbandonedLevelCountsNowhere) {
  SyntheticRun::Static s;
  s.spoil = [](int level, int, double v) { return std::optional(level == 3 ? v + 1e-12 : v); };
  SyntheticRun run;
  run.begin();
  run.play(s);
  run.event("level_abandoned", R"({"level":3,"readings":30})");
  const auto a = analyse(run.db(), run.end());
  ASSERT_TRUE(a) << a.error().what;
  EXPECT_TRUE(holds(a->ranges[0].sensitivity, 6));
  EXPECT_EQ(a->levels.size(), 39U);
  EXPECT_EQ(a->levels[2].level, 4);
  EXPECT_THAT(a->notes, Contains(HasSubstr("1 levels were abandoned")));
}

TEST(Analyse, ABenchBeyondItsModelIsNoted) {
  SyntheticRun run;
  run.begin();
  run.play(SyntheticRun::Static());
  run.event("extrapolated", "the bench went to 3 N");
  const auto a = analyse(run.db(), run.end());
  ASSERT_TRUE(a) << a.error().what;
  EXPECT_THAT(a->notes, Contains("the bench went to 3 N"));
}

TEST(Analyse, AFalseStatementAboutTheFrameIsNoted) {
  SyntheticRun run;
  run.begin();
  run.play(SyntheticRun::Static());
  run.event("device_travel_step", "the travel changed by 0.1 um");
  const auto a = analyse(run.db(), run.end());
  ASSERT_TRUE(a) << a.error().what;
  EXPECT_THAT(a->notes, Contains("the travel changed by 0.1 um"));
}

TEST(Analyse, ListsAnOutlierOfSixSigmaAndKeepsIt) {
  SyntheticRun::Static s;
  s.seed = 5;
  s.spoil = [](int level, int i, double v) {
    return level == 2 && i == 7 ? 3.65e-12 + 6e-15 * 20 + 6 * 44e-15 : v;
  };
  const auto a = of_static(s);
  ASSERT_EQ(a.outlier_count, 1);
  EXPECT_EQ(a.outliers[0].level, 2);
  EXPECT_EQ(a.outliers[0].index, 7);
  EXPECT_NEAR(a.outliers[0].deviations, 6, 0.8);
  EXPECT_EQ(a.levels[1].readings, 30) << "it is not dropped";
  EXPECT_TRUE(holds(a.ranges[0].sensitivity, 6));
  EXPECT_NEAR(a.ranges[0].robust->slope_fF_per_kPa, 6, 1);
}

TEST(Analyse, ReversedOrderGivesTheSameSlope) {
  SyntheticRun::Static s;
  s.noise_F = 0;
  std::reverse(s.kPa.begin(), s.kPa.end());
  const auto a = of_static(s);
  EXPECT_NEAR(a.ranges[0].sensitivity.value() / 6, 1, 1e-7);
  EXPECT_EQ(a.levels[4].direction, Direction::down);
}

TEST(Analyse, ABentCurveIsCalledBentAndItsSlopeIsThatOfTheTrueCurve) {
  SyntheticRun::Static s;
  s.noise_F = 5e-15;
  s.capacitance_F = [](double kPa) { return 3.65e-12 + (9 * kPa - 0.03 * kPa * kPa) * 1e-15; };
  AnalysisOptions options;
  options.search_regions = true;
  const auto a = of_static(s, options);
  // Levels 40..100: the least-squares slope of a parabola is its derivative in the middle.
  EXPECT_TRUE(holds(a.ranges[1].sensitivity, 9 - 2 * 0.03 * 70));
  EXPECT_LT(*a.ranges[1].lack_of_fit_p, 1e-6);
  EXPECT_THAT(a.ranges[1].residual_pattern, HasSubstr("bent down"));
  // Residuals of a parabola at the ends, of 513 fF: 0.03 (45^2 - 825), and terminal 0.03 45^2.
  EXPECT_NEAR(a.linearity.value(), 7.0, 0.5);
  EXPECT_NEAR(a.linearity_terminal.value(), 11.8, 0.8);
  ASSERT_TRUE(a.regions);
  EXPECT_GT(a.regions->low.sensitivity.value(), a.regions->high.sensitivity.value());
}

TEST(Analyse, AC0ThatJumpsBetweenRepeatsDoesNotWidenTheSlope) {
  SyntheticRun::Static s;
  s.spoil = [](int level, int, double v) { return v + 0.3e-12 * ((level - 1) / 10); };
  const auto a = of_static(s);
  EXPECT_LT(*a.ranges[0].sensitivity.estimate->standard_error, 0.6);
  EXPECT_NEAR(a.ranges[0].sensitivity.value(), 6, 2);
}

TEST(Analyse, SystematicPartsDoNotShrinkWithReadings) {
  SyntheticRun::Static s;
  const auto few = of_static(s);
  s.readings = 120;
  const auto many = of_static(s);
  const auto part = [](const RunAnalysis& a, const std::string& name) {
    for (const auto& p : a.ranges[1].uncertainty.parts) {
      if (p.name == name) return p.standard_uncertainty;
    }
    return -1.0;
  };
  EXPECT_NEAR(part(many, "scatter") / part(few, "scatter"), 0.5, 0.15);
  EXPECT_NEAR(part(many, "force"), 6 * 0.01 / std::sqrt(3), 0.005);
  EXPECT_NEAR(part(many, "force") / part(few, "force"), 1, 0.05);
  EXPECT_EQ(part(many, "meter offset"), 0);
  EXPECT_GT(many.ranges[1].uncertainty.expanded, 2 * part(many, "force"));
}

TEST(Analyse, ALevelInAGapOfTheFrameIsNotUsed) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  s.repeats = 2;
  s.spoil = [&run](int level, int i, double v) {
    if (level == 4 && i == 1) run.lost_frames = 100;  // 2 s
    return std::optional(v);
  };
  run.play(s);
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.notes, Contains(HasSubstr("1 gaps")));
  ASSERT_EQ(a.levels[3].level, 4);
  EXPECT_LE(a.levels[3].readings, 15);
  EXPECT_GE(a.levels[3].missing, 15);
  EXPECT_TRUE(holds(a.ranges[1].sensitivity, 6));
}

TEST(Analyse, WithoutAFrameTheTargetsAreTakenAndSaidSo) {
  SyntheticRun run;
  run.with_frame = false;
  run.begin();
  run.play(SyntheticRun::Static());
  run.end();
  const auto a = analysed(run);
  EXPECT_TRUE(holds(a.ranges[0].sensitivity, 6));
  EXPECT_THAT(a.notes, Contains(HasSubstr("the force that was asked for")));
  EXPECT_FALSE(a.dynamic_range);
  EXPECT_THAT(a.dynamic_range.reason, HasSubstr("no force"));
}

TEST(Analyse, SaysWhatIsWrongWithARunThatCannotBeAnalysed) {
  SyntheticRun run;
  EXPECT_THAT(analyse(run.db(), 7).error().what, HasSubstr("no run 7"));
  const auto open = insert_run(run.db(), run.row);
  EXPECT_THAT(analyse(run.db(), *open).error().what, HasSubstr("was cut off"));
  {
    auto lock = WriterLock::acquire(run.db().path()).value();
    ASSERT_TRUE(lock.begin_run(*open));
    EXPECT_THAT(analyse(run.db(), *open).error().what, HasSubstr("still going on"));
  }
  run.begin();
  run.end(ExitStatus::fail);
  EXPECT_THAT(analyse(run.db(), run.run()).error().what, HasSubstr("no readings"));
  SyntheticRun overloaded;
  overloaded.begin();
  overloaded.reading(std::nullopt, 0);
  overloaded.end();
  EXPECT_THAT(analyse(overloaded.db(), overloaded.run()).error().what, HasSubstr("overloads"));
  SyntheticRun other;
  other.begin();
  other.reading(1e-12, 0);
  other.end();
  ASSERT_TRUE(
      other.db().execute("DROP TRIGGER lcr_reading_no_update;"
                         "UPDATE lcr_reading SET function = 'R-X', capacitance_F = NULL"));
  EXPECT_THAT(analyse(other.db(), other.run()).error().what, HasSubstr("no capacitance"));
  AnalysisOptions backwards;
  backwards.ranges = {{30, 10}};
  EXPECT_THAT(analyse(other.db(), other.run(), backwards).error().what, HasSubstr("30-10 kPa"));
}

TEST(Analyse, GivesThePapersNumbersBack) {
  std::vector<RunAnalysis> runs;
  const double slopes[] = {5.75, 19.3, 23.7};
  for (int i = 0; i < 3; ++i) {
    SyntheticRun::Static s;
    s.seed = static_cast<std::uint64_t>(11 + i);
    s.noise_F = 10e-15;
    const double c0 = 3.65e-12 * (i + 1), slope = slopes[i] * 1e-15;
    s.capacitance_F = [c0, slope](double kPa) { return c0 + slope * kPa; };
    runs.push_back(of_static(s));
    runs.back().run = i + 1;
    EXPECT_TRUE(holds(runs.back().ranges[0].sensitivity, slopes[i]));
  }
  const double expected[] = {235.7, 22.8, 312.2};
  int found = 0;
  for (const Comparison& c : compare(runs)) {
    if (c.quantity != "sensitivity 0-30 kPa") continue;
    const double truth = expected[found++];
    ASSERT_TRUE(c.interval_percent);
    EXPECT_LE((*c.interval_percent)[0], truth + 0.05) << *c.from_value << " " << *c.to_value;
    EXPECT_GE((*c.interval_percent)[1], truth - 0.05);
    EXPECT_NEAR(*c.increase_percent, truth, 4 * *c.standard_error_percent);
  }
  EXPECT_EQ(found, 3);
}

TEST(Analyse, JsonHasTheNamesOfTheDesign) {
  const auto j = to_json(of_static(SyntheticRun::Static()));
  EXPECT_NEAR(j["C0_pF"].get<double>(), 3.65, 0.02);
  EXPECT_TRUE(j["dynamic_range_percent"].is_number());
  EXPECT_TRUE(j.contains("hysteresis_percent"));
  ASSERT_EQ(j["ranges"].size(), 2U);
  const auto& r = j["ranges"][0];
  EXPECT_EQ(r["from_kPa"], 0);
  EXPECT_EQ(r["to_kPa"], 30);
  EXPECT_TRUE(r["sensitivity_fF_per_kPa"].is_number());
  EXPECT_TRUE(r["standard_error"].is_number());
  EXPECT_TRUE(r["r_squared"].is_number());
  EXPECT_LT(r["ci95"][0].get<double>(), r["ci95"][1].get<double>());
}

TEST(LoadRunData, ThinsTheFrameButKeepsItsPeaks) {
  SyntheticRun run;
  run.begin();
  for (int i = 0; i < 2000; ++i) {
    run.reading(3.65e-12, [](double t) { return t > 100 && t < 100.03 ? 1.0 : 0.0; });
  }
  run.end();
  LoadOptions options;
  options.frame_points = 200;
  const auto data = load_run_data(run.db(), run.run(), options);
  ASSERT_TRUE(data) << data.error().what;
  EXPECT_LE(data->frame.size(), 210U);
  EXPECT_NEAR(static_cast<double>(data->frame_samples), 12000, 1);
  const auto peak = std::max_element(
      data->frame.begin(), data->frame.end(),
      [](const FramePoint& a, const FramePoint& b) { return a.force_N < b.force_N; });
  EXPECT_EQ(peak->force_N, 1);
  EXPECT_NEAR(peak->t_s, 100.02, 0.011);
}

}  // namespace
}  // namespace lcrig
