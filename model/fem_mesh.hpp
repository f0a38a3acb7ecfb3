// SPDX-License-Identifier: Apache-2.0
// Cells of the axisymmetric mesh: a tensor grid, graded towards the rim and towards bonded faces,
// where the stress of a bonded edge is singular.
#pragma once

#include <cstddef>
#include <vector>

#include "model/specimen.hpp"

namespace lcrig {

// What fits into half of the machine's memory, and never more than a few minutes of work.
std::size_t affordable_unknowns();

// How fine. 0 to 3 are the rows of `model ladder`; 1 is the default.
struct MeshSettings {
  int refinement = 1;
  std::size_t max_unknowns = affordable_unknowns();  // more is refused before work starts
};
inline constexpr int kFinestMesh = 3;

// n + 1 positions from a to b; cell sizes grow geometrically, `ratio` from the smallest to the
// largest, away from the named end.
enum class Fine { at_a, at_b, at_both, nowhere };
std::vector<double> graded(double a, double b, int n, Fine fine, double ratio);

struct MeshStyle {
  int refinement = 1;
  bool bonded = true;  // otherwise strains are uniform and one cell is exact
  bool alone = false;  // one block of one material: a disc, not a laminate
  bool finite = false;  // finite strain
};
// Radial cell edges, 0 to radius; `thinnest_m` is the thinnest soft block.
std::vector<double> radial_edges(double radius_m, double thinnest_m, const MeshStyle& style);
// Axial cell edges of a block of one material. `stiff` blocks (films) need fewer.
std::vector<double> axial_edges(double z0_m, double z1_m, double thinnest_m, bool stiff,
                                const MeshStyle& style);

}  // namespace lcrig
