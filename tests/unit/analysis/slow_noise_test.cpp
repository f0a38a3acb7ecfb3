// SPDX-License-Identifier: Apache-2.0
// Errors of the mean of part of a run, and of a line through the rests, under noise that is slower
// than the readings. Sizes and times differ from those that the simulated bench draws.
#include "analysis/slow_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/line_fit.hpp"

namespace lcrig {
namespace {

struct Noise {
  double white_fF = 0.5, walk_fF_sqrt_s = 0, flicker_fF = 0;
};

// A baseline of 24 blocks of a second, and five rests of two blocks, a minute apart.
class MadeUp {
 public:
  MadeUp(const Noise& noise, std::uint64_t seed) : noise_(noise), random_(seed) {
    for (double tau = 0.5; tau < 2000; tau *= 2) octaves_.emplace_back(tau, normal_(random_));
    for (int i = 0; i < 24; ++i) add(0.5 + i, false);
    for (int k = 1; k <= 5; ++k) add(60 * k + 0.5, true), add(60 * k + 1.5, true);
  }
  std::vector<QuietBlock> blocks;

 private:
  void add(double t_s, bool loaded_before) {
    const double step_s = t_s - t_s_;
    t_s_ = t_s;
    double fF = noise_.white_fF * normal_(random_);
    fF += walk_ += noise_.walk_fF_sqrt_s * std::sqrt(step_s) * normal_(random_);
    for (auto& [tau, state] : octaves_) {
      const double keeps = std::exp(-step_s / tau);
      state = keeps * state + std::sqrt(1 - keeps * keeps) * normal_(random_);
      fF += noise_.flicker_fF * state;
    }
    blocks.push_back({t_s, 1, fF, 0.1, loaded_before});
  }

  Noise noise_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<std::pair<double, double>> octaves_;
  double t_s_ = 0, walk_ = 0;
};

constexpr int kRuns = 60;
constexpr double kRun_s = 302;

struct Held {
  int runs = 0;
  double half = 0, squares = 0;
  double too_wide() const { return half / kRuns / (1.96 * std::sqrt(squares / kRuns)); }
};

// How many intervals of the baseline's mean contain the truth, 0, and how wide they are.
Held hold_baseline(const Noise& noise) {
  Held out;
  for (int run = 0; run < kRuns; ++run) {
    const MadeUp made(noise, 4'100'000 + static_cast<std::uint64_t>(run));
    std::vector<double> factor(made.blocks.size(), 0.0);
    double mean = 0;
    for (std::size_t i = 0; i < 24; ++i) factor[i] = 1.0 / 24, mean += made.blocks[i].fF / 24;
    const SlowNoise slow(made.blocks, kRun_s, AfterLoad::shifted);
    const SlopePart error = slow.error_of(factor, 0, 0.95);
    const double half = coverage_factor(0.95, error.degrees_of_freedom) * error.se;
    out.runs += std::abs(mean) <= half ? 1 : 0;
    out.half += half;
    out.squares += mean * mean;
  }
  return out;
}

TEST(SlowNoise, IntervalsOfTheBaselineHoldUnderARandomWalkOfAnySize) {
  for (const double walk : {0.02, 0.2, 2.0}) {
    EXPECT_GE(hold_baseline({0.5, walk, 0}).runs, 0.90 * kRuns) << walk;
  }
}

TEST(SlowNoise, IntervalsOfTheBaselineHoldUnderOneOverFNoiseOfAnySize) {
  for (const double flicker : {0.05, 0.3, 2.5}) {
    EXPECT_GE(hold_baseline({0.5, 0, flicker}).runs, 0.86 * kRuns) << flicker;
  }
}

// The rate of a line through baseline and rests. Five rests hardly tell a walk from 1/f noise.
TEST(SlowNoise, IntervalsOfTheRateHoldUnderARandomWalk) {
  for (const double walk : {0.1, 0.4}) {
    int held = 0;
    for (int run = 0; run < kRuns; ++run) {
      const MadeUp made({0.5, walk, 0}, 4'400'000 + static_cast<std::uint64_t>(run));
      std::vector<LinePoint> nodes{{12, 0, 1}};
      for (std::size_t k = 1; k <= 5; ++k)
        nodes.push_back({60.0 * static_cast<double>(k) + 1, 0, 1});
      for (std::size_t i = 0; i < made.blocks.size(); ++i) {
        LinePoint& node = i < 24 ? nodes[0] : nodes[1 + (i - 24) / 2];
        node.y += made.blocks[i].fF / (i < 24 ? 24 : 2);
      }
      const auto line = fit_line(nodes);
      std::vector<double> factor;
      for (std::size_t i = 0; i < made.blocks.size(); ++i) {
        const double t_s = i < 24 ? nodes[0].x : nodes[1 + (i - 24) / 2].x;
        factor.push_back((t_s - line->x_mean) / line->sxx / (i < 24 ? 24 : 2));
      }
      const SlopePart error =
          SlowNoise(made.blocks, kRun_s, AfterLoad::alike).error_of(factor, 0, 0.95);
      const double half = coverage_factor(0.95, error.degrees_of_freedom) * error.se;
      held += std::abs(line->slope) <= half ? 1 : 0;
    }
    EXPECT_GE(held, 0.95 * kRuns) << walk;
  }
}

// The price: one run cannot exclude slow noise.
TEST(SlowNoise, WhiteNoiseAloneGivesAnIntervalFourTimesAsWideAtMost) {
  const Held held = hold_baseline({});
  EXPECT_GE(held.runs, 0.95 * kRuns);
  EXPECT_LE(held.too_wide(), 4);
}

TEST(SlowNoise, AShiftAfterTheFirstLoadIsNoNoiseOfTheBaseline) {
  MadeUp made({}, 4'200'000);
  std::vector<double> factor(made.blocks.size(), 0.0);
  for (std::size_t i = 0; i < 24; ++i) factor[i] = 1.0 / 24;
  const double before =
      SlowNoise(made.blocks, kRun_s, AfterLoad::shifted).error_of(factor, 0, 0.95).se;
  for (QuietBlock& b : made.blocks) b.fF += b.loaded_before ? 30 : 0;
  const double shifted =
      SlowNoise(made.blocks, kRun_s, AfterLoad::shifted).error_of(factor, 0, 0.95).se;
  const double alike =
      SlowNoise(made.blocks, kRun_s, AfterLoad::alike).error_of(factor, 0, 0.95).se;
  EXPECT_NEAR(shifted, before, 1e-6 * before);
  EXPECT_GT(alike, 3 * before);
}

TEST(SlowNoise, WhatOutliersDoToTheMeanIsNotLessThanTheirScatter) {
  const MadeUp made({}, 4'300'000);
  const std::vector<double> factor(made.blocks.size(), 1.0 / 34);
  const SlowNoise slow(made.blocks, kRun_s, AfterLoad::alike);
  EXPECT_GE(slow.error_of(factor, 25, 0.95).se, 5);
  EXPECT_LT(slow.error_of(factor, 0, 0.95).se, 5);
}

TEST(SlowNoise, AFewBlocksTellNothing) {
  EXPECT_FALSE(SlowNoise().known());
  EXPECT_FALSE(SlowNoise({}, kRun_s, AfterLoad::alike).known());
  auto blocks = MadeUp({}, 1).blocks;
  blocks.resize(5);
  EXPECT_FALSE(SlowNoise(blocks, kRun_s, AfterLoad::alike).known());
}

}  // namespace
}  // namespace lcrig
