// SPDX-License-Identifier: Apache-2.0
// Assembles the equations of a stack at finite strain, factorizes them and solves them by Newton's
// method. Used by fem_finite.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "model/fem_cell.hpp"
#include "model/fem_solver.hpp"
#include "model/fem_space.hpp"

namespace lcrig {

// Displacements by equation, m, and pressures by cell, Pa.
struct FemState {
  std::vector<double> u;
  std::vector<double> p;
};

class FemSystem {
 public:
  explicit FemSystem(const StackSpace& space);  // of degree two

  static constexpr int kMostNewton = 12;  // iterations
  FemState rest() const;  // undeformed
  struct Newton {
    bool converged = false;
    int iterations = 0;
    double residual = 0;  // displacement equations, relative to the load
    double defect = 0;  // volume equations, relative to their terms
    double min_j = 1;
    std::string why;  // why it did not converge
    std::vector<double> history;  // residual by iteration
  };
  // Goes from `state` to equilibrium under the pressure (Pa, dead). Changes `state` only on
  // success. Gives up after `most` iterations.
  Newton solve(double pressure_Pa, FemState& state, int most = kMostNewton);

  // False when the tangent of the last solve was not positive definite.
  bool stable() const { return solver_.positive(); }

 private:
  struct Residual {
    bool valid = false;
    double force = 0;  // relative to the load
    double defect = 0;  // of the volume equations, relative to their terms
    double min_j = 1;
  };
  struct Step {
    std::vector<double> du, dp;
  };
  void gather(const FemState& state, std::size_t cell, std::array<double, kCellDofs>& u,
              std::array<double, kCellPressures>& p) const;
  // Fills residual_, condensed_ and stiffness_.
  Residual assemble(const FemState& state, double pressure_Pa);
  std::optional<Step> direction();
  std::vector<double> pressure_step(const std::vector<double>& du) const;
  Residual line_search(double pressure_Pa, const Step& step, double start, FemState& state);

  const StackSpace& space_;
  std::vector<int> equations_;  // by cell
  std::vector<CellGeometry> geometry_;
  std::vector<ElasticLaw> laws_;
  using CellStiffness =
      std::array<double, kCellDofs*(kCellDofs + 1) / 2>;  // lower triangle, by rows
  std::vector<CellStiffness> stiffness_;
  std::vector<const double*> by_cell_;  // of stiffness_
  std::vector<double> residual_;  // load minus internal force, pressures eliminated, N
  struct Condensed {  // what pressure_step needs of a cell
    std::array<std::array<double, kCellPressures>, kCellDofs> coupling;
    std::array<double, kCellPressures> lack;
    std::array<std::array<double, kCellPressures>, kCellPressures> gain;
  };
  std::vector<Condensed> condensed_;
  FrontalSolver solver_;
};

// Carries a solution over to a finer mesh of the same stack, as a start for Newton's method. The
// state of `coarse` is interpolated at the nodes and in the cells of `fine`.
FemState prolong(const StackSpace& coarse, const FemState& state, const StackSpace& fine);

}  // namespace lcrig
