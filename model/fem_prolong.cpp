// SPDX-License-Identifier: Apache-2.0
#include "model/fem_system.hpp"

namespace lcrig {
namespace {

// A place in a mesh of cells along one axis: the cell, and the position in it from -1 to 1.
struct CellPlace {
  std::size_t cell;
  double at;
};

// The place of x in the cell that contains `inside`. `nodes`: two for each cell and one more.
CellPlace place_of(const std::vector<double>& nodes, double inside, double x) {
  std::size_t cell = 0;
  while (2 * cell + 4 < nodes.size() && nodes[2 * cell + 2] < inside) ++cell;
  const double low = nodes[2 * cell], high = nodes[2 * cell + 2];
  return {cell, (2 * x - low - high) / (high - low)};
}

double quadratic(const std::vector<double>& values, const CellPlace& place) {
  const double* v = values.data() + 2 * place.cell;
  const double x = place.at;
  return v[0] * x * (x - 1) / 2 + v[1] * (1 - x * x) + v[2] * x * (x + 1) / 2;
}

// The height z in that row of `space` in which a row of another mesh lies.
Height height_in(const StackSpace& space, const StackSpace::Row& row, double z) {
  Height height = space.height((row.z0 + row.z1) / 2);
  const auto& in = space.rows()[static_cast<std::size_t>(height.row)];
  height.zeta = (2 * z - in.z0 - in.z1) / (in.z1 - in.z0);
  return height;
}

void prolong_row(const StackSpace& coarse, const FemState& state, const StackSpace& fine,
                 const StackSpace::Row& row, const std::vector<CellPlace>& nodes,
                 FemState& result) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double z = row.z0 + (row.z1 - row.z0) * static_cast<double>(k) / 2;
    const Height height = height_in(coarse, row, z);
    for (const int component : {0, 1}) {
      const auto line = coarse.displacement(state.u, height, component);
      for (std::size_t node = 0; node < nodes.size(); ++node) {
        const int equation = fine.equation(row.line[k], static_cast<int>(node), component);
        if (equation < 0) continue;
        result.u[static_cast<std::size_t>(equation)] = quadratic(line, nodes[node]);
      }
    }
  }
}

// The pressures of one row, which are linear in each cell.
void prolong_pressures(const StackSpace& coarse, const FemState& state, const StackSpace& fine,
                       const StackSpace::Row& row, double* to) {
  const auto& r = fine.radii();
  const Height low = height_in(coarse, row, row.z0), high = height_in(coarse, row, row.z1);
  for (std::size_t node = 0; node + 2 < r.size(); node += 2, to += kCellPressures) {
    const CellPlace left = place_of(coarse.radii(), r[node + 1], r[node]);
    const CellPlace right = place_of(coarse.radii(), r[node + 1], r[node + 2]);
    const auto columns = static_cast<std::size_t>(coarse.cells_per_row());
    const double* from =
        state.p.data() + kCellPressures * (static_cast<std::size_t>(low.row) * columns + left.cell);
    to[0] = from[0] + from[1] * (left.at + right.at) / 2 + from[2] * (low.zeta + high.zeta) / 2;
    to[1] = from[1] * (right.at - left.at) / 2;
    to[2] = from[2] * (high.zeta - low.zeta) / 2;
  }
}

}  // namespace

FemState prolong(const StackSpace& coarse, const FemState& state, const StackSpace& fine) {
  const auto columns = static_cast<std::size_t>(fine.cells_per_row());
  FemState result{std::vector<double>(static_cast<std::size_t>(fine.equations())),
                  std::vector<double>(kCellPressures * columns * fine.rows().size())};
  double* pressures = result.p.data();
  std::vector<CellPlace> nodes;
  for (const double r : fine.radii()) nodes.push_back(place_of(coarse.radii(), r, r));
  for (const auto& row : fine.rows()) {
    prolong_row(coarse, state, fine, row, nodes, result);
    prolong_pressures(coarse, state, fine, row, pressures);
    pressures += kCellPressures * columns;
  }
  return result;
}

}  // namespace lcrig
