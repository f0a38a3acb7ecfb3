// SPDX-License-Identifier: Apache-2.0
// Examines the equations of small strain where fem_linear has solved them. For tests of the finite
// elements.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "model/fem_linear_system.hpp"

namespace lcrig {

inline void expect_balance(const Specimen& specimen, int mesh, const std::string& what,
                           double most_force = 1e-10) {
  const auto space = StackSpace::make(specimen, MeshSettings{mesh}, false);
  ASSERT_TRUE(space) << space.error().what;
  LinearSystem system(*space);
  std::vector<double> u;
  ASSERT_TRUE(system.solve(u).converged) << what;
  const auto balance = system.balance(u);
  EXPECT_LE(balance.force, most_force) << what;
  EXPECT_LE(balance.volume, 1e-10) << what;
}

}  // namespace lcrig
