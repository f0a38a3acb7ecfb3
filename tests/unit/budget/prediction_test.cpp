// SPDX-License-Identifier: Apache-2.0
// Compares predictions with sums done by hand.
#include "budget/prediction.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/even_slope.hpp"
#include "analysis/line_fit.hpp"
#include "base/online.hpp"

namespace lcrig {
namespace {

using testing::DoubleNear;
using testing::HasSubstr;

// A straight curve of 2 fF/kPa on 4 pF, a spring of 1 N/mm, a probe of 10 mm2: 1 N is 100 kPa.
PlannedRun straight_run() {
  PlannedRun run;
  run.meter.conversion_s = 0.1;
  run.reading_noise_F = 40e-15;
  run.interval_s = 0.1;
  run.area_m2 = 10e-6;
  run.c0_F = 4e-12;
  run.delta_C_fF = [](double kPa) { return 2 * kPa; };
  run.compression_m = [](double force_N) { return force_N * 1e-3; };
  return run;
}

// Levels of 10, 20, 30 kPa with `readings` each, `repeats` times; one cycle for each repeat.
PlannedRun static_run(double readings, int repeats) {
  PlannedRun run = straight_run();
  for (int r = 0; r < repeats; ++r) {
    for (const double kPa : {10.0, 20.0, 30.0}) run.levels.push_back({kPa, readings});
    PlannedCycle cycle;
    cycle.peak_kPa = 30;
    for (const double kPa : {10.0, 20.0, 30.0}) {
      cycle.rising.push_back({kPa, kPa, readings, readings * run.interval_s});
    }
    run.cycles.push_back(cycle);
    run.rests.push_back({0, 100});
  }
  return run;
}

std::vector<Prediction> predict(const PlannedRun& run) {
  auto out = predict_errors(run);
  EXPECT_TRUE(out) << out.error().what;
  return out ? *out : std::vector<Prediction>();
}

TEST(Budget, SlopeOfThreeLevelsIsTheTextbooks) {
  const auto p = predict(static_run(16, 1));
  // Each mean: 40/4 = 10 fF; sum (x - 20)^2 = 200 kPa2; 10/sqrt(200).
  EXPECT_EQ(p[0].quantity, "sensitivity 0-30 kPa");
  EXPECT_THAT(p[0].value, DoubleNear(2, 1e-12));
  EXPECT_THAT(p[0].standard_error, DoubleNear(10 / std::sqrt(200), 1e-12));
}

// Each level comes 5 s after one that is 10 kPa lower. An error of the drift's rate therefore
// changes the slope by half of it, in all repeats alike.
TEST(Budget, SlopeHasTheErrorOfTheDriftThatIsSubtracted) {
  PlannedRun run = static_run(1600, 4);
  for (std::size_t i = 0; i < run.levels.size(); ++i) {
    const auto repeat = static_cast<double>(i / 3), level = static_cast<double>(i % 3);
    run.levels[i].t_s = 100 + 40 * repeat + 5 * level;
    run.levels[i].repeat = static_cast<int>(i / 3) + 1;
  }
  for (std::size_t k = 0; k < run.rests.size(); ++k) {
    run.rests[k] = {80 + 40 * static_cast<double>(k), 100};
  }
  const Prediction p = predict(run)[0];
  const double own = 1 / std::sqrt(4 * 200.0);
  const double rate_fF_s = 40 / std::sqrt(100 * (60 * 60 + 20 * 20) * 2.0);
  EXPECT_THAT(p.standard_error, DoubleNear(std::hypot(own, 0.5 * rate_fF_s), 1e-12));
  // The drift's error is known, so the interval is narrower than if repeats had to determine it.
  EXPECT_LT(p.half_width, p.standard_error * coverage_factor(0.95, 3));
  EXPECT_GT(p.half_width, 1.96 * p.standard_error);
  EXPECT_GE(p.uncertainty.expanded, p.half_width);
  run.rests.resize(1);
  EXPECT_THAT(predict(run)[0].standard_error, DoubleNear(own, 1e-12)) << "nothing is subtracted";
}

TEST(Budget, RepeatsAndReadingsShrinkItByTheirRoot) {
  const double once = predict(static_run(16, 1))[0].standard_error;
  EXPECT_THAT(predict(static_run(16, 9))[0].standard_error, DoubleNear(once / 3, 1e-12));
  EXPECT_THAT(predict(static_run(64, 1))[0].standard_error, DoubleNear(once / 2, 1e-12));
}

TEST(Budget, NoiseOfTheForceCounts) {
  PlannedRun run = static_run(16, 1);
  run.reading_noise_F = 1e-20;
  run.force_noise_N = 0.003;  // 0.3 kPa; times sqrt(2/3) and 2 fF/kPa, over 4 and sqrt(200)
  const auto p = predict(run);
  const double expected = 2 * 0.3 * std::sqrt(2.0 / 3) / 4 / std::sqrt(200);
  EXPECT_THAT(p[0].standard_error, DoubleNear(expected, 1e-9));
  EXPECT_EQ(p[0].uncertainty.parts[1].name, "scatter of the force");
}

TEST(Budget, DynamicRangeOfPlateaus) {
  // The peak has 25 readings in 2.5 s and the rest 100: variance 1600 (1/25 + 1/100) fF2 for each
  // of 4 cycles. The first rest also determines C0, so its quarter grows by the range, 60 fF of
  // 4000.
  const auto p = predict(static_run(25, 4));
  const Prediction& range = p.back();
  ASSERT_EQ(range.quantity, "dynamic range");
  EXPECT_THAT(range.value, DoubleNear(60.0 / 4000 * 100, 1e-12));
  const double first = 0.25 + 60.0 / 4000;
  const double variance = 1600 * (1 / 25.0 / 4 + (first * first + 3 * 0.25 * 0.25) / 100);
  EXPECT_THAT(range.standard_error, DoubleNear(std::sqrt(variance) / 4000 * 100, 1e-12));
}

// Two rests of 100 readings, with a peak halfway between them. Half of the second rest's error
// counts as drift, and the first rest counts half.
TEST(Budget, WhatTheRestsErrByIsTakenForDrift) {
  PlannedRun run = static_run(25, 1);
  run.cycles[0].peak_s = 50;
  run.rests = {{0, 100}, {100, 100}};
  run.delta_C_fF = [](double kPa) { return 1e-9 * kPa; };  // so that C0 hardly counts
  const double variance = 1600 * (1 / 25.0 + (0.5 * 0.5 + 0.5 * 0.5) / 100);
  EXPECT_THAT(predict(run).back().standard_error,
              DoubleNear(std::sqrt(variance) / 4000 * 100, 1e-9));
}

// As in the analysis: if a level has ten readings, those of the hold before it do not count.
TEST(Budget, APlateauIsThatOfItsLevel) {
  PlannedRun run = static_run(25, 1);
  run.cycles[0].rising.back().is_level = true;
  const double alone = predict(run).back().standard_error;
  run.cycles[0].rising.push_back({30, 30, 100, 10});
  EXPECT_THAT(predict(run).back().standard_error, DoubleNear(alone, 1e-12));
  run.cycles[0].rising[2].is_level = false;
  EXPECT_LT(predict(run).back().standard_error, alone);
}

// The analysis takes no mean of fewer than ten readings. The value of a fit is less certain.
TEST(Budget, AShortPlateauIsFitted) {
  const double fitted = predict(static_run(9, 1)).back().standard_error;
  const double mean = predict(static_run(10, 1)).back().standard_error;
  // The upper half has two forces, too few for slope and bend: this is as good as one reading.
  EXPECT_GT(fitted, 2 * mean);
}

TEST(Budget, SlopeOfAContinuousLoading) {
  // 0.1 mm in 10 s, or 10 kPa/s: a reading every kPa, from 5 kPa (a twentieth of the peak) to 30.
  PlannedRun run = straight_run();
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 10;
  run.cycles = {cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}};
  const auto p = predict(run);
  double sxx = 0;  // 25 equidistant pressures
  for (int i = 0; i < 25; ++i) sxx += (i - 12) * (i - 12);
  EXPECT_THAT(p[0].standard_error, DoubleNear(40 / std::sqrt(2 * sxx), 1e-6));
  EXPECT_THAT(p[0].value, DoubleNear(2, 1e-9));
}

TEST(Budget, FewerReadingsUnderLoadMakeTheRangeWorse) {
  PlannedRun run = straight_run();
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 1;
  run.cycles = {cycle};
  run.rests = {{0, 1000}};
  const double quick = predict(run).back().standard_error;
  run.cycles[0].loading_s = run.cycles[0].falling_s = 10;
  const double slow = predict(run).back().standard_error;
  EXPECT_GT(quick, 2.2 * slow);  // the root of ten times the readings, less two more parameters
  EXPECT_LT(slow, 1.0 / 40 * 40);  // better than one reading: 1 %
}

// At 10 kPa/s the nearest sample of 50 Hz is up to 10 ms, or 0.1 kPa, from the turn.
TEST(Budget, WhichSampleIsTheHighestIsChance) {
  PlannedRun run = straight_run();
  run.reading_noise_F = 1e-20;
  run.sample_s = 0.02;
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 10;
  run.cycles = {cycle, cycle, cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}, {0, 1000}, {0, 1000}};
  const Prediction turned = predict(run).back();
  const double fF = 2 * 0.1 / std::sqrt(12.0) / std::sqrt(4.0);
  EXPECT_THAT(turned.standard_error, DoubleNear(fF / 4000 * 100, 1e-6));
  EXPECT_EQ(turned.uncertainty.parts[2].name, "instants of the readings");
  for (PlannedCycle& c : run.cycles) c.rising.push_back({100, 100, 50, 5});  // held there
  EXPECT_LT(predict(run).back().standard_error, 0.01 * turned.standard_error);
}

// The bend that all loadings share is taken out. A curve of higher order gives readings at other
// pressures another slope.
TEST(Budget, WhereTheReadingsFallIsChance) {
  PlannedRun run = straight_run();
  run.reading_noise_F = 1e-20;
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 1.5;
  run.cycles = {cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}};
  run.delta_C_fF = [](double kPa) { return 2 * kPa - 0.01 * kPa * kPa; };
  EXPECT_LT(predict(run)[0].standard_error, 1e-6);
  run.delta_C_fF = [](double kPa) { return 40 * std::cbrt(kPa); };
  EXPECT_GT(predict(run)[0].relative(), 0.001);
}

// Each value is found 2 ms later than the one before, up to 20 ms, while the pressure grows by 50
// kPa/s. The prediction is compared with many pairs of loadings.
TEST(Budget, ValuesThatAreFoundLaterAndLaterMakeTheSlopesScatter) {
  PlannedRun run = straight_run();
  run.reading_noise_F = 1e-20;
  run.later_s = 0.002;
  run.earlier_s = 0.02;
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 2;
  run.cycles = {cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}};
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  RunningMean means;
  for (int k = 0; k < 5000; ++k) {
    EvenSlopes slopes(35, 100);
    for (int loading = 0; loading < 2; ++loading) {
      double t_s = 0.1 * part(random), late_s = 0.02 * part(random);
      std::vector<LinePoint> points;
      // A window that ends after the peak is left out.
      for (; t_s < 1.95; t_s += 0.1, late_s += late_s + 0.002 < 0.02 ? 0.002 : -0.018) {
        if (50 * t_s > 35) points.push_back({50 * t_s, 2 * 50 * (t_s - late_s), 1});
      }
      slopes.add(points);
    }
    RunningMean mean;
    for (const LineFit& l : slopes.lines()) mean.add(l.slope);
    means.add(mean.mean);
  }
  EXPECT_NEAR(predict(run)[1].standard_error / std::sqrt(means.variance()), 1, 0.25);
}

TEST(Budget, SystematicPartsDoNotShrink) {
  const auto few = predict(static_run(16, 1)), many = predict(static_run(1600, 100));
  ASSERT_EQ(few[0].uncertainty.parts.size(), many[0].uncertainty.parts.size());
  for (std::size_t i = 0; i < few[0].uncertainty.parts.size(); ++i) {
    const UncertaintyPart& a = few[0].uncertainty.parts[i];
    const UncertaintyPart& b = many[0].uncertainty.parts[i];
    if (a.shrinks) {
      EXPECT_LE(b.standard_uncertainty, a.standard_uncertainty / 99);
    } else {
      EXPECT_DOUBLE_EQ(b.standard_uncertainty, a.standard_uncertainty) << a.name;
    }
  }
  EXPECT_EQ(few[0].uncertainty.dominating()->name, "scatter of the readings");
  EXPECT_FALSE(many[0].uncertainty.dominating()->shrinks);
}

const UncertaintyPart* part_in(const Prediction& p, const std::string& name) {
  const auto it = std::ranges::find(p.uncertainty.parts, name, &UncertaintyPart::name);
  return it == p.uncertainty.parts.end() ? nullptr : &*it;
}

TEST(Budget, HasTheCorrectionsOfTheMeterAsTheAnalysisHas) {
  const PlannedRun run = static_run(16, 2);
  const auto unknown = predict(run);
  EXPECT_THAT(unknown[0].uncertainty.gaps(), testing::Contains("short correction"));
  EXPECT_THAT(unknown.back().uncertainty.gaps(), testing::Contains("open correction"));
  EXPECT_THAT(part_in(unknown.back(), "open correction")->basis, HasSubstr("will be on"));
  AnalysisOptions options;
  options.rig.stray_limit_fF = 200;
  const auto stated = predict_errors(run, options).value();
  const UncertaintyPart* open = part_in(stated.back(), "open correction");
  ASSERT_TRUE(open != nullptr);
  EXPECT_FALSE(open->is_gap);
  // 200 of 4000 fF: five percent of the dynamic range.
  EXPECT_NEAR(open->standard_uncertainty, 0.05 * stated.back().value / std::sqrt(3), 1e-12);
  EXPECT_GE(stated.back().uncertainty.combined, open->standard_uncertainty);
}

TEST(Budget, ForceClassIsRectangular) {
  PlannedRun run = static_run(16, 1);
  AnalysisOptions options;
  options.rig.force_class_percent = 0.5;
  const auto p = predict_errors(run, options);
  ASSERT_TRUE(p);
  for (const UncertaintyPart& part : (*p)[0].uncertainty.parts) {
    if (part.name != "force") continue;
    EXPECT_THAT(part.standard_uncertainty, DoubleNear(2 * 0.005 / std::sqrt(3), 1e-12));
    return;
  }
  FAIL() << "no part for the force";
}

// Averages over many sets of normal deviates of given size. The expectation must be the mean of
// Student's t times their standard deviation.
TEST(Budget, HalfWidthIsWhatTheSlopesOfRepeatsGiveInTheMean) {
  std::mt19937_64 random(3);
  for (const int repeats : {2, 3, 4, 8}) {
    std::chi_squared_distribution<double> squares(repeats - 1);
    double sum = 0;
    for (int i = 0; i < 20'000; ++i) sum += std::sqrt(squares(random) / (repeats - 1));
    const double expected = coverage_factor(0.95, repeats - 1) * sum / 20'000;
    PlannedRun run = static_run(16, repeats);
    for (std::size_t i = 0; i < run.levels.size(); ++i) {
      run.levels[i].repeat = static_cast<int>(i / 3) + 1;
    }
    const Prediction p = predict(run)[0];
    EXPECT_NEAR(p.half_width / p.standard_error / expected, 1, 0.02) << repeats;
  }
  const Prediction once = predict(static_run(16, 1))[0];
  EXPECT_NEAR(once.half_width / once.standard_error, 1.96, 0.001);
}

TEST(Budget, OnePressureHasNoSlope) {
  PlannedRun run = straight_run();
  run.levels = {{10, 30}, {10, 30}};
  const auto p = predict(run);
  EXPECT_THAT(p[0].reason, HasSubstr("two different pressures"));
  EXPECT_THAT(p[1].reason, HasSubstr("two different pressures"));
  EXPECT_THAT(p[2].reason, HasSubstr("never loads"));
}

TEST(Budget, MissingFactsAreRefused) {
  PlannedRun run = static_run(16, 1);
  run.area_m2 = 0;
  EXPECT_FALSE(predict_errors(run));
  run = static_run(16, 1);
  run.reading_noise_F = 0;
  EXPECT_FALSE(predict_errors(run));
}

// The frame moves at constant speed and the specimen stiffens, so the rate of pressure grows.
TEST(Budget, CyclesHaveThePartsThatTheAnalysisHas) {
  PlannedRun run = straight_run();
  run.reading_noise_F = 1e-20;
  run.compression_m = [](double force_N) { return 1e-3 * std::sqrt(force_N); };
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 10;
  run.cycles = {cycle, cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}, {0, 1000}};
  const auto p = predict(run);
  const auto part = [](const Prediction& of, const std::string& name) {
    for (const UncertaintyPart& x : of.uncertainty.parts) {
      if (x.name == name) return x.standard_uncertainty;
    }
    return -1.0;
  };
  // P = (t/s)^2 kPa: the rate is 2 t = 2 sqrt(P) kPa/s. From 35 to 100 kPa it grows by 1/sqrt(P).
  const double tilt_per_s = (20 - 2 * std::sqrt(35)) / 65, instant_s = 0.1 / std::sqrt(12);
  EXPECT_NEAR(part(p[1], "alignment of the clocks"), 2 * tilt_per_s * instant_s, 2e-4);
  EXPECT_NEAR(part(p[2], "turn within a window"), 2 * 20 * 0.1 / 12 / 4000 * 100, 1e-4);
}

// The force grows evenly and the curve bends: 10 kPa/s times the change of the slope.
TEST(Budget, TheInstantMovesTheSlopeOfABentCurve) {
  PlannedRun run = straight_run();
  run.reading_noise_F = 1e-20;
  run.compression_m = [](double force_N) { return 1e-3 * force_N; };
  run.delta_C_fF = [](double kPa) { return 6 * kPa - 0.02 * kPa * kPa; };
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 10;
  run.cycles = {cycle, cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}, {0, 1000}};
  const auto p = predict(run);
  const auto& parts = p[1].uncertainty.parts;
  const auto found = std::ranges::find(parts, "alignment of the clocks", &UncertaintyPart::name);
  ASSERT_NE(found, parts.end());
  EXPECT_NEAR(found->standard_uncertainty, 0.04 * 10 * 0.1 / std::sqrt(12), 2e-4);
}

TEST(Budget, TheWholeIsNoSmallerThanTheInterval) {
  const auto p = predict(static_run(16, 1));
  EXPECT_EQ(p[0].repeats, 1);
  PlannedRun run = straight_run();
  PlannedCycle cycle;
  cycle.peak_kPa = 100;
  cycle.loading_s = cycle.falling_s = 10;
  run.cycles = {cycle, cycle};
  run.rests = {{0, 1000}, {0, 1000}};
  for (const Prediction& two : predict(run)) {
    EXPECT_EQ(two.repeats, 2);
    EXPECT_GE(two.uncertainty.expanded, two.half_width);
  }
}

}  // namespace
}  // namespace lcrig
