// SPDX-License-Identifier: Apache-2.0
// Polynomials through evenly spaced nodes on -1 to 1: the shape functions of the finite elements
// along one axis. fem_space and fem_linear_cell use them.
#pragma once

#include <array>
#include <cstddef>

namespace lcrig {

inline constexpr int kMostDegree = 4;
inline constexpr std::size_t kMostNodes = kMostDegree + 1;  // of a cell, along one axis

struct Lagrange {
  std::array<double, kMostNodes> value{}, slope{};  // by node; degree + 1 of them count
};

inline Lagrange lagrange(int degree, double x) {
  Lagrange result;
  const auto nodes = static_cast<std::size_t>(degree) + 1;
  const auto node = [&](std::size_t i) { return -1 + 2.0 * static_cast<double>(i) / degree; };
  for (std::size_t i = 0; i < nodes; ++i) {
    double value = 1, slope = 0;
    for (std::size_t j = 0; j < nodes; ++j) {
      if (j == i) continue;
      const double scale = 1 / (node(i) - node(j));
      slope = slope * (x - node(j)) * scale + value * scale;
      value *= (x - node(j)) * scale;
    }
    result.value[i] = value;
    result.slope[i] = slope;
  }
  return result;
}

}  // namespace lcrig
