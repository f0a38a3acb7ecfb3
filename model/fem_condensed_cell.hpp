// SPDX-License-Identifier: Apache-2.0
// A cell of small strain with its inner nodes eliminated. Other cells do not share these nodes, so
// the elimination is done once for all cells that are alike. Used by LinearSystem.
#pragma once

#include <cstddef>
#include <vector>

#include "model/fem_front.hpp"
#include "model/fem_linear_cell.hpp"

namespace lcrig {

// The displacements of a cell, by their place in LinearCell: those of inner nodes first.
struct CellOrder {
  std::vector<std::size_t> all;
  std::size_t inner = 0;
};
CellOrder inner_nodes_first(int degree);

class CondensedCell {
 public:
  CondensedCell(const LinearCell& cell, const CellOrder& order);

  bool valid() const { return valid_; }  // false when a pivot is zero or not a number
  // Stiffness left for the outer displacements: lower triangle by rows.
  const double* stiffness() const { return outer_.data(); }
  // Both take vectors in the order of CellOrder, padded with zeros to padded(). forward() subtracts
  // from the outer forces what the inner ones contribute. backward() then finds the inner
  // displacements from the outer ones.
  void forward(double* x) { solve_forward(inner_part(nullptr), x); }
  void backward(double* x) { solve_backward(inner_part(nullptr), x); }
  std::size_t padded() const { return FrontMatrix::padded(size_); }

 private:
  FrontMatrix inner_part(double* rest) { return {size_, inner_, columns_.data(), rest}; }

  std::size_t size_, inner_;
  std::vector<double> columns_;  // columns of L for the inner displacements
  std::vector<double> outer_;
  bool valid_ = false;
};

}  // namespace lcrig
