// SPDX-License-Identifier: Apache-2.0
// Direct solution of the sparse symmetric systems of FemSystem.
#pragma once

#include <Eigen/Sparse>
#include <vector>

namespace lcrig {

class SparseSolver {
 public:
  void analyze(const Eigen::SparseMatrix<double>& lower);
  bool factorize(const Eigen::SparseMatrix<double>& lower);
  std::vector<double> solve(const std::vector<double>& rhs) const;
  bool positive() const { return positive_; }  // every pivot of the last factorization is positive

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>> ldlt_;
  bool positive_ = true;
};

}  // namespace lcrig
