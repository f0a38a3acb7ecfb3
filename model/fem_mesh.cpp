// SPDX-License-Identifier: Apache-2.0
#include "model/fem_mesh.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace lcrig {
namespace {

// The distance from a corner grows like s^q over evenly divided s. If q exceeds the degree over
// twice the exponent of the corner (at least a half), corners converge as fast as smooth regions.
// With q = 4 they keep up with cells of degree four where it matters.
constexpr double kGrading = 4;
// For finite strain. A corner folds over at a load that falls with the size of its cells, so
// smaller cells lose more than they gain.
constexpr double kMildGrading = 2, kMildRadialGrading = 3;

// The following sizes of the coarsest member determine the cost of a mesh but not how fast the
// family converges. Radial cells of a mild mesh without its boundary layers.
constexpr double kMildRadialCells = 3;
// Number of cells for each factor e of the distance from the rim, beyond the half thickness of a
// layer. It is relative to the number of cells within that half, times the exponent of the grading.
constexpr double kCellsPerFold = 0.75;
// Cells per length of a boundary layer, up to this many lengths from the rim.
constexpr double kCellsPerLength = 0.5, kMildCellsPerLength = 0.25;
constexpr double kLengths = 4;

// Cells of a member that replace one of the coarsest mild member, or two of the coarsest other one.
int fineness(int refinement, bool mild) {
  const int at = refinement - kCoarsestMember;
  return mild ? 1 << at : (at % 2 == 0 ? 2 : 3) << at / 2;
}

int members(double of_the_coarsest, const MeshStyle& style) {
  const double units = style.mild_corners ? of_the_coarsest : of_the_coarsest / 2;
  return std::max(1, static_cast<int>(std::lround(units))) *
         fineness(style.refinement, style.mild_corners);
}

// Rows of a soft block in the coarsest member. A single block has more: it costs little and has all
// the error to itself. With mild corners it has one, because its cells would fold over early.
double soft_rows(const MeshStyle& style) {
  if (style.mild_corners) return 1;
  return style.alone ? 4 : 2;
}

double axial_grading(const MeshStyle& style) {
  return style.mild_corners ? kMildGrading : kGrading;
}

// Density (1/m) of cells that are graded like s^q over a length, at a distance from its end.
double graded(double cells, double length, double distance, double q) {
  return cells / q / length * std::pow(distance / length, 1 / q - 1);
}

double for_lengths(double density, double distance, const MeshStyle& style) {
  const double cells = style.mild_corners ? kMildCellsPerLength : kCellsPerLength;
  for (const double length : style.lengths_m) {
    const double depth = distance / (kLengths * length);
    const double share = depth < 1 ? 1 : 1 / (depth * depth);
    density = std::max(density, cells / length * share);
  }
  return density;
}

// Cells per m of the coarsest member at a distance from the rim. Close to the rim the density is
// that of the rows at a face, so that corner cells are about as wide as they are high. Further in,
// cells grow in proportion to the distance.
double density(double distance, double radius, const MeshStyle& style) {
  const double half = std::min(style.thinnest_m / 2, radius);
  const double rows = graded(soft_rows(style), half, std::min(distance, half), kGrading);
  const double corner =
      distance < half ? rows
                      : std::min(kCellsPerFold * soft_rows(style) / kGrading / distance, rows);
  return for_lengths(corner, distance, style);
}

// The same with mild corners, where the distance grows like s^q from the rim to the axis.
double mild_density(double distance, double radius, const MeshStyle& style) {
  const double half = style.thinnest_m / 2;
  const double whole = graded(kMildRadialCells, radius, distance, kMildRadialGrading);
  const double dense = for_lengths(whole, distance, style);
  if (!(distance < half)) return dense;
  // not finer than the rows at a face
  return std::min(dense, graded(soft_rows(style) / 2, half, distance, kMildGrading));
}

}  // namespace

std::size_t affordable_unknowns() {
  // matrix, factors and cells, a generous estimate: a laminate of ten takes 230 MB on mesh 3
  constexpr double kBytesPerUnknown = 4096;
  constexpr double kMost = 3e6;
  const double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return static_cast<std::size_t>(std::clamp(memory / 2 / kBytesPerUnknown, 1e4, kMost));
}

CornerOrders corner_orders(bool mild_corners) {
  return mild_corners ? CornerOrders{kMildGrading, kMildRadialGrading}
                      : CornerOrders{kGrading, kGrading};
}

double halvings(int coarser, int finer, bool mild_corners) {
  return std::log2(static_cast<double>(fineness(finer, mild_corners)) /
                   fineness(coarser, mild_corners));
}

std::vector<double> even_edges(double a, double b, int n) {
  std::vector<double> x;
  x.reserve(static_cast<std::size_t>(n) + 1);
  for (int i = 0; i < n; ++i) x.push_back(a + (b - a) * i / n);
  x.push_back(b);
  return x;
}

// Edges divide the integral of the density evenly. A member that halves every cell of another
// therefore contains its edges.
std::vector<double> radial_edges(double radius, const MeshStyle& style) {
  if (!style.bonded) {
    return even_edges(0, radius, 2);  // two cells are exact for uniform strain
  }
  // Integrates over x, with the distance from the rim as its fourth power: the smallest cell then
  // has enough steps.
  constexpr int kSteps = 2048;
  constexpr double kPower = 4;
  const auto distance = [&](double x) { return radius * std::pow(x, kPower); };
  std::vector<double> sum{0};
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps;
    const double at = distance(x);
    const double per_m =
        style.mild_corners ? mild_density(at, radius, style) : density(at, radius, style);
    sum.push_back(sum.back() + per_m * kPower * at / x / kSteps);
  }
  const int cells = members(sum.back(), style);
  std::vector<double> edges{radius};
  std::size_t step = 0;
  for (int i = 1; i < cells; ++i) {
    const double share = sum.back() * i / cells;
    while (sum[step + 1] < share) ++step;
    const double part = (share - sum[step]) / (sum[step + 1] - sum[step]);
    edges.push_back(radius - distance((static_cast<double>(step) + part) / kSteps));
  }
  edges.push_back(0);
  std::reverse(edges.begin(), edges.end());
  return edges;
}

namespace {

// Maps places s from 0 to 1 in a block that is graded towards both of its faces to heights.
class Grading {
 public:
  Grading(double z0, double z1, double exponent) : z0_(z0), z1_(z1), exponent_(exponent) {}
  double height(double s) const {
    const double half = (z1_ - z0_) / 2;
    return s <= 0.5 ? z0_ + half * std::pow(2 * s, exponent_)
                    : z1_ - half * std::pow(2 - 2 * s, exponent_);
  }
  double place(double z) const {
    const double share = (z - z0_) / (z1_ - z0_);
    return share <= 0.5 ? std::pow(2 * share, 1 / exponent_) / 2
                        : 1 - std::pow(2 - 2 * share, 1 / exponent_) / 2;
  }

 private:
  double z0_, z1_, exponent_;
};

}  // namespace

// If an electrode lay inside a row, it would divide the strain of that row, which smooth shape
// functions cannot follow. The error would depend on where in the row the electrode lies, and that
// changes from member to member. So rows end at the cuts. Each part between two cuts has at least
// one row in the coarsest member, and its rows double in each finer one; otherwise the estimate
// would miss the error of these rows.
std::vector<double> axial_edges(double z0, double z1, bool stiff, const MeshStyle& style,
                                const std::vector<double>& cuts) {
  if (!style.bonded) return {z0, z1};
  if (stiff && style.mild_corners) {
    // one row can already bend and stretch, and its corners hold little of the energy
    return even_edges(z0, z1, 1 << std::max(style.refinement + 1, 0));
  }
  const Grading grading(z0, z1, axial_grading(style));
  std::vector<double> z{z0};
  double below = 0;
  const auto add_part = [&](double end_z, double end) {
    const int rows = stiff ? std::max(1, members(soft_rows(style), style) / 2)
                           : members(soft_rows(style) * (end - below), style);
    for (int i = 1; i < rows; ++i) {
      z.push_back(grading.height(below + (end - below) * i / rows));
    }
    z.push_back(end_z);
    below = end;
  };
  for (const double cut : cuts) add_part(cut, grading.place(cut));
  add_part(z1, 1);
  return z;
}

}  // namespace lcrig
