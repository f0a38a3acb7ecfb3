// SPDX-License-Identifier: Apache-2.0
// Removes points that make no difference to the picture. Only what is drawn is thinned, never the
// data. Used by marks and charts.
#pragma once

#include <span>
#include <vector>

namespace lcrig::plot {

struct Pixel {
  double x = 0, y = 0;
  bool operator==(const Pixel&) const = default;
};

// Keeps the first, lowest, highest and last of each run of consecutive points in one column of the
// given width, in their order. Every extremum of the line stays. Also works for loops.
std::vector<Pixel> thin_line(std::span<const Pixel> points, double column);
// Keeps the first point of each occupied square cell, and always the lowest and the highest point.
std::vector<Pixel> thin_marks(std::span<const Pixel> points, double cell);

}  // namespace lcrig::plot
