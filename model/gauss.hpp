// SPDX-License-Identifier: Apache-2.0
// Gauss quadrature with five points on -1 to 1, exact to degree nine. Used by the finite elements.
#pragma once

#include <array>

namespace lcrig {

struct GaussPoint {
  double x, weight;
};
inline constexpr std::array<GaussPoint, 5> kGauss5{{{-0.9061798459386640, 0.2369268850561891},
                                                    {-0.5384693101056831, 0.4786286704993665},
                                                    {0, 0.5688888888888889},
                                                    {0.5384693101056831, 0.4786286704993665},
                                                    {0.9061798459386640, 0.2369268850561891}}};

}  // namespace lcrig
