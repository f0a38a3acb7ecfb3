// SPDX-License-Identifier: Apache-2.0
// Assembles the equations of a stack, factorizes them and solves them by Newton's method. Both
// finite-element levels use it.
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
  FemSystem(const StackSpace& space, Kinematics kinematics);

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
  // success. keep_factor: reuse the present factorization, for linear problems. Gives up after
  // `most` iterations.
  Newton solve(double pressure_Pa, FemState& state, bool keep_factor = false,
               int most = kMostNewton);

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
  void find_twins();
  // Fills residual_ and condensed_, and stiffness_ if `tangent` is set.
  Residual assemble(const FemState& state, double pressure_Pa, bool tangent);
  std::optional<Step> direction(bool refactor);
  std::vector<double> pressure_step(const std::vector<double>& du) const;
  Residual line_search(double pressure_Pa, bool tangent, const Step& step, double start,
                       FemState& state);

  const StackSpace& space_;
  Kinematics kinematics_;
  std::vector<CellEquations> equations_;  // by cell
  std::vector<CellGeometry> geometry_;
  std::vector<ElasticLaw> laws_;
  std::vector<CellStiffness> stiffness_;
  std::vector<std::size_t> twins_;  // by cell: the first one that is equal but for its height
  std::vector<double> residual_;  // load minus internal force, pressures eliminated, N
  struct Condensed {  // what pressure_step needs of a cell
    std::array<std::array<double, kCellPressures>, kCellDofs> coupling;
    std::array<double, kCellPressures> lack;
    std::array<std::array<double, kCellPressures>, kCellPressures> gain;
  };
  std::vector<Condensed> condensed_;
  FrontalSolver solver_;
  bool factored_ = false;
};

}  // namespace lcrig
