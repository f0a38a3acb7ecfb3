// SPDX-License-Identifier: Apache-2.0
// Noise that is slower than one reading to the next: 1/f noise and a random walk beside the white
// one. How far it takes the mean of a part of the run, or a line through the rests, from what they
// would be without it. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

// The mean of neighbouring readings without a load.
struct QuietBlock {
  double t_s = 0, length_s = 0;  // its middle since the begin of the run
  double fF = 0;
  double share = 1;  // variance of the mean, if its noise were white, over that of one reading
  bool loaded_before = false;  // after the first loading
};

// Are the blocks after the first loading shifted by an unknown amount? Where they are, what lies
// between them and the baseline tells nothing of noise.
enum class AfterLoad { alike, shifted };

// The sizes of the parts are judged by the restricted likelihood of the blocks about a straight
// drift. No pair of sizes is picked: a run tells them badly, and the most likely pair is often that
// there is no slow noise. The error is a mixture over all of them, weighted with their likelihood.
class SlowNoise {
 public:
  SlowNoise() = default;
  // `run_s`: length of the run. Blocks in the order of time.
  SlowNoise(const std::vector<QuietBlock>& blocks, double run_s, AfterLoad after_load);

  bool known() const { return !candidates_.empty(); }
  // Error of sum(factor fF) against what it would be without any noise. The white part's variance
  // is at least `least_white`, that of the mean of all readings: outliers move it, and not the
  // blocks. `confidence` is that of the interval for which the degrees of freedom are right.
  SlopePart error_of(const std::vector<double>& factor, double least_white,
                     double confidence) const;

 private:
  struct Candidate {
    double likelihood = 0;  // all together 1
    double white = 0, flicker = 0, walk = 0;  // variances: a reading, an octave, a second; fF2
  };
  void weigh(AfterLoad after_load);
  double quantile(const std::vector<double>& variance, double confidence) const;

  std::vector<QuietBlock> blocks_;
  double slowest_s_ = 0, freedom_ = 0;
  Eigen::MatrixXd flicker_, walk_;  // covariances of the blocks, for unit size
  Eigen::VectorXd shares_;
  std::vector<Candidate> candidates_;
};

}  // namespace lcrig
