// SPDX-License-Identifier: Apache-2.0
// The equations of a stack at small strain: assembled from cells of any degree, factorized once and
// solved. Used by fem_linear.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "model/fem_condensed_cell.hpp"
#include "model/fem_linear_cell.hpp"
#include "model/fem_solver.hpp"
#include "model/fem_space.hpp"

namespace lcrig {

class LinearSystem {
 public:
  explicit LinearSystem(const StackSpace& space);

  struct Report {
    bool converged = false;
    int iterations = 0;
    double work = 0;  // work of the last step over that of the load
    std::string why;  // why it did not converge
  };
  // Displacements by equation under a unit pressure, m/Pa.
  Report solve(std::vector<double>& u);
  // Residuals at the solution. That of forces is relative to the load, that of volumes to the terms
  // whose difference they are.
  struct Balance {
    double force, volume;
  };
  Balance balance(const std::vector<double>& u);

 private:
  void find_kinds();
  void number_outer();
  // Displacements under the forces, by equation, from the factorized stiffness.
  std::vector<double> answer(const std::vector<double>& forces);
  // Fills residual_ and lack_ at u and the pressures.
  void evaluate(const std::vector<double>& u);
  void take_pressure_step(const std::vector<double>& step);
  // Collects the displacements of a cell relative to its last node, and returns the radial part of
  // that node's displacement.
  double gather(const std::vector<double>& u, std::size_t cell, double* local) const;
  // The volume that displacements add to each pressure of a cell.
  void add_volumes(const std::vector<double>& u, std::vector<double>& volumes) const;

  const StackSpace& space_;
  std::size_t dofs_, pressures_;  // of a cell
  std::vector<int> equations_;  // by cell
  std::vector<LinearCell> kinds_;  // one for all cells that are equal except for their height
  std::vector<std::size_t> kind_;  // by cell
  CellOrder order_;
  std::vector<CondensedCell> condensed_;  // by kind
  std::vector<std::size_t> outer_;  // equations of the nodes that do not lie inside a cell
  std::vector<int> outer_numbers_;  // by cell, then outer displacement: its place in outer_
  std::vector<double> p_, lack_;  // by cell: pressures, and the residual of their volume equations
  std::vector<double> residual_;  // load minus forces, with the missing pressures, N
  FrontalSolver solver_;
};

}  // namespace lcrig
