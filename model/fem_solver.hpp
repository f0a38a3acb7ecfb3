// SPDX-License-Identifier: Apache-2.0
// Direct solution of the symmetric systems of FemSystem and LinearSystem: LDL^T by nested
// dissection of the tensor grid. The grid is halved again and again. Unknowns inside a part are
// eliminated there, in a dense matrix (its front). Those on the cut between two halves are
// eliminated after both halves.
#pragma once

#include <cstddef>
#include <vector>

#include "model/fem_front.hpp"

namespace lcrig {

// The equations of all cells, one cell after another, `dofs` to each; -1: fixed.
struct CellEquations {
  const std::vector<int>& all;
  std::size_t dofs;
};

class FrontalSolver {
 public:
  // Cells row by row, `columns` in each. Several nodes of a cell may have the same equation.
  void analyze(const CellEquations& cells, std::size_t columns, std::size_t equations);
  // `cells`: the lower triangle of each cell's stiffness, by rows. False when a pivot is zero or
  // not a number. There is no pivoting.
  bool factorize(const std::vector<const double*>& cells);
  std::vector<double> solve(const std::vector<double>& rhs);
  bool positive() const { return positive_; }  // every pivot of the last factorization is positive

 private:
  struct Part {  // part of the grid, in cells
    std::size_t left, right, bottom, top;
    bool contains(const Part& other) const;
  };
  struct Front {
    // Sorted by the order of elimination. The first `eliminated` are eliminated in this front, the
    // others in its parent, which has this front among its halves.
    std::vector<std::size_t> unknowns;
    std::size_t eliminated = 0;
    std::size_t rest() const { return unknowns.size() - eliminated; }
    std::size_t rest_memory() const { return rest() * FrontMatrix::padded(rest()); }
    std::vector<Front> halves;
    std::vector<std::size_t> places;  // places of the others among the unknowns of the parent front
    struct Cell {
      std::size_t index;
      std::vector<int> places;  // of its equations among the unknowns; -1: fixed
    };
    std::vector<Cell> cells;  // only in a part that is not halved
    std::size_t factor = 0;  // start of its columns in factor_
    std::size_t memory = 0;  // needed for the rests of the halves and everything below them
  };
  class Analysis;
  bool factorize(const Front& front, const std::vector<const double*>& cells, double* rest,
                 double* memory);
  FrontMatrix matrix_of(const Front& front, double* rest);
  double* gather(const Front& front, const std::vector<double>& x);
  void forward(const Front& front, std::vector<double>& x);
  void backward(const Front& front, std::vector<double>& x);

  std::vector<std::size_t> order_;  // of elimination, by equation
  Front whole_;
  std::vector<double> factor_;  // by front: the eliminated columns of L, with D on the diagonal
  std::vector<double> memory_, scratch_;
  bool positive_ = true;
};

}  // namespace lcrig
