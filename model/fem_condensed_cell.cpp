// SPDX-License-Identifier: Apache-2.0
#include "model/fem_condensed_cell.hpp"

#include <algorithm>

namespace lcrig {

CellOrder inner_nodes_first(int degree) {
  const auto nodes = static_cast<std::size_t>(degree) + 1;
  CellOrder order;
  std::vector<std::size_t> outer;
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t a = 0; a < nodes; ++a) {
      const bool inside = i > 0 && i + 1 < nodes && a > 0 && a + 1 < nodes;
      for (const std::size_t component : {0U, 1U}) {
        (inside ? order.all : outer).push_back(2 * (i * nodes + a) + component);
      }
    }
  }
  order.inner = order.all.size();
  order.all.insert(order.all.end(), outer.begin(), outer.end());
  return order;
}

CondensedCell::CondensedCell(const LinearCell& cell, const CellOrder& order)
    : size_(cell.dofs),
      inner_(order.inner),
      columns_(FrontMatrix::padded(size_) * inner_ + kTileRows) {
  const std::size_t outer = size_ - inner_;
  std::vector<double> rest(outer * FrontMatrix::padded(outer)), scratch(columns_.size());
  const FrontMatrix matrix = inner_part(rest.data());
  for (std::size_t j = 0; j < size_; ++j) {
    double* column = matrix.column(j);
    for (std::size_t i = j; i < size_; ++i) {
      const auto [low, high] = std::minmax(order.all[i], order.all[j]);
      column[i] = cell.stiffness[high * (high + 1) / 2 + low];
    }
  }
  valid_ = eliminate(matrix, scratch.data()).has_value();
  outer_.reserve(outer * (outer + 1) / 2);
  for (std::size_t i = inner_; i < size_; ++i) {
    for (std::size_t j = inner_; j <= i; ++j) outer_.push_back(matrix.column(j)[i]);
  }
}

}  // namespace lcrig
