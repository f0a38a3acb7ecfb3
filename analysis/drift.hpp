// SPDX-License-Identifier: Apache-2.0
// Models how the unloaded capacitance moves during a run. The analysis subtracts this drift from
// every loaded reading. Private to analysis/.
#pragma once

#include <cstddef>
#include <vector>

namespace lcrig {

// One stretch without load: the baseline before contact, or the later half of a rest.
struct RestNode {
  double t_s = 0;  // mean time
  double fF = 0;  // mean
  double se_fF = 0;  // from the scatter of its readings and their correlation
  double readings = 0;
  std::size_t first = 0, last = 0;  // of RunData::readings; not all of these count
};

// A straight line through the rests, plus that part of the rests' deviations from it which noise
// cannot explain. Subtracting all of the deviations would carry the noise of the rests into the
// result. Before the first rest the drift is constant; after the last it follows the line.
class Drift {
 public:
  Drift() = default;
  explicit Drift(std::vector<RestNode> nodes);

  bool known() const { return nodes_.size() >= 2; }
  const std::vector<RestNode>& nodes() const { return nodes_; }
  double at(double t_s) const;  // fF, 0 at the first rest
  double rate_fF_s() const { return rate_; }
  // Standard error of the line's rate. It comes from the deviations of the rests from the line
  // where these exceed the noise of the rests.
  double rate_se_fF_s() const { return rate_se_; }
  double rate_freedom() const { return freedom_; }
  double rate_white_se_fF_s() const { return rate_white_; }  // from the noise of the rests alone
  std::vector<double> rate_influence() const;  // weight of each rest in the rate, 1/s
  double followed() const { return follow_; }  // part of the deviations that is subtracted, 0 to 1
  void follow(double part);
  // Weight of each rest in at(t_s).
  std::vector<double> influence(double t_s) const;

 private:
  double raw(double t_s) const;  // before the shift that makes it 0 at the first rest

  std::vector<RestNode> nodes_;
  std::vector<double> deviations_;  // of the nodes from the line, fF
  double rate_white_ = 0, t_mean_ = 0, rate_ = 0, rate_se_ = 0, freedom_ = 0;
  double weights_ = 0, stt_ = 0;
  double follow_ = 0, zero_ = 0;
};

}  // namespace lcrig
