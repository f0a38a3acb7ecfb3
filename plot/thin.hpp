// SPDX-License-Identifier: Apache-2.0
// Fewer points for the same picture. Only the drawing is thinned, never the data.
#pragma once

#include <span>
#include <vector>

namespace lcrig::plot {

struct Pixel {
  double x = 0, y = 0;
  bool operator==(const Pixel&) const = default;
};

// Of each run of consecutive points in one column of the given width: the first, the lowest, the
// highest and the last, in their order. Every extremum of the line stays; works for loops too.
std::vector<Pixel> thin_line(std::span<const Pixel> points, double column);
// One point of each occupied square cell, the first one, and always the lowest and the highest.
std::vector<Pixel> thin_marks(std::span<const Pixel> points, double cell);

}  // namespace lcrig::plot
