// SPDX-License-Identifier: Apache-2.0
// Repeats that differ, drift, garbage and bad input: an interval must hold, or say that it cannot.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "analysis/analysis_text.hpp"
#include "analysis/correlation.hpp"
#include "analysis/drift.hpp"
#include "analysis/metrics.hpp"
#include "tests/unit/analysis/analysed.hpp"
#include "tests/unit/analysis/disturbed_run.hpp"

namespace lcrig {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

double half_width(const Metric& m) {
  return ((*m.estimate->interval)[1] - (*m.estimate->interval)[0]) / 2;
}

TEST(Honest, SlopesThatDifferAreTheSample) {
  SyntheticRun::Static s;
  s.noise_F = 0.1e-15;
  const double factors[] = {0.98, 1.01, 0.99, 1.02};
  s.spoil = [&](int level, int, double v) {
    return 3.65e-12 + (v - 3.65e-12) * factors[(level - 1) / 10];
  };
  const auto a = of_static(s);
  const double deviation = 6 * std::sqrt((4 + 1 + 1 + 4) * 1e-4 / 3);
  for (const RangeResult& r : a.ranges) {
    EXPECT_NEAR(*r.sensitivity.estimate->standard_error, deviation / 2, 0.01 * deviation);
    EXPECT_EQ(*r.sensitivity.estimate->degrees_of_freedom, 3);
    EXPECT_THAT(r.scatter_basis, HasSubstr("slopes of 4 repeats"));
    EXPECT_THAT(r.sensitivity.reason, HasSubstr("differ more than the readings scatter"));
    EXPECT_GE(r.uncertainty.expanded, half_width(r.sensitivity));
  }
}

// Levels that scatter although the slopes are equal say nothing about how well the slope is known.
TEST(Honest, RepeatsAreTheSampleHoweverMuchTheirLevelsScatter) {
  const double beside_line[] = {0, 0, 0, 1, 0, 0, -2, 0, 0, 1};  // from the line at 10 to 100 kPa
  for (const int repeats : {2, 3, 4}) {
    SyntheticRun::Static s;
    s.repeats = repeats;
    s.noise_F = 0.1e-15;
    s.spoil = [&](int level, int, double v) {
      const double sign = (level - 1) / 10 % 2 == 0 ? 1 : -1;
      return v + sign * 20e-15 * beside_line[(level - 1) % 10];
    };
    const auto a = of_static(s);
    EXPECT_EQ(a.ranges[1].parts_of_error[0].degrees_of_freedom, repeats - 1);
    EXPECT_LT(a.ranges[1].parts_of_error[0].se, 0.01) << repeats;
  }
}

TEST(Honest, OneRepeatSaysWhatItCannotKnow) {
  SyntheticRun::Static s;
  s.repeats = 1;
  const auto a = of_static(s);
  EXPECT_THAT(a.ranges[0].sensitivity.reason, HasSubstr("one repeat"));
  EXPECT_TRUE(holds(a.ranges[0].sensitivity, 6));
}

// The noise of the load cell is white and adds to that of the capacitance as such, even where the
// latter is correlated. With these sizes it makes the standard error 1.15 times as large.
TEST(Honest, TheForceOfOneRepeatScattersWithItsOwnCorrelation) {
  Disturbed quiet;
  quiet.correlation = 0.8;
  quiet.slopes = {1};
  Disturbed noisy = quiet;
  noisy.force_noise_N = 1e-3;
  double without_it = 0, with_it = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto error = [seed](const Disturbed& d) {
      const auto a = analyse(DisturbedRun(d, 5'200'000 + seed).data).value();
      return *a.ranges[1].sensitivity.estimate->standard_error;
    };
    without_it += error(quiet), with_it += error(noisy);
  }
  EXPECT_GT(with_it, 1.05 * without_it);
  EXPECT_LT(with_it, 1.3 * without_it);
}

TEST(Honest, ADriftIsSubtractedAndItsErrorStays) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  s.noise_F = 1e-15;
  s.capacitance_F = [&run](double kPa) {
    return 3.65e-12 + 6e-15 * kPa + 500e-15 / 3600 * run.t_s;
  };
  run.play(s);
  run.end();
  const auto a = analysed(run);
  EXPECT_TRUE(holds(a.drift, 500));
  for (const RangeResult& r : a.ranges) {
    EXPECT_NEAR(r.sensitivity.value(), 6, 4 * *r.sensitivity.estimate->standard_error);
    EXPECT_LT(*r.sensitivity.estimate->standard_error, 0.05);
    EXPECT_GT(r.parts_of_error[1].se, 0);
  }
  EXPECT_GT(a.levels.back().drift_fF, 20);
}

TEST(Honest, GarbageDoesNotPassWithoutAWord) {
  SyntheticRun::Static s;
  s.spoil = [](int level, int i, double v) {
    return (level == 3 || level == 12) && i == 5 ? 9.9e-9 : v;
  };
  const auto a = of_static(s);
  const RangeResult& low = a.ranges[0];
  EXPECT_GT(std::abs(low.sensitivity.value() - 6), 100);
  EXPECT_THAT(low.sensitivity.reason, HasSubstr("2 outliers among its readings move it"));
  EXPECT_NEAR(low.robust->slope_fF_per_kPa, 6, 4 * low.robust->standard_error);
  EXPECT_LT(low.robust->standard_error, 1);
  EXPECT_GE(low.robust->down_weighted, 2);
  EXPECT_EQ(a.outlier_count, 2);
}

TEST(Honest, RobustAndPlainEstimateTheSame) {
  SyntheticRun::Static s;
  s.noise_F = 5e-15;
  s.capacitance_F = [](double kPa) { return 3.65e-12 + (9 * kPa - 0.03 * kPa * kPa) * 1e-15; };
  const auto a = of_static(s);
  for (const RangeResult& r : a.ranges) {
    EXPECT_NEAR(r.robust->slope_fF_per_kPa, r.sensitivity.value(),
                *r.sensitivity.estimate->standard_error);
  }
}

TEST(Honest, OutliersOfTheBaselineAreListed) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  int n = 0;
  s.capacitance_F = [&n](double kPa) { return 3.65e-12 + 6e-15 * kPa + (++n == 50 ? 5e-12 : 0); };
  run.play(s);
  run.end();
  const auto a = analysed(run);
  ASSERT_EQ(a.outlier_count, 1);
  EXPECT_EQ(a.outliers[0].level, 0);
}

// The share is one run in a hundred, however few readings a level has. Few readings scatter less
// about their own median than about the true value, and few tell their scatter badly.
TEST(Honest, FewReadingsOfALevelAreNoOutliers) {
  struct Case {
    int readings, levels;
  };
  for (const Case c : {Case{4, 3}, Case{4, 10}, Case{5, 5}, Case{10, 5}}) {
    int with = 0;
    SyntheticRun::Static s;
    s.readings = c.readings;
    s.kPa.resize(static_cast<std::size_t>(c.levels));
    s.repeats = 1;
    s.baseline = 20;
    for (s.seed = 1; s.seed <= 30; ++s.seed) {
      const auto a = of_static(s);
      with += std::ranges::any_of(a.outliers, [](const Outlier& o) { return o.level > 0; }) ? 1 : 0;
    }
    EXPECT_LE(with, 3) << c.readings << " readings of " << c.levels << " levels";
  }
}

TEST(Honest, AnOutlierOfAFewReadingsIsListed) {
  SyntheticRun::Static s;
  s.readings = 5;
  s.spoil = [&s](int level, int reading, double v) {
    return std::optional(level == 4 && reading == 2 ? s.capacitance_F(40) + 400e-15 : v);
  };
  const auto a = of_static(s);
  ASSERT_EQ(a.outlier_count, 1);
  EXPECT_EQ(a.outliers[0].level, 4);
  EXPECT_NEAR(a.outliers[0].deviations, 400 / 44.0, 3);
}

TEST(Honest, FlaggedReadingsAreLeftOut) {
  SyntheticRun run;
  run.begin();
  SyntheticRun::Static s;
  s.spoil = [&run](int, int i, double v) {
    run.flags = i == 3 ? 4 : 0;  // after_resync
    return i == 3 ? v + 1e-12 : v;
  };
  run.play(s);
  run.end();
  const auto a = analysed(run);
  EXPECT_EQ(a.levels[0].readings, 29);
  EXPECT_TRUE(holds(a.ranges[1].sensitivity, 6));
  EXPECT_THAT(a.notes, Contains(HasSubstr("40 readings are flagged")));
}

TEST(Honest, ARangeChangesNothingThatItDoesNotName) {
  AnalysisOptions other;
  other.ranges = {{50, 80}};
  const auto usual = to_json(of_static(SyntheticRun::Static()));
  const auto asked = to_json(of_static(SyntheticRun::Static(), other));
  EXPECT_EQ(usual["metrics"].dump(), asked["metrics"].dump());
  const auto rest = [](const nlohmann::json& j) {
    std::string out;
    for (const auto& b : j["uncertainty"]) {
      if (!b["quantity"].get<std::string>().starts_with("sensitivity")) out += b.dump();
    }
    return out;
  };
  EXPECT_EQ(rest(usual), rest(asked));
}

TEST(Honest, ConstantAndNegativeReadingsGetARemark) {
  SyntheticRun::Static s;
  s.noise_F = 0;
  s.capacitance_F = [](double) { return -1e-12; };
  const auto a = of_static(s);
  EXPECT_THAT(a.notes, Contains(HasSubstr("all readings are alike")));
  EXPECT_THAT(a.notes, Contains(HasSubstr("negative capacitance")));
  EXPECT_THAT(a.ranges[0].sensitivity.reason, HasSubstr("nothing scatters"));
  EXPECT_FALSE(a.ranges[0].r_squared);
  EXPECT_FALSE(a.limit_of_detection);
}

TEST(Honest, NoResultIsNotANumber) {
  for (const double c0 : {0.0, 3.65e-12}) {
    SyntheticRun::Static s;
    s.noise_F = 0;
    s.repeats = 1;
    s.capacitance_F = [c0](double kPa) { return c0 + 0 * kPa; };
    const std::string text = to_text(of_static(s));
    EXPECT_THAT(text, Not(HasSubstr("nan")));
    EXPECT_THAT(text, Not(HasSubstr("inf fF")));
  }
}

TEST(Honest, ARunThatNeverUnloadsSaysThatItKnowsNoDrift) {
  SyntheticRun run;
  run.begin();
  const double force = 20e3 * SyntheticRun::area_m2();
  for (int level = 1; level <= 3; ++level) {
    run.level(1, level, 20.0 * level, 10);
    for (int i = 0; i < 10; ++i) {
      run.reading(3.65e-12 + level * 1e-13 + (i % 2) * 1e-15, force * level);
    }
    run.end_level();
  }
  run.end();
  const auto a = analysed(run);
  EXPECT_THAT(a.notes, Contains(HasSubstr("no two stretches without load")));
  EXPECT_FALSE(a.drift);
}

TEST(Honest, ABaselineOfThreeReadingsGivesAnInterval) {
  SyntheticRun::Static s;
  s.baseline = 3;
  const auto a = of_static(s);
  ASSERT_TRUE(a.c0);
  EXPECT_TRUE(a.ranges[0].sensitivity);
}

// Two readings of a hundred are 40 fF off. The noise is that of the others, and holds as often.
TEST(Honest, OutliersAreNotInTheNoise) {
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SyntheticRun::Static s;
    s.noise_F = 0.44e-15;
    s.seed = seed;
    s.repeats = 1;
    s.kPa = {10, 20};
    s.readings = 3;
    int n = 0;
    s.capacitance_F = [&n](double kPa) {
      ++n;
      const double off_F = n == 30 ? 40e-15 : n == 70 ? -40e-15 : 0;
      return 3.65e-12 + 6e-15 * kPa + off_F;
    };
    const auto a = of_static(s);
    EXPECT_NEAR(a.noise.value(), 0.44, 0.15) << seed;
    held += holds(a.noise, 0.44) ? 1 : 0;
  }
  EXPECT_GE(held, 34);
}

// A baseline of a minute with this noise, and a few levels.
RunAnalysis with_noise_of(const std::function<double()>& noise_fF, int baseline = 500) {
  SyntheticRun::Static s;
  s.noise_F = 0;
  s.repeats = 1;
  s.kPa = {10, 20};
  s.baseline = baseline;
  s.capacitance_F = [&](double kPa) { return 3.65e-12 + 6e-15 * kPa + noise_fF() * 1e-15; };
  return of_static(s);
}

// First-order processes: neighbours differ by less than two independent readings do.
TEST(Honest, NoiseOfReadingsThatAreCorrelatedIsThatOfOneReading) {
  for (const double rho : {0.5, 0.9}) {
    int held = 0;
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal;
      double now = normal(random);
      const auto a = with_noise_of([&] {
        now = rho * now + std::sqrt(1 - rho * rho) * normal(random);
        return 0.44 * now;
      });
      held += holds(a.noise, 0.44) ? 1 : 0;
      sum += a.noise.value();
      EXPECT_THAT(a.noise.reason, HasSubstr("neighbouring readings are correlated"));
      EXPECT_THAT(a.limit_of_detection.reason, HasSubstr("its noise: neighbouring readings are"));
    }
    EXPECT_GE(held, 26) << rho;
    EXPECT_NEAR(sum / 30, 0.44, 0.03) << rho;
  }
}

TEST(Honest, AWalkIsNoCorrelationOfTheNoise) {
  int held = 0, told = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    double walk = 0;
    const auto a =
        with_noise_of([&] { return (walk += 0.05 * normal(random)) + 0.44 * normal(random); });
    held += holds(a.noise, 0.44) ? 1 : 0;
    told += a.noise.reason == "there is noise slower than a reading, which is not in it" ? 1 : 0;
  }
  EXPECT_GE(held, 26);
  EXPECT_GE(told, 28);
}

TEST(Honest, NoiseThatIsWhiteHasNoRemark) {
  int held = 0, told = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto a = with_noise_of([&] { return 0.44 * normal(random); });
    held += holds(a.noise, 0.44) ? 1 : 0;
    told += a.noise.reason.empty() ? 0 : 1;
    const auto& i = *a.noise.estimate->interval;
    EXPECT_NEAR((i[1] - i[0]) / 2 / a.noise.value(), 1.96 * std::sqrt(1.5 / 2 / 499), 0.006);
  }
  EXPECT_GE(held, 26);
  EXPECT_LE(told, 1);
}

// Within levels the scatter about the mean is smaller than the noise of a reading.
TEST(Honest, NoiseWithoutABaselineKnowsTheCorrelation) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double now = 0;
  SyntheticRun::Static s;
  s.noise_F = 0;
  s.baseline = 3;
  s.capacitance_F = [&](double kPa) {
    now = 0.8 * now + 0.6 * normal(random);
    return 3.65e-12 + 6e-15 * kPa + 0.44e-15 * now;
  };
  const auto a = of_static(s);
  EXPECT_NEAR(a.noise.value(), 0.44, 0.04);
  EXPECT_TRUE(holds(a.noise, 0.44));
  EXPECT_THAT(a.noise.reason, HasSubstr("correlated"));
}

TEST(Honest, NoiseWithoutABaselineIsThatOfLevelsWithoutOutliers) {
  SyntheticRun::Static s;
  s.noise_F = 0.44e-15;
  s.baseline = 3;
  s.spoil = [](int level, int reading, double v) {
    return std::optional(level == 4 && reading == 7 ? v + 40e-15 : v);
  };
  const auto a = of_static(s);
  EXPECT_EQ(a.outlier_count, 1);
  EXPECT_NEAR(a.noise.value(), 0.44, 0.03);
}

// The slopes of the repeats differ: all levels move alike, and four repeats tell three numbers.
TEST(Honest, RepeatabilityOfLevelsThatMoveAlike) {
  int held = 0, wide = 0;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    double factor[4];
    for (double& f : factor) f = 1 + 0.02 * normal(random);
    SyntheticRun::Static s;
    s.noise_F = 0.44e-15;
    s.readings = 3;
    s.seed = seed;
    s.spoil = [&factor](int level, int, double v) {
      return std::optional(3.65e-12 + (v - 3.65e-12) * factor[(level - 1) / 10]);
    };
    const auto a = of_static(s);
    const Estimate& e = *a.repeatability_2sigma.estimate;
    // Root mean square of 60 to 600 fF, 2 %, over the span of 540 fF.
    const double truth = 2 * 0.02 * 60 * std::sqrt(385 / 10.0) / 540 * 100;
    held += holds(a.repeatability_2sigma, truth) ? 1 : 0;
    wide += *e.degrees_of_freedom < 5 ? 1 : 0;
  }
  EXPECT_GE(held, 51) << "of 60: 99.9 % limit of 95 %";
  EXPECT_GE(wide, 55);
}

TEST(Honest, RepeatabilityOfLevelsThatScatterOnTheirOwnIsKnownBetter) {
  double freedom = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SyntheticRun::Static s;
    s.readings = 3;
    s.seed = seed;
    freedom += *of_static(s).repeatability_2sigma.estimate->degrees_of_freedom / 20;
  }
  EXPECT_GT(freedom, 5) << "of 9 that three differences of repeats can tell";
}

TEST(Honest, TheIntervalOfAStandardDeviationIsThatOfChiSquare) {
  const Estimate e = estimate_of_deviation(1, 3, 0.95);
  EXPECT_NEAR((*e.interval)[0], 0.5665, 1e-3);
  EXPECT_NEAR((*e.interval)[1], 3.7287, 1e-3);
  SyntheticRun::Static s;
  AnalysisOptions options;
  options.confidence = 0.8;
  const auto a = of_static(s, options);
  const double freedom = *a.noise.estimate->degrees_of_freedom;
  const auto ci95 = *estimate_of_deviation(a.noise.value(), freedom, 0.95).interval;
  EXPECT_NEAR(to_json(a)["metrics"]["noise_fF"]["ci95"][1], ci95[1], 1e-9);
}

TEST(Honest, TouchesOfASearchAreNotPartOfTheBaseline) {
  SyntheticRun::Static s;
  s.noise_F = 0.44e-15;
  s.touches = 3;
  const auto a = of_static(s);
  EXPECT_NEAR(a.noise.value(), 0.44, 0.1);
  EXPECT_NEAR(a.c0.value() * 1e3, 3650, 0.2);
  EXPECT_EQ(a.outlier_count, 0);
}

// C0 moves between repeats, and one repeat has no readings, or half of them, at some level.
TEST(Honest, AMissingLevelDoesNotTurnTheSlope) {
  SyntheticRun::Static s;
  s.noise_F = 0.44e-15;
  for (const int kept : {0, 15}) {
    s.spoil = [kept](int level, int reading, double v) -> std::optional<double> {
      const double offset_fF[] = {20, -20, 10, -10};
      if (level == 13 && reading > kept) return std::nullopt;
      return v + offset_fF[(level - 1) / 10] * 1e-15;
    };
    const auto a = of_static(s);
    const Metric& slope = a.ranges[0].sensitivity;
    EXPECT_NEAR(slope.value(), 6, 0.03) << kept;
    EXPECT_TRUE(holds(slope, 6)) << kept;
    EXPECT_LT(*slope.estimate->standard_error, 0.02) << kept;
    ASSERT_TRUE(a.ranges[0].robust);
    EXPECT_NEAR(a.ranges[0].robust->slope_fF_per_kPa, 6, 0.03) << kept;
  }
}

// The slope of a bent curve depends on the pressures. This is not a difference between repeats.
TEST(Honest, AMissingLevelOfABentCurveDoesNotWidenTheInterval) {
  SyntheticRun::Static s;
  s.noise_F = 0.44e-15;
  s.capacitance_F = [](double kPa) { return 3.65e-12 + 8e-15 * kPa - 0.04e-15 * kPa * kPa; };
  const auto whole = of_static(s);
  s.spoil = [](int level, int, double v) { return level == 13 ? std::nullopt : std::optional(v); };
  const auto lacking = of_static(s);
  const auto error = [](const RunAnalysis& a) {
    return *a.ranges[0].sensitivity.estimate->standard_error;
  };
  EXPECT_LT(error(lacking), 3 * error(whole));
  EXPECT_NEAR(lacking.ranges[0].sensitivity.value(), whole.ranges[0].sensitivity.value(), 0.1);
}

TEST(Correlation, IsFoundInShortStretchesWithMeansOfTheirOwn) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (const double rho : {0.0, 0.5, 0.8}) {
    for (const bool trend : {false, true}) {
      std::vector<EvenStretch> stretches(40);
      for (EvenStretch& s : stretches) {
        s.trend = trend;
        double y = normal(random);
        for (int i = 0; i < 20; ++i) {
          s.add(100 + y + (trend ? 0.3 * i : 0));
          y = rho * y + std::sqrt(1 - rho * rho) * normal(random);
        }
      }
      const Correlation c = fit_correlation(stretches);
      EXPECT_NEAR(c.rho, rho, 0.1) << trend;
      EXPECT_NEAR(c.variance, 1, 0.35) << trend;
    }
  }
}

TEST(Drift, FollowsWhatExceedsTheNoiseOfTheRestsOnly) {
  std::vector<RestNode> nodes;
  for (int k = 0; k < 6; ++k) nodes.push_back({100.0 * k, 0.1 * 100 * k, 1, 10, 0, 0});
  const Drift line(nodes);
  EXPECT_EQ(line.followed(), 0);
  EXPECT_NEAR(line.rate_fF_s(), 0.1, 1e-12);
  EXPECT_NEAR(line.at(250), 25, 1e-9);
  nodes[3].fF += 50;
  const Drift bent(nodes);
  EXPECT_GT(bent.followed(), 0.99);
  EXPECT_NEAR(bent.at(300) - bent.at(0), 80, 1);
  const auto influence = bent.influence(250);
  EXPECT_NEAR(influence[2], 0.5, 0.02);
  EXPECT_NEAR(influence[3], 0.5, 0.02);
}

}  // namespace
}  // namespace lcrig
