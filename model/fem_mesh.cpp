// SPDX-License-Identifier: Apache-2.0
#include "model/fem_mesh.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace lcrig {
namespace {

// Counts and ratios were found by halving the error of the bonded laminate and of the bonded disc
// against their references (docs/model.md, "Meshes").
struct Grading {
  int rim_cells, inner_cells, soft_rows, stiff_rows;
  double rim_ratio, soft_ratio, stiff_ratio;
};
constexpr std::array<Grading, 6> kGradings{{{10, 6, 6, 2, 30, 10, 3},
                                            {12, 10, 8, 2, 40, 8, 3},
                                            {20, 12, 16, 3, 300, 30, 5},
                                            {24, 16, 30, 4, 1e3, 100, 10},
                                            {36, 24, 44, 6, 4e3, 400, 50},
                                            {44, 28, 52, 8, 1e4, 1e3, 100}}};
// A block alone has all the error to itself and costs little: it starts two steps finer. Not at
// finite strain, where cells that small at a bonded rim fold over long before the stack does.
const Grading& grading(const MeshStyle& style) {
  const bool finer = style.alone && !style.finite;
  return kGradings[static_cast<std::size_t>(style.refinement + (finer ? 2 : 0))];
}
constexpr double kInnerRatio = 60;
constexpr double kRimWidth = 2.4;  // of the edge zone, in thicknesses of the thinnest layer

std::vector<double> sizes_growing(int n, double ratio) {
  std::vector<double> h;
  for (int i = 0; i < n; ++i) {
    h.push_back(std::pow(ratio, n > 1 ? static_cast<double>(i) / (n - 1) : 0.0));
  }
  return h;
}

}  // namespace

std::size_t affordable_unknowns() {
  // Matrix, factors and cells, on the safe side: a laminate of ten takes 230 MB on mesh 3.
  constexpr double kBytesPerUnknown = 4096;
  constexpr double kMost = 3e6;
  const double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return static_cast<std::size_t>(std::clamp(memory / 2 / kBytesPerUnknown, 1e4, kMost));
}

std::vector<double> graded(double a, double b, int n, Fine fine, double ratio) {
  std::vector<double> h;
  if (fine == Fine::at_both) {
    h = sizes_growing((n + 1) / 2, ratio);
    const std::vector<double> half = h;
    h.insert(h.end(), half.rbegin() + n % 2, half.rend());
  } else {
    h = sizes_growing(n, fine == Fine::nowhere ? 1 : ratio);
    if (fine == Fine::at_b) {
      std::reverse(h.begin(), h.end());
    }
  }
  double total = 0;
  for (const double size : h) {
    total += size;
  }
  std::vector<double> x{a};
  double sum = 0;
  for (const double size : h) {
    sum += size;
    x.push_back(a + (b - a) * (sum / total));
  }
  x.back() = b;
  return x;
}

std::vector<double> radial_edges(double radius, double thinnest, const MeshStyle& style) {
  if (!style.bonded) {
    return graded(0, radius, 2, Fine::nowhere, 1);  // uniform strain: two cells are exact
  }
  const Grading& g = grading(style);
  const double rim = std::min(kRimWidth * thinnest, 0.6 * radius);
  auto edge = graded(radius - rim, radius, g.rim_cells, Fine::at_b, g.rim_ratio);
  const double outer_cell = edge[1] - edge[0];
  const double even = (radius - rim) / g.inner_cells;
  const double ratio = std::clamp(3 * even / outer_cell, 1.0, kInnerRatio);
  auto r = graded(0, radius - rim, g.inner_cells, Fine::at_b, ratio);
  r.insert(r.end(), edge.begin() + 1, edge.end());
  return r;
}

std::vector<double> axial_edges(double z0, double z1, double thinnest, bool stiff,
                                const MeshStyle& style) {
  if (!style.bonded) {
    return {z0, z1};
  }
  const Grading& g = grading(style);
  if (stiff) {
    return graded(z0, z1, g.stiff_rows, Fine::at_both, g.stiff_ratio);
  }
  const double thicker = std::max((z1 - z0) / thinnest, 1.0);
  const int rows = g.soft_rows + 2 * static_cast<int>(std::lround(std::log2(thicker)));
  return graded(z0, z1, rows, Fine::at_both, g.soft_ratio * std::sqrt(thicker));
}

}  // namespace lcrig
