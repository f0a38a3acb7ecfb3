// SPDX-License-Identifier: Apache-2.0
// How the unloaded capacitance moves during a run: what is subtracted from every loaded reading.
// Private to analysis/.
#pragma once

#include <cstddef>
#include <vector>

namespace lcrig {

// A stretch without load: the baseline before contact, or the later half of a rest.
struct RestNode {
  double t_s = 0;  // mean time
  double fF = 0;  // mean
  double se_fF = 0;  // from the scatter of its readings and their correlation
  double readings = 0;
  std::size_t first = 0, last = 0;  // of RunData::readings; those between that count are the node's
};

// A line through the rests, plus the part of their deviations from it that noise cannot explain.
// The rest of the deviations would only carry the noise of the rests into the result. Constant
// before the first rest, along the line after the last.
class Drift {
 public:
  Drift() = default;
  explicit Drift(std::vector<RestNode> nodes);

  bool known() const { return nodes_.size() >= 2; }
  const std::vector<RestNode>& nodes() const { return nodes_; }
  double at(double t_s) const;  // fF, 0 at the first rest
  double rate_fF_s() const { return rate_; }
  // Standard error of the line's rate, from the deviations where they exceed the noise of the
  // rests.
  double rate_se_fF_s() const { return rate_se_; }
  double rate_freedom() const { return freedom_; }
  double rate_white_se_fF_s() const { return rate_white_; }  // from the noise of the rests alone
  std::vector<double> rate_influence() const;  // weight of each rest in the rate, 1/s
  double followed() const { return follow_; }  // part of the deviations that is subtracted, 0 to 1
  void follow(double part);
  // Weight of each rest in at(t_s).
  std::vector<double> influence(double t_s) const;

 private:
  double raw(double t_s) const;  // not yet 0 at the first rest

  std::vector<RestNode> nodes_;
  std::vector<double> deviations_;  // of the nodes from the line, fF
  double rate_white_ = 0, t_mean_ = 0, rate_ = 0, rate_se_ = 0, freedom_ = 0;
  double weights_ = 0, stt_ = 0;
  double follow_ = 0, zero_ = 0;
};

}  // namespace lcrig
