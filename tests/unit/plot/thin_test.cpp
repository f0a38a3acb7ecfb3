// SPDX-License-Identifier: Apache-2.0
#include "plot/thin.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace lcrig::plot {
namespace {

std::vector<Pixel> ripple(int points) {
  std::vector<Pixel> out;
  for (int i = 0; i < points; ++i) {
    out.push_back({700.0 * i / points, 100 + 50 * std::sin(i * 0.37) + 20 * std::cos(i * 0.011)});
  }
  return out;
}

double height_of(const std::vector<Pixel>& points) {
  double low = 1e9, high = -1e9;
  for (const auto& p : points) {
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  return high - low;
}

TEST(ThinLine, KeepsAtMostFourPointsAColumn) {
  const auto thin = thin_line(ripple(200'000), 1);
  EXPECT_LE(thin.size(), 4U * 701U);
  EXPECT_GT(thin.size(), 700U);
}

TEST(ThinLine, KeepsTheExtremaOfEveryColumn) {
  const auto all = ripple(50'000);
  const auto thin = thin_line(all, 1);
  for (int column = 0; column < 700; ++column) {
    std::vector<Pixel> before, after;
    for (const auto& p : all) {
      if (std::floor(p.x) == column) before.push_back(p);
    }
    for (const auto& p : thin) {
      if (std::floor(p.x) == column) after.push_back(p);
    }
    ASSERT_EQ(height_of(before), height_of(after)) << column;
  }
  EXPECT_EQ(thin.front(), all.front());
  EXPECT_EQ(thin.back(), all.back());
}

TEST(ThinLine, ASpikeOfOneSampleStays) {
  auto all = ripple(100'000);
  all[61'803].y = -500;
  EXPECT_THAT(thin_line(all, 1), testing::Contains(all[61'803]));
}

TEST(ThinLine, ALoopKeepsItsOrder) {
  const std::vector<Pixel> loop{{0.1, 0}, {1.2, 5}, {2.2, 9}, {1.4, 7}, {0.3, 1}};
  EXPECT_EQ(thin_line(loop, 1), loop);
}

TEST(ThinMarks, DrawsOneMarkACell) {
  const std::vector<Pixel> points{{1.1, 1.1}, {1.2, 1.0}, {5, 5}, {1.3, 0.9}};
  const auto thin = thin_marks(points, 1);
  EXPECT_THAT(thin, testing::ElementsAre(Pixel{1.1, 1.1}, Pixel{5, 5}, Pixel{1.3, 0.9}));
}

TEST(ThinMarks, NothingStaysNothing) {
  EXPECT_TRUE(thin_marks({}, 1).empty());
  EXPECT_TRUE(thin_line({}, 1).empty());
}

}  // namespace
}  // namespace lcrig::plot
