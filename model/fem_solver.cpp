// SPDX-License-Identifier: Apache-2.0
#include "model/fem_solver.hpp"

namespace lcrig {

void SparseSolver::analyze(const Eigen::SparseMatrix<double>& lower) {
  ldlt_.analyzePattern(lower);
}
bool SparseSolver::factorize(const Eigen::SparseMatrix<double>& lower) {
  ldlt_.factorize(lower);
  if (ldlt_.info() != Eigen::Success) return false;
  positive_ = ldlt_.vectorD().minCoeff() > 0;
  return true;
}
std::vector<double> SparseSolver::solve(const std::vector<double>& rhs) const {
  const Eigen::Map<const Eigen::VectorXd> b(rhs.data(), static_cast<Eigen::Index>(rhs.size()));
  const Eigen::VectorXd x = ldlt_.solve(b);
  return {x.begin(), x.end()};
}

}  // namespace lcrig
