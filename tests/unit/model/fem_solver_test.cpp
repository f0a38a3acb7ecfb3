// SPDX-License-Identifier: Apache-2.0
#include "model/fem_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "model/fem_cell.hpp"

namespace lcrig {
namespace {

using Eigen::Index;

// Cells that overlap as biquadratic elements do. The lowest line of nodes is fixed, and the
// highest moves as one.
struct Grid {
  std::size_t columns = 0, rows = 0, equations = 0;
  std::vector<int> cells;  // their equations
};

Grid make_grid(std::size_t columns, std::size_t rows) {
  Grid grid{columns, rows, 0, {}};
  const std::size_t width = 2 * columns + 1, height = 2 * rows + 1;
  const auto equation = [&](std::size_t line, std::size_t node, std::size_t component) {
    if (line == 0) return -1;
    if (line + 1 == height) node = 0;
    return static_cast<int>(2 * ((line - 1) * width + node) + component);
  };
  grid.equations = 2 * ((height - 2) * width + 1);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      for (std::size_t i = 0; i < kCellDofs; ++i) {
        const std::size_t node = i / 2;
        grid.cells.push_back(equation(2 * row + node / 3, 2 * column + node % 3, i % 2));
      }
    }
  }
  return grid;
}

using CellStiffness = std::array<double, kCellDofs*(kCellDofs + 1) / 2>;

std::vector<const double*> by_cell(const std::vector<CellStiffness>& cells) {
  std::vector<const double*> result;
  for (const CellStiffness& cell : cells) result.push_back(cell.data());
  return result;
}

// Symmetric and positive definite.
std::vector<CellStiffness> some_stiffness(const Grid& grid) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<CellStiffness> cells(grid.cells.size() / kCellDofs);
  for (CellStiffness& cell : cells) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < kCellDofs; ++i) {
      for (std::size_t j = 0; j <= i; ++j) cell[k++] = any(random) + (i == j ? 30 : 0);
    }
  }
  return cells;
}

Eigen::MatrixXd whole_matrix(const Grid& grid, const std::vector<CellStiffness>& stiffness) {
  const auto n = static_cast<Index>(grid.equations);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t c = 0; c < stiffness.size(); ++c) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < kCellDofs; ++i) {
      for (std::size_t j = 0; j <= i; ++j, ++k) {
        const int row = grid.cells[kCellDofs * c + i], column = grid.cells[kCellDofs * c + j];
        if (row < 0 || column < 0) continue;
        matrix(row, column) += stiffness[c][k];
        if (i != j) matrix(column, row) += stiffness[c][k];
      }
    }
  }
  return matrix;
}

// The largest error of the solution for an arbitrary right side.
double error_of(FrontalSolver& solver, const Eigen::MatrixXd& matrix) {
  std::vector<double> right(static_cast<std::size_t>(matrix.rows()));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (double& value : right) value = any(random);
  const auto found = solver.solve(right);
  const Eigen::Map<const Eigen::VectorXd> b(right.data(), matrix.rows());
  const Eigen::Map<const Eigen::VectorXd> x(found.data(), matrix.rows());
  const Eigen::VectorXd exact = matrix.partialPivLu().solve(b);
  return (x - exact).lpNorm<Eigen::Infinity>() / exact.lpNorm<Eigen::Infinity>();
}

class GridSizes : public testing::TestWithParam<std::pair<std::size_t, std::size_t>> {};

TEST_P(GridSizes, SolutionIsThatOfTheWholeMatrix) {
  const Grid grid = make_grid(GetParam().first, GetParam().second);
  const auto stiffness = some_stiffness(grid);
  FrontalSolver solver;
  solver.analyze({grid.cells, kCellDofs}, grid.columns, grid.equations);
  for (int again = 0; again < 2; ++again) {  // a second factorization starts from nothing
    ASSERT_TRUE(solver.factorize(by_cell(stiffness)));
    EXPECT_TRUE(solver.positive());
    EXPECT_LT(error_of(solver, whole_matrix(grid, stiffness)), 1e-12);
  }
}

TEST_P(GridSizes, NegativePivotsAreTakenAndTold) {
  const Grid grid = make_grid(GetParam().first, GetParam().second);
  auto stiffness = some_stiffness(grid);
  for (double& value : stiffness.back()) value = -value;
  FrontalSolver solver;
  solver.analyze({grid.cells, kCellDofs}, grid.columns, grid.equations);
  ASSERT_TRUE(solver.factorize(by_cell(stiffness)));
  EXPECT_FALSE(solver.positive());
  EXPECT_LT(error_of(solver, whole_matrix(grid, stiffness)), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(All, GridSizes,
                         testing::Values(std::pair{1, 1}, std::pair{2, 1}, std::pair{1, 9},
                                         std::pair{3, 2}, std::pair{5, 7}, std::pair{12, 4}));

TEST(FrontalSolver, ZeroPivotIsRefused) {
  const Grid grid = make_grid(3, 3);
  const std::vector<CellStiffness> nothing(grid.cells.size() / kCellDofs, CellStiffness{});
  FrontalSolver solver;
  solver.analyze({grid.cells, kCellDofs}, grid.columns, grid.equations);
  EXPECT_FALSE(solver.factorize(by_cell(nothing)));
}

}  // namespace
}  // namespace lcrig
