// SPDX-License-Identifier: Apache-2.0
// Cells of the axisymmetric mesh: a tensor grid that is graded towards the rim and towards bonded
// faces, where the stress of a bonded edge is singular. There are two families of meshes. In each
// family every cell is halved from one member to the next, or to the next but one, so three members
// show how fast they converge. Used by LevelSettings, by the finite-element space and by the error
// estimates.
#pragma once

#include <cstddef>
#include <vector>

#include "base/enum_words.hpp"
#include "model/mesh_limit.hpp"

namespace lcrig {

// Number of unknowns that fits into half of the machine's memory and takes a few minutes at most.
std::size_t affordable_unknowns();

// The area that carries the charge when an electrode is stretched. reference: the printed disc.
// deformed: the stretched upper electrode, as a field solver on the deformed mesh would see it.
enum class ElectrodeArea { reference, deformed };
template <>
inline constexpr EnumWords<2> kWordsOf<ElectrodeArea>{"reference", "deformed"};

// How fine the mesh is. `model ladder` shows 0 to 3; 1 is the default.
struct MeshSettings {
  int refinement = 1;
  // Grade the corners only as far as fem_finite can bear, whose smallest cells would fold over.
  // fem_linear can use smaller ones.
  bool mild_corners = false;
  std::size_t max_unknowns = affordable_unknowns();  // a larger mesh is refused before work starts
  bool operator==(const MeshSettings&) const = default;
};
inline constexpr int kFinestMesh = 3;
inline constexpr int kFinestFiniteMesh = 2;  // at finite strain finer corners fold over early
inline constexpr int kCoarsestMember = -2;  // coarsest member of the family, for estimates
inline constexpr int kFinestMember = 5;  // finest member of the family, for references

// The orders at which a functional converges at the worst corner. There the displacement goes like
// the root of the distance, so the orders are the exponents of the gradings.
CornerOrders corner_orders(bool mild_corners);

// How often each cell of a member is halved in a finer one. From each member to the next this is
// once with mild corners, otherwise 0.58 and 0.42 times in turn (two cells become three, and three
// become four).
double halvings(int coarser, int finer, bool mild_corners);

// n + 1 positions from a to b, n cells of one size.
std::vector<double> even_edges(double a, double b, int n);

struct MeshStyle {
  int refinement = 1;
  bool bonded = true;  // otherwise strains are uniform and one cell is exact
  bool alone = false;  // one block of one material: a disc and not a laminate
  bool mild_corners = false;
  double thinnest_m = 1e9;  // thickness of the thinnest soft block
  std::vector<double> lengths_m;  // lengths of boundary layers at the rim
  // Degree of the displacement. Finite strain, with its mild corners, and uniform strain gain
  // nothing from a degree above two.
  int degree() const { return bonded && !mild_corners ? 4 : 2; }
};
// Radial cell edges, 0 to radius.
std::vector<double> radial_edges(double radius_m, const MeshStyle& style);
// Axial cell edges of a block of one material. Stiff blocks (films) need fewer. Each of `cuts`,
// where electrodes divide the block, is an edge of every member.
std::vector<double> axial_edges(double z0_m, double z1_m, bool stiff, const MeshStyle& style,
                                const std::vector<double>& cuts_m = {});

}  // namespace lcrig
