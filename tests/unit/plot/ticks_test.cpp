// SPDX-License-Identifier: Apache-2.0
#include "plot/ticks.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <set>

namespace lcrig::plot {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::Pointwise;

TEST(Ticks, AreRoundNumbersInsideTheRange) {
  const Ticks t = linear_ticks(-3, 104, 7);
  EXPECT_THAT(t.at, ElementsAre(0, 20, 40, 60, 80, 100));
  EXPECT_THAT(t.labels, ElementsAre("0", "20", "40", "60", "80", "100"));
}

TEST(Ticks, DecimalsFollowTheStep) {
  EXPECT_THAT(linear_ticks(3.6481, 3.6519, 5).labels, ElementsAre("3.649", "3.650", "3.651"));
  EXPECT_THAT(linear_ticks(-0.25, 0.25, 5).labels, ElementsAre("−0.2", "−0.1", "0", "0.1", "0.2"));
}

TEST(Ticks, AnOffsetKeepsItsDigits) {
  const Ticks t = linear_ticks(1e8, 1e8 + 10, 6);
  EXPECT_EQ(t.labels.front(), "100000000");
  EXPECT_EQ(t.labels.back(), "100000010");
  EXPECT_EQ(std::set(t.labels.begin(), t.labels.end()).size(), t.labels.size());
}

TEST(Ticks, AreNeverMoreThanWanted) {
  for (int most = 2; most < 12; ++most) {
    for (const double low : {-1.0, 0.0, 0.37, 99.999, 1e-12}) {
      for (const double span : {1e-15, 0.0313, 1.0, 7.7, 1e4, 3e9}) {
        if (span < 1e-12 * std::abs(low)) continue;  // finer than a double
        const Ticks t = linear_ticks(low, low + span, most);
        EXPECT_LE(t.at.size(), static_cast<std::size_t>(most)) << low << ' ' << span;
        EXPECT_EQ(t.at.size(), t.labels.size());
        for (const double v : t.at) {
          EXPECT_TRUE(v >= low - 1e-9 * span && v <= low + 1.000001 * span);
        }
      }
    }
  }
}

TEST(Ticks, LogarithmicOnesAreDecades) {
  const Ticks t = log_ticks(1e-6, 2e2, 10);
  EXPECT_THAT(t.at,
              Pointwise(DoubleNear(1e-9), {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1., 10., 100.}));
  EXPECT_THAT(t.labels,
              ElementsAre("10⁻⁶", "10⁻⁵", "0.0001", "0.001", "0.01", "0.1", "1", "10", "100"));
}

TEST(Ticks, AShortLogarithmicRangeGetsTwosAndFives) {
  EXPECT_THAT(log_ticks(0.015, 1.2, 10).labels,
              ElementsAre("0.02", "0.05", "0.1", "0.2", "0.5", "1"));
  EXPECT_THAT(log_ticks(31, 38, 5).labels, ElementsAre("32", "34", "36", "38"));
}

}  // namespace
}  // namespace lcrig::plot
