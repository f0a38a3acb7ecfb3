// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sample_clock.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace lcrig {
namespace {

std::vector<FrameSample> batch(double first_s, int n, double period_s, double arrives_s) {
  std::vector<FrameSample> out;
  for (int i = 0; i < n; ++i) {
    FrameSample s;
    s.device_time_s = first_s + i * period_s;
    s.received = MonoTime(from_seconds(arrives_s));
    out.push_back(s);
  }
  return out;
}

struct Seen {
  double worst_s = 0;
  std::vector<EventKind> events;
  void note(const SampleClock::Finding& f) {
    worst_s = std::max(worst_s, f.age_s);
    if (f.news) events.push_back(f.news->first);
  }
};

TEST(SampleClock, BatchesOfATenthOfASecondAreFresh) {
  SampleClock clock;
  Seen seen;
  for (int i = 0; i < 600; ++i) {
    const double t = 0.1 * i;
    const double jitter = i % 7 * 0.005;
    seen.note(clock.add(batch(1e4 + t, 5, 0.02, t + 0.08 + jitter)));
  }
  EXPECT_LT(seen.worst_s, 0.15);
  EXPECT_TRUE(seen.events.empty());
}

TEST(SampleClock, SamplesThatAreHeldBackAreOld) {
  SampleClock clock;
  for (int i = 0; i < 50; ++i) clock.add(batch(0.1 * i, 5, 0.02, 0.1 * i + 0.08));
  EXPECT_NEAR(clock.add(batch(5.0, 20, 0.02, 5.4)).age_s, 0.4, 0.021);
}

TEST(SampleClock, LateFromSomeTimeOnIsOldForTenSecondsAtLeast) {
  SampleClock clock;
  Seen seen;
  for (int i = 0; i < 50; ++i) clock.add(batch(0.1 * i, 5, 0.02, 0.1 * i + 0.08));
  for (int i = 50; i < 150; ++i) {
    EXPECT_GT(clock.add(batch(0.1 * i, 5, 0.02, 0.1 * i + 0.48)).age_s, 0.3) << i;
  }
}

TEST(SampleClock, ACrystalThatIsOffByAThousandthTellsNoAges) {
  SampleClock clock;
  Seen seen;
  for (int i = 0; i < 36000; ++i) {
    seen.note(clock.add(batch(0.1 * i * 0.999, 5, 0.02, 0.1 * i + 0.08)));
  }
  EXPECT_LT(seen.worst_s, 0.15);
  EXPECT_TRUE(seen.events.empty());
}

TEST(SampleClock, AWrongRateIsNamedOnce) {
  SampleClock clock;
  Seen seen;
  for (int i = 0; i < 600; ++i) seen.note(clock.add(batch(0.1 * i * 0.97, 5, 0.02, 0.1 * i)));
  EXPECT_EQ(seen.events, std::vector<EventKind>{EventKind::device_clock_rate});
}

TEST(SampleClock, AFrozenClockIsNamedOnceAndTellsNoAges) {
  SampleClock clock;
  Seen seen;
  for (int i = 0; i < 20; ++i) seen.note(clock.add(batch(0.1 * i, 5, 0.02, 0.1 * i + 0.08)));
  for (int i = 20; i < 60; ++i) seen.note(clock.add(batch(2.0, 1, 0, 0.1 * i + 0.08)));
  EXPECT_EQ(seen.events, std::vector<EventKind>{EventKind::device_clock_frozen});
  EXPECT_LT(seen.worst_s, 0.2);
}

TEST(SampleClock, WithoutADeviceClockThereAreNoAges) {
  SampleClock clock;
  std::vector<FrameSample> one(1);
  one[0].received = MonoTime(from_seconds(3));
  EXPECT_EQ(clock.add(one).age_s, 0);
}

}  // namespace
}  // namespace lcrig
