// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sample_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace lcrig {
namespace {

std::vector<FrameSample> batch(double first_s, int n, double period_s, double arrives_s) {
  static std::int64_t seq = 0;
  std::vector<FrameSample> out;
  for (int i = 0; i < n; ++i) {
    FrameSample s;
    s.device_seq = ++seq;
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

// What a cheap oscillator keeps: it is named, and its samples are as fresh as they are.
TEST(SampleClock, AClockThatIsOffByTwoPerCentStillTellsAges) {
  for (const double rate : {0.98, 0.985, 0.991, 1.009, 1.02}) {
    SampleClock clock;
    Seen seen;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> jitter(0, 0.05);
    for (int i = 0; i < 3000; ++i) {
      const double t = 0.1 * i;
      seen.note(clock.add(batch(50 + t * rate, 5, 0.02 * rate, t + 0.08 + jitter(random))));
    }
    EXPECT_LT(seen.worst_s, 0.15) << rate;
    EXPECT_EQ(seen.events.size(), std::abs(rate - 1) > 0.01 ? 1U : 0U) << rate;
    const double t = 300;
    EXPECT_NEAR(clock.add(batch(50 + t * rate, 5, 0.02 * rate, t + 0.48)).age_s, 0.48, 0.05)
        << rate;
  }
}

// From the first second on a sample that was held back is known, whatever the rate may be.
TEST(SampleClock, HeldBackSamplesAreKnownBeforeTheRateIs) {
  for (const double rate : {0.98, 1.0, 1.02}) {
    for (const int batches : {10, 30, 95}) {
      SampleClock clock;
      for (int i = 0; i < batches; ++i) clock.add(batch(0.1 * i * rate, 5, 0.02 * rate, 0.1 * i));
      const double t = 0.1 * batches;
      const double age_s = clock.add(batch(t * rate, 5, 0.02 * rate, t + 0.4)).age_s;
      EXPECT_GT(age_s, 0.3) << rate << " " << batches;
      EXPECT_LT(age_s, 0.5) << rate << " " << batches;
    }
  }
}

// A gateway that falls behind by a fiftieth, after its clock was known, is late within a minute.
TEST(SampleClock, AGatewayThatFallsBehindIsNoSlowClock) {
  SampleClock clock;
  for (int i = 0; i < 200; ++i) clock.add(batch(0.1 * i, 5, 0.02, 0.1 * i + 0.08));
  double first_s = 0;
  for (int i = 200; i < 800 && first_s == 0; ++i) {
    const double behind_s = 0.02 * 0.1 * (i - 200);
    if (clock.add(batch(0.1 * i, 5, 0.02, 0.1 * i + 0.08 + behind_s)).age_s >
        SampleClock::kLate_s) {
      first_s = 0.1 * (i - 200);
    }
  }
  EXPECT_GT(first_s, 0);
  EXPECT_LT(first_s, 15);
}

// The clock was set between two samples of one batch, or between two batches.
TEST(SampleClock, AClockThatIsSetMakesNoSampleOld) {
  for (const double step_s : {-30.0, -0.3, 0.3, 30.0}) {
    for (const int at : {0, 2, 4}) {  // before this sample of the batch
      SampleClock clock;
      Seen seen;
      for (int i = 0; i < 200; ++i) {
        auto samples = batch(100 + 0.1 * i, 5, 0.02, 0.1 * i + 0.08);
        for (int k = 0; k < 5; ++k) {
          if (i > 100 || (i == 100 && k >= at)) {
            *samples[static_cast<std::size_t>(k)].device_time_s += step_s;
          }
        }
        seen.note(clock.add(samples));
      }
      EXPECT_LT(seen.worst_s, 0.15) << step_s << " s before sample " << at;
      EXPECT_NEAR(clock.add(batch(120 + step_s, 5, 0.02, 20.48)).age_s, 0.48, 0.05);
    }
  }
}

TEST(SampleClock, AClockThatBecomesUselessIsNamed) {
  for (const double factor : {0.3, 2.0, 3.0}) {
    for (const int n : {1, 5}) {  // samples of a batch
      SampleClock clock;
      Seen seen;
      double device_s = 0;
      for (int i = 0; i < 800; ++i) {
        const double each_s = 0.1 / n * (i < 300 ? 1 : factor);
        seen.note(clock.add(batch(device_s, n, each_s, 0.1 * i)));
        device_s += n * each_s;
      }
      EXPECT_EQ(seen.events, std::vector<EventKind>{EventKind::device_clock_rate}) << factor;
    }
  }
}

// Of a clock that is none nobody knows how old its samples are.
TEST(SampleClock, AUselessClockTellsNoAges) {
  for (const double rate : {0.3, 0.97, 1.03, 3.0}) {
    SampleClock clock;
    Seen seen;
    for (int i = 0; i < 110; ++i) clock.add(batch(0.1 * i * rate, 5, 0.02 * rate, 0.1 * i));
    for (int i = 110; i < 600; ++i) {
      seen.note(clock.add(batch(0.1 * i * rate, 5, 0.02 * rate, 0.1 * i)));
    }
    EXPECT_EQ(seen.worst_s, 0) << rate;
  }
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
