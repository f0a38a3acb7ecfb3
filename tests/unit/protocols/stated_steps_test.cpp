// SPDX-License-Identifier: Apache-2.0
// Stated steps of travel and force, compared with samples.
#include "protocols/run/stated_steps.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lcrig {
namespace {

using ::testing::HasSubstr;

FrameCapabilities stating(double travel_um, double force_mN) {
  FrameCapabilities c;
  c.travel_step = Length::from_si(travel_um * 1e-6);
  c.force_step = Force::from_si(force_mN * 1e-3);
  return c;
}

// A ramp whose values are multiples of the true steps, from an odd origin.
std::vector<FrameSample> ramp(double travel_um, double force_mN) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 3 * force_mN * 1e-3);
  std::vector<FrameSample> out(500);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double step_m = travel_um * 1e-6, step_N = force_mN * 1e-3;
    const double travel_m = 0.137e-6 * static_cast<double>(i);
    out[i].travel_m = 0.3e-7 + step_m * std::round(travel_m / step_m);
    out[i].force_N = 0.2e-5 + step_N * std::round(noise(random) / step_N);
  }
  return out;
}

TEST(StatedSteps, ThatAreTrueAreNotReported) {
  for (const auto& [travel_um, force_mN] : {std::pair(0.1, 0.1), {2.0, 0.5}, {10.0, 60.0}}) {
    EXPECT_THAT(StatedSteps(stating(travel_um, force_mN)).add(ramp(travel_um, force_mN)),
                testing::IsEmpty());
  }
  EXPECT_THAT(StatedSteps(FrameCapabilities()).add(ramp(0.1, 0.1)), testing::IsEmpty());
}

TEST(StatedSteps, ThatAreCoarserThanTheSamplesAreReportedOnceEach) {
  StatedSteps steps(stating(2, 5));
  const auto news = steps.add(ramp(0.1, 0.5));
  ASSERT_EQ(news.size(), 2U);
  for (const auto& [kind, words] : news) {
    const bool travel = kind == EventKind::device_travel_step;
    EXPECT_TRUE(travel || kind == EventKind::device_force_step);
    EXPECT_THAT(words, HasSubstr(travel ? "steps of 2 um are stated" : "steps of 5 mN are stated"));
  }
  EXPECT_THAT(steps.add(ramp(0.1, 0.5)), testing::IsEmpty());
}

TEST(StatedSteps, AreNotDisprovedByNewZeros) {
  StatedSteps steps(stating(2, 5));
  auto samples = ramp(2, 5);
  for (int zero = 0; zero < 10; ++zero) {
    EXPECT_THAT(steps.add(samples), testing::IsEmpty());
    const FrameSample last = samples.back();
    for (auto& s : samples) *s.travel_m -= 0.7e-6, *s.force_N += 2e-3;
    samples.front().travel_m = *last.travel_m - 0.7e-6;
    samples.front().force_N = *last.force_N + 2e-3;
  }
}

}  // namespace
}  // namespace lcrig
