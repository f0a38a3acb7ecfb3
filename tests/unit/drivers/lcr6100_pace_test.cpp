// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/pace.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace lcrig::lcr6100 {
namespace {

using namespace std::chrono_literals;

// How long after its conversion each new value is asked for, if the meter's clock is perfect.
std::vector<Duration> delays(Duration period, int values) {
  std::vector<Duration> out;
  out.reserve(static_cast<std::size_t>(values));
  const MonoTime begin{1000s};
  Pace pace;
  pace.restart(begin, period);
  MonoTime now = begin;
  std::int64_t seen = 0;
  while (std::ssize(out) < values) {
    now = pace.next_poll(now);
    const std::int64_t edges = (now - begin - 7ms) / period;
    if (edges <= seen) {
      pace.stale(now);
      now += 200us;
      continue;
    }
    seen = edges;
    out.push_back(now - (begin + 7ms + edges * period));
    pace.fresh(now, now + 200us);
    now += 200us;
  }
  return out;
}

// The budget of quick loadings uses this figure. Answers come at once, as from the simulated meter.
TEST(PaceOfAMeter, AsksLaterAndLaterUntilItAsksEarlierAgain) {
  for (const Duration period : {65ms, 120ms}) {
    const auto found = delays(period, 1000);
    int later = 0, earlier = 0;
    for (std::size_t i = 501; i < found.size(); ++i) {
      const Duration step = found[i] - found[i - 1];
      later += std::chrono::abs(step - Pace::kLater) < Pace::kLater / 2 ? 1 : 0;
      earlier += std::chrono::abs(step + Pace::kEarlier) < Pace::kEarlier / 5 ? 1 : 0;
      EXPECT_LE(found[i], Pace::kStep);
    }
    EXPECT_GT(later, 350);
    EXPECT_GT(earlier, 35);
  }
}

// Wherever the conversions lie beside the first question, and however long an answer takes. At 380
// ms it was 10.5 polls a value for most phases, because the pace lost a grid that it knew.
TEST(PaceOfAMeter, NeedsFewPollsAtEveryPhaseOfTheConversions) {
  constexpr int kPhases = 50, kValues = 400;
  for (const Duration period : {65ms, 120ms, 380ms}) {
    for (const Duration answer : {0us, 4000us}) {
      for (int i = 0; i < kPhases; ++i) {
        const MonoTime begin{1000s};
        const MonoTime edge = begin - period + i * period / kPhases;
        const auto edges = [&](MonoTime t) { return (t - edge) / period; };
        Pace pace;
        pace.restart(begin, period);
        MonoTime now = begin;
        int polls = 0, missed = 0;
        std::int64_t seen = edges(begin);
        for (int values = 0; values < kValues; ++polls) {
          const MonoTime asked = pace.next_poll(now);
          now = asked + answer;
          const std::int64_t newest = edges(asked);
          if (newest == seen) {
            pace.stale(asked);
            continue;
          }
          missed += values > 0 && newest != seen + 1 ? 1 : 0;
          seen = newest;
          pace.fresh(asked, now);
          ++values;
        }
        EXPECT_LE(polls, 1.5 * kValues) << period.count() << " ns, phase " << i;
        EXPECT_EQ(missed, 0) << period.count() << " ns, phase " << i;
      }
    }
  }
}

}  // namespace
}  // namespace lcrig::lcr6100
