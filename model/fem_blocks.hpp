// SPDX-License-Identifier: Apache-2.0
// Divides a stack into blocks that are one continuum each, and gives the lengths over which their
// fields change. The mesh of the finite-element levels is built from both.
#pragma once

#include <cstddef>
#include <vector>

#include "model/specimen.hpp"

namespace lcrig {

// Layers that form one continuum, or one rigid layer. Heights in m from the base.
struct Block {
  double z0, z1;
  std::size_t material;
  bool rigid;
  std::vector<double> cuts;  // heights at which one capacitor ends and the next one begins
};
std::vector<Block> find_blocks(const Specimen& specimen);

// Reach from the rim, m, of the boundary layers that are longer than the layers are thick: the
// pressure of each bonded sheet, and the bending of each film on it. Lengths over half of the
// radius are left out, because they are not boundary layers. docs/model.md, "Meshes".
std::vector<double> decay_lengths_m(const Specimen& specimen, const std::vector<Block>& blocks);

// Thickness of the thinnest soft block, m; huge when there is none.
double thinnest_soft_m(const Specimen& specimen, const std::vector<Block>& blocks);

}  // namespace lcrig
