// SPDX-License-Identifier: Apache-2.0
#include "plot/thin.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace lcrig::plot {

namespace {

bool lower(const Pixel& a, const Pixel& b) {
  return a.y < b.y;
}

void keep_run(std::span<const Pixel> run, std::vector<Pixel>& out) {
  const auto [least, most] = std::minmax_element(run.begin(), run.end(), lower);
  std::array<std::size_t, 4> kept{0, static_cast<std::size_t>(least - run.begin()),
                                  static_cast<std::size_t>(most - run.begin()), run.size() - 1};
  std::sort(kept.begin(), kept.end());
  const auto end = std::unique(kept.begin(), kept.end());
  for (auto i = kept.begin(); i != end; ++i) out.push_back(run[*i]);
}

}  // namespace

std::vector<Pixel> thin_line(std::span<const Pixel> points, double column) {
  std::vector<Pixel> out;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= points.size(); ++i) {
    if (i < points.size() &&
        std::floor(points[i].x / column) == std::floor(points[begin].x / column)) {
      continue;
    }
    keep_run(points.subspan(begin, i - begin), out);
    begin = i;
  }
  return out;
}

std::vector<Pixel> thin_marks(std::span<const Pixel> points, double cell) {
  std::vector<Pixel> out;
  if (points.empty()) return out;
  const auto [least, most] = std::minmax_element(points.begin(), points.end(), lower);
  std::set<std::pair<long, long>> occupied;
  for (const Pixel& p : points) {
    const auto at = std::pair(std::lround(p.x / cell), std::lround(p.y / cell));
    if (occupied.insert(at).second || &p == &*least || &p == &*most) out.push_back(p);
  }
  return out;
}

}  // namespace lcrig::plot
