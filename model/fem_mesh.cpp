// SPDX-License-Identifier: Apache-2.0
#include "model/fem_mesh.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace lcrig {
namespace {

// Sizes of mesh 1. They set what a mesh costs, not how fast the family converges.
constexpr double kRadialCells = 24;
constexpr double kSoftRows = 8;
// cells of mesh 1 per cell of the coarsest mesh
constexpr int kOfMesh1 = 1 << (1 - kCoarsestMember);

// The distance from a corner grows like s^q over evenly divided s. With q above 2/lambda, where
// lambda >= 0.5 is the exponent of the corner, corners converge as fast as smooth regions do.
constexpr double kRadialGrading = 3;
constexpr double kAxialGrading = 3;
// For finite strain: a corner folds over at a load that falls with the size of its cells, so
// smaller cells lose more than they gain.
constexpr double kMildGrading = 2;

// Cells per length of a boundary layer, up to this many lengths from the rim.
constexpr double kCellsPerLength = 2;
constexpr double kLengths = 4;

int members(double cells_of_mesh_1, const MeshStyle& style) {
  const int coarsest = std::max(1, static_cast<int>(std::lround(cells_of_mesh_1 / kOfMesh1)));
  return coarsest << (style.refinement - kCoarsestMember);
}

// A single block starts finer: it costs little, has all the error to itself, and capacitors may end
// anywhere in it. With mild corners it does not, because the cells would fold over early.
bool starts_finer(const MeshStyle& style) {
  return style.alone && !style.mild_corners;
}

double axial_grading(const MeshStyle& style) {
  return style.mild_corners ? kMildGrading : kAxialGrading;
}

// Cells of mesh 1 per unit of x. x is 0 at the rim and 1 at the axis, and the distance from the rim
// is radius x^kRadialGrading.
double radial_density(double x, double radius, const MeshStyle& style) {
  const double distance = radius * std::pow(x, kRadialGrading);
  const double slope = radius * kRadialGrading * std::pow(x, kRadialGrading - 1);
  double density = kRadialCells;
  for (const double length : style.lengths_m) {
    const double depth = distance / (kLengths * length);
    const double share = depth < 1 ? 1 : 1 / (depth * depth);
    density = std::max(density, kCellsPerLength / length * share * slope);
  }
  const double half = style.thinnest_m / 2;
  if (style.mild_corners && distance < half) {  // not finer than the rows at a face
    const double rows =
        kSoftRows / 2 / kMildGrading / half * std::pow(distance / half, 1 / kMildGrading - 1);
    density = std::min(density, rows * slope);
  }
  return density;
}

}  // namespace

std::size_t affordable_unknowns() {
  // Matrix, factors and cells, generously: a laminate of ten takes 230 MB on mesh 3.
  constexpr double kBytesPerUnknown = 4096;
  constexpr double kMost = 3e6;
  const double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return static_cast<std::size_t>(std::clamp(memory / 2 / kBytesPerUnknown, 1e4, kMost));
}

std::vector<double> even_edges(double a, double b, int n) {
  std::vector<double> x;
  x.reserve(static_cast<std::size_t>(n) + 1);
  for (int i = 0; i < n; ++i) x.push_back(a + (b - a) * i / n);
  x.push_back(b);
  return x;
}

// Edges at equal shares of the integral of the density, so every second edge of a mesh is an edge
// of the next coarser one.
std::vector<double> radial_edges(double radius, const MeshStyle& style) {
  if (!style.bonded) {
    return even_edges(0, radius, 2);  // two cells are exact for uniform strain
  }
  constexpr int kSteps = 2048;
  std::vector<double> sum{0};
  for (int i = 0; i < kSteps; ++i) {
    sum.push_back(sum.back() + radial_density((i + 0.5) / kSteps, radius, style) / kSteps);
  }
  const int cells = members((starts_finer(style) ? 2 : 1) * sum.back(), style);
  std::vector<double> edges{radius};
  std::size_t step = 0;
  for (int i = 1; i < cells; ++i) {
    const double share = sum.back() * i / cells;
    while (sum[step + 1] < share) ++step;
    const double part = (share - sum[step]) / (sum[step + 1] - sum[step]);
    const double x = (static_cast<double>(step) + part) / kSteps;
    edges.push_back(radius * (1 - std::pow(x, kRadialGrading)));
  }
  edges.push_back(0);
  std::reverse(edges.begin(), edges.end());
  return edges;
}

namespace {

// Places s from 0 to 1 in a block that is graded towards both of its faces, and their heights.
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

// An electrode inside of a row would weigh the strain of a part of it alone, which smooth shape
// functions cannot follow: the error would depend on where in its row the electrode happens to lie,
// and that changes from member to member. So rows end at the cuts, and each part between them has a
// row on the coarsest member and two for one on each finer one, or the estimate would not see what
// its rows err by.
std::vector<double> axial_edges(double z0, double z1, bool stiff, const MeshStyle& style,
                                const std::vector<double>& cuts) {
  if (!style.bonded) return {z0, z1};
  if (stiff) {  // one row can already bend and stretch, and its corners hold little of the energy
    return even_edges(z0, z1, 1 << std::max(style.refinement + 1, 0));
  }
  const Grading grading(z0, z1, axial_grading(style));
  std::vector<double> z{z0};
  double below = 0;
  const auto add_part = [&](double end_z, double end) {
    const int rows = members((starts_finer(style) ? 3 : 1) * kSoftRows * (end - below), style);
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
