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

}  // namespace
}  // namespace lcrig::lcr6100
