// SPDX-License-Identifier: Apache-2.0
// The equations of a stack at small strain: assembled from cells of any degree, factorized once and
// solved. Used by fem_linear.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

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
    double work = 0;  // of the last step, relative to that of the load
    std::string why;  // why it did not converge
  };
  // Displacements by equation under a unit pressure, m/Pa.
  Report solve(std::vector<double>& u);

 private:
  void find_kinds();
  // Fills residual_ and lack_ at u and the pressures.
  void evaluate(const std::vector<double>& u);
  void take_pressure_step(const std::vector<double>& step);
  // The displacements of a cell, without that of its last node, which is returned: its radial part.
  double gather(const std::vector<double>& u, std::size_t cell, double* local) const;
  // The volume that displacements add to each pressure of a cell.
  void add_volumes(const std::vector<double>& u, std::vector<double>& volumes) const;

  const StackSpace& space_;
  std::size_t dofs_, pressures_;  // of a cell
  std::vector<int> equations_;  // by cell
  std::vector<LinearCell> kinds_;  // cells that are equal but for their height are of one kind
  std::vector<std::size_t> kind_;  // by cell
  std::vector<double> p_, lack_;  // by cell: pressures, and what their volume equations lack
  std::vector<double> residual_;  // load minus forces, with the missing pressures, N
  FrontalSolver solver_;
};

}  // namespace lcrig
