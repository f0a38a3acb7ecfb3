// SPDX-License-Identifier: Apache-2.0
#include "protocols/guard.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

using namespace std::chrono_literals;

FrameSample sample(double t_s, std::optional<double> force_N) {
  FrameSample s;
  s.received = MonoTime() + from_seconds(t_s);
  s.force_N = force_N;
  s.travel_m = 0;
  return s;
}

BoundLimits window() {
  BoundLimits w;
  w.force_min_N = -0.2;
  w.force_max_N = 1;
  return w;
}

TEST(Guard, SamplesWithoutAForceAreNoSamples) {
  Guard guard(window(), 500ms);
  guard.set_watch_age(true);
  EXPECT_FALSE(guard.check(sample(1.0, 0.1)));
  EXPECT_FALSE(guard.check(sample(1.4, std::nullopt)));
  EXPECT_FALSE(guard.check_age(MonoTime() + 1400ms));
  EXPECT_FALSE(guard.check(sample(1.6, std::nullopt)));
  EXPECT_TRUE(guard.check_age(MonoTime() + 1600ms)) << "the force is not known for 0.6 s";
}

TEST(Guard, AForceBeyondTheCellStopsAtOnce) {
  Guard guard(window(), 500ms);
  FrameSample s = sample(1, std::nullopt);
  s.flags = frame_flag::kForceOverload;
  EXPECT_TRUE(guard.check(s));
}

TEST(Guard, ASpikeInEitherDirectionIsSeen) {
  Guard guard(window(), 500ms);
  EXPECT_FALSE(guard.check(sample(1, 1.0)));
  EXPECT_TRUE(guard.check(sample(1, 1.01)));
  EXPECT_TRUE(guard.check(sample(1, -0.21)));
}

}  // namespace
}  // namespace lcrig
