// SPDX-License-Identifier: Apache-2.0
// Dense elimination in one front of FrontalSolver; CondensedCell uses it, too. Nearly all work of
// the finite-element levels happens here.
#pragma once

#include <cstddef>
#include <optional>

namespace lcrig {

// Rows of a tile. Tiles are always whole, so some of them reach into the padding of a column.
inline constexpr std::size_t kTileRows = 8;

// A symmetric matrix by columns. Only the lower triangle is valid; values above it are arbitrary.
// The first columns are to be eliminated, and their padding is zero.
struct FrontMatrix {
  std::size_t size, eliminated;
  double* first;  // the columns to be eliminated, each padded() long
  double* rest;  // the other columns without the first rows, each padded_rest() long

  static std::size_t padded(std::size_t rows) {
    return (rows + kTileRows - 1) / kTileRows * kTileRows;
  }
  std::size_t padded() const { return padded(size); }
  std::size_t padded_rest() const { return padded(size - eliminated); }
  // Element (i, j) is at [i].
  double* column(std::size_t j) const {
    return j < eliminated ? first + j * padded()
                          : rest + (j - eliminated) * padded_rest() - eliminated;
  }
};

// Replaces the first columns by those of L, with D on the diagonal, and the rest by what the
// elimination leaves of it. Reads up to kTileRows beyond the first columns. `scratch` must hold the
// first columns. Returns the smallest pivot. Returns nothing, and the matrix is useless, when a
// pivot is zero or not a number.
std::optional<double> eliminate(const FrontMatrix& matrix, double* scratch);

// Both use the columns of L that eliminate() made. The first subtracts what the first unknowns
// contribute to the others. The second does the reverse and also divides by D. x is padded with
// zeros, as the columns are.
void solve_forward(const FrontMatrix& matrix, double* x);
void solve_backward(const FrontMatrix& matrix, double* x);

}  // namespace lcrig
