// SPDX-License-Identifier: Apache-2.0
#include "model/bench_errors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace lcrig {
namespace {

constexpr double kC0_F = 3.65e-12;

struct RunningMean {
  double count = 0, mean = 0, squares = 0;
  void add(double y) {
    const double off = y - mean;
    mean += off / ++count;
    squares += off * (y - mean);
  }
  double variance() const { return squares / (count - 1); }
  double mean_se() const { return std::sqrt(variance() / count); }
};

MonoTime at(double s) {
  return MonoTime(from_seconds(100 + s));
}

// Mean over one second of readings without a load.
double unloaded_F(BenchErrors& errors, double from_s) {
  RunningMean mean;
  for (int i = 0; i < 10; ++i) mean.add(errors.shown_F(at(from_s + 0.1 * i), kC0_F, kC0_F, 0));
  return mean.mean;
}

TEST(BenchErrors, AreThoseOfTheSeed) {
  BenchErrors a(7), again(7), other(8);
  const double shown = unloaded_F(a, 0);
  EXPECT_EQ(shown, unloaded_F(again, 0));
  EXPECT_NE(shown, unloaded_F(other, 0));
  PlantConfig one, two;
  a.apply(one);
  other.apply(two);
  EXPECT_NE(one.force_gain, two.force_gain);
  EXPECT_NE(a.clock_ppm(), other.clock_ppm());
}

TEST(BenchErrors, StayWithinTheInstrumentsPapers) {
  RunningMean gain, offset, cell;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    BenchErrors errors(seed);
    PlantConfig config;
    errors.apply(config);
    gain.add(config.meter_gain_error);
    offset.add(config.meter_offset_error);
    EXPECT_LE(std::abs(config.meter_gain_error), 1) << "of what the manual allows";
    EXPECT_LE(std::abs(config.meter_offset_error), 1);
    cell.add(config.force_gain - 1);
    EXPECT_LT(std::abs(config.force_gain - 1), 0.021) << "class 1, and a tip within 0.02 of 4 mm";
    EXPECT_LE(std::abs(errors.clock_ppm()), 50);
  }
  for (const RunningMean& meter : {gain, offset}) {  // rectangular
    EXPECT_NEAR(std::sqrt(meter.variance()), 1 / std::sqrt(3.0), 0.2);
    EXPECT_LT(std::abs(meter.mean), 4 * meter.mean_se());
  }
  const double of_force = std::hypot(0.01, 0.01) / std::sqrt(3.0);
  EXPECT_NEAR(std::sqrt(cell.variance()), of_force, 0.2 * of_force);
}

// ISO 7500-1: the class is the limit of error in percent of the reading.
TEST(BenchErrors, OfTheCellKeepItsClass) {
  for (const double percent : kForceClasses) {
    double largest = 0, zero_N = 0;
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
      const BenchErrors errors(seed, ErrorScope::everything, {}, ForceClass(percent));
      const nlohmann::json drawn = errors.to_json();
      largest = std::max(largest, std::abs(drawn["cell_gain"].get<double>()));
      zero_N = std::max(zero_N, std::abs(drawn["cell_zero_mN"].get<double>()) / 1e3);
      EXPECT_EQ(drawn["probe_area"], BenchErrors(seed).to_json()["probe_area"]);
    }
    EXPECT_LE(largest, percent / 100);
    EXPECT_GT(largest, 0.98 * percent / 100) << "the whole class is used";
    EXPECT_LE(zero_N, percent / 1000 * 20) << "a tenth of the class, of a cell of 20 N";
    EXPECT_GT(zero_N, 0.9 * percent * 5e-3);
  }
}

TEST(BenchErrors, TheTruthsOfAnIntervalAreOfTheSameDraw) {
  BenchErrors lasting(5, ErrorScope::lasting), specimen(5, ErrorScope::specimen);
  const nlohmann::json drawn = BenchErrors(5).to_json();
  EXPECT_EQ(lasting.to_json(), drawn);
  PlantConfig rig, own;
  lasting.apply(rig);
  specimen.apply(own);
  EXPECT_EQ(rig.force_tare_error_N, drawn["cell_zero_mN"].get<double>() / 1e3);
  EXPECT_LE(std::abs(rig.force_tare_error_N), 5e-3);
  EXPECT_EQ(rig.meter_gain_error, drawn["meter_gain"].get<double>());
  EXPECT_EQ(rig.meter_offset_error, drawn["meter_offset"].get<double>());
  EXPECT_EQ(own.meter_gain_error, 0);
  EXPECT_EQ(own.meter_offset_error, 0);
  EXPECT_EQ(own.force_gain, 1);
  EXPECT_EQ(own.force_tare_error_N, 0);
  EXPECT_EQ(own.creep_fraction, drawn["creep"].get<double>());
  EXPECT_EQ(specimen.shown_F(at(0), kC0_F, kC0_F, 0), kC0_F);
  for (const double s : {0.0, 100.0, 3000.0}) {
    EXPECT_EQ(lasting.shown_F(at(s), kC0_F, kC0_F, 0), kC0_F) << "neither noise nor drift";
  }
}

// The law: 0.1 fF in each of 13 octaves of time, from 0.2 s (docs/simulator.md). Walk and beat are
// 0 at the beginning, and outliers do not affect the quartiles.
TEST(BenchErrors, OneOverFNoiseIsThereFromTheFirstReading) {
  constexpr int kSeeds = 2000;
  std::vector<double> first_F;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    BenchErrors noisy(seed), quiet(seed, ErrorScope::lasting);
    first_F.push_back(noisy.shown_F(at(0), kC0_F, kC0_F, 0) -
                      quiet.shown_F(at(0), kC0_F, kC0_F, 0));
  }
  std::sort(first_F.begin(), first_F.end());
  const double between_quartiles = first_F[kSeeds * 3 / 4] - first_F[kSeeds / 4];
  const double law_F = 0.1e-15 * std::sqrt(13.0);
  // The standard error of a normal's quartile distance from 2000 values is 2 %.
  EXPECT_NEAR(between_quartiles / 1.349, law_F, 0.08 * law_F);
}

TEST(BenchErrors, EachLoadingAnswersDifferently) {
  constexpr double kDelta_F = 500e-15;
  BenchErrors errors(3);
  RunningMean answers;
  for (int k = 0; k < 200; ++k) {
    const double rest_F = unloaded_F(errors, 4 * k);
    RunningMean loaded;
    for (int i = 0; i < 10; ++i) {
      loaded.add(errors.shown_F(at(4 * k + 2 + 0.1 * i), kC0_F + kDelta_F, kC0_F, 1.0));
    }
    answers.add((loaded.mean - rest_F) / kDelta_F);
  }
  EXPECT_NEAR(std::sqrt(answers.variance()), 0.01, 0.003) << "1 % of delta C, and noise";
  EXPECT_NEAR(answers.mean, 1, 0.005);
}

TEST(BenchErrors, TheUnloadedCapacitanceDrifts) {
  RunningMean change;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    BenchErrors errors(seed);
    const double before = unloaded_F(errors, 0);
    change.add(unloaded_F(errors, 3600) - before);
  }
  const double drift = 50e-15 / std::sqrt(3.0);  // +-50 fF/h
  EXPECT_GT(std::sqrt(change.variance()), 0.7 * drift);
  EXPECT_LT(std::sqrt(change.variance()), 1.3 * drift);
}

}  // namespace
}  // namespace lcrig
