// SPDX-License-Identifier: Apache-2.0
// A contact that is hard to measure on the way back: the drive has lost motion, and the force of
// the specimen falls at constant travel, as if the way back had begun to unload it.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/time.hpp"

namespace lcrig {

struct RelaxingRig {
  double stiffness_N_m = 400e3;  // once it has relaxed
  double falls = 0.35;  // part of the force
  double relaxes_s = 1.4;  // time constant
  double play_m = 3.3e-6;
  double felt_N = 0.4;  // where the search stopped
  double approach_s = 0.06;  // from the first touch to there
  double quick_N_m() const { return stiffness_N_m / (1 - falls); }
};

class RelaxingContact {
 public:
  // Drives in from the first touch at constant speed, until now.
  RelaxingContact(const RelaxingRig& rig, double contact_m, MonoTime now)
      : rig_(rig), contact_m_(contact_m), at_m_(contact_m), last_(now) {
    constexpr int kSteps = 1000;
    const double step_m = rig.felt_N / rig.stiffness_N_m / kSteps;
    while (felt_N() < rig.felt_N) {
      relax(rig.approach_s / kSteps);
      move(at_m_ + step_m);
    }
  }
  double touched_m() const { return at_m_; }
  double force_at(double travel_m, MonoTime now) {
    relax(to_seconds(now - last_));
    last_ = now;
    move(std::clamp(at_m_, travel_m, travel_m + rig_.play_m));
    return felt_N();
  }
  double depth_m() const { return at_m_ - contact_m_; }

 private:
  double felt_N() const {
    const double elastic_N = rig_.stiffness_N_m * std::max(0.0, depth_m());
    return depth_m() > 0 ? std::max(0.0, elastic_N + branch_N_) : 0;
  }
  void relax(double s) { branch_N_ *= std::exp(-s / rig_.relaxes_s); }
  void move(double to_m) {
    const double way_m = std::max(to_m, contact_m_) - std::max(at_m_, contact_m_);
    branch_N_ += (rig_.quick_N_m() - rig_.stiffness_N_m) * way_m;
    at_m_ = to_m;
  }

  const RelaxingRig rig_;
  const double contact_m_;
  double at_m_;
  double branch_N_ = 0;  // of the part that relaxes
  MonoTime last_;
};

}  // namespace lcrig
