// SPDX-License-Identifier: Apache-2.0
// Closes a bracket around the root of a rising function by regula falsi with the Illinois weights:
// an end that stays counts half. Plant and the finite strain model look for a force with it.
#pragma once

namespace lcrig {

class Bracket {
 public:
  struct Trial {
    double at, error;  // error: of the function there, less what is wanted
  };
  // low.error < 0 < high.error
  Bracket(const Trial& low, const Trial& high) : low_(low), high_(high) {}

  // Where to try next: the zero of the straight line through both ends.
  double next() const {
    return (low_.at * high_.error - high_.at * low_.error) / (high_.error - low_.error);
  }
  void narrow(const Trial& tried) {
    const bool is_above = tried.error > 0;
    Trial& kept = is_above ? low_ : high_;
    (is_above ? high_ : low_) = tried;
    if (side_ == (is_above ? 1 : -1)) kept.error /= 2;
    side_ = is_above ? 1 : -1;
  }
  const Trial& low() const { return low_; }
  const Trial& high() const { return high_; }

 private:
  Trial low_, high_;
  int side_ = 0;  // the end that the latest trial replaced: -1 low, 1 high
};

}  // namespace lcrig
