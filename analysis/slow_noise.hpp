// SPDX-License-Identifier: Apache-2.0
// Noise that is slower than the time between readings: 1/f noise and a random walk in addition to
// white noise. Estimates the error that it causes in the mean of a part of the run, and in a line
// through the rests. Private to analysis/.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig {

// The mean of neighbouring readings without a load.
struct QuietBlock {
  double t_s = 0, length_s = 0;  // t_s: its middle, since the start of the run
  double fF = 0;
  double share = 1;  // if the noise were white: variance of the mean over that of one reading
  bool loaded_before = false;  // the block lies after the first loading
};

// Tells whether a load has shifted the blocks after it by an unknown amount. If it has, the
// difference between them and the baseline says nothing about the noise.
enum class AfterLoad { alike, shifted };

// Judges sizes of the slow parts by the restricted likelihood of the blocks about a straight drift.
// A run tells the sizes badly, and the most likely pair is often no slow noise at all. So the error
// is a mixture over all pairs, weighted with their likelihood.
class SlowNoise {
 public:
  SlowNoise() = default;
  // `run_s`: length of the run. The blocks must be in the order of time.
  SlowNoise(const std::vector<QuietBlock>& blocks, double run_s, AfterLoad after_load);

  bool known() const { return !candidates_.empty(); }
  // Error of sum(factor fF) relative to its value without any noise. `least_white` is the variance
  // of the mean of all readings, and the least for the white part: outliers affect it but not the
  // blocks. The degrees of freedom are right for the interval of this `confidence`.
  SlopePart error_of(const std::vector<double>& factor, double least_white,
                     double confidence) const;

 private:
  struct Candidate {
    double likelihood = 0;  // normalised: the sum over all candidates is 1
    double white = 0, flicker = 0, walk = 0;  // variances of a reading, an octave, a second, fF2
  };
  void weigh(AfterLoad after_load);
  double quantile(const std::vector<double>& variance, double confidence) const;

  std::vector<QuietBlock> blocks_;
  double slowest_s_ = 0, freedom_ = 0;
  Eigen::MatrixXd flicker_, walk_;  // covariances of the blocks, for a part of size 1
  Eigen::VectorXd shares_;
  std::vector<Candidate> candidates_;
};

}  // namespace lcrig
