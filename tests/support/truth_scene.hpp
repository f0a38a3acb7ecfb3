// SPDX-License-Identifier: Apache-2.0
// The world behind a simulated frame, with a record of what really happened. Between two changes of
// the drive the force only rises or only falls, so a look at each change finds every extreme. Used
// by RigInstruments.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"

namespace lcrig {

// Extremes over some time.
struct Extremes {
  Extremes() = default;
  double peak_N = 0;
  double top_m = -1e9, bottom_m = 1e9;
  double way_m = 0;  // total distance, forwards and backwards
  void add(double force_N, double travel_m) {
    peak_N = std::max(peak_N, force_N);
    top_m = std::max(top_m, travel_m);
    bottom_m = std::min(bottom_m, travel_m);
  }
};

class TruthScene final : public PlantScene {
 public:
  enum class Drive { travel, force, halt };
  struct Change {
    MonoTime at;
    Drive drive = Drive::halt;
    double from_m = 0, force_N = 0;  // at that instant
    double to = 0;  // m or N
    bool is_towards = false;  // more travel, or more force
  };

  explicit TruthScene(Plant& plant) : PlantScene(plant), last_m_(plant.travel_m(MonoTime())) {
    all.add(0, last_m_);
  }

  Extremes all;  // since the beginning
  Extremes since;  // since the last watch_anew
  std::vector<Change> changes;
  std::function<void(const Change&)> on_change;
  std::function<void(MonoTime)> on_look;

  // Called at each change. Call it at the end as well, when nothing changes any more.
  void look(MonoTime t) {
    const double force = force_N(t), travel = travel_m(t);
    const double way = std::abs(travel - last_m_);
    for (Extremes* e : {&all, &since}) {
      e->add(force, travel);
      e->way_m += way;
    }
    last_m_ = travel;
    if (on_look) on_look(t);
  }
  void watch_anew(MonoTime t) {
    look(t);
    since = Extremes();
    since.add(force_N(t), last_m_);
  }
  bool stands(MonoTime t) const {
    const auto end = arrival();
    return !end || *end <= t;
  }

  void move_to(MonoTime t, double to_m, double speed_m_s) override {
    note(t, Drive::travel, to_m, to_m > travel_m(t));
    PlantScene::move_to(t, to_m, speed_m_s);
  }
  void ramp_force(MonoTime t, double to_N, double rate_N_s) override {
    note(t, Drive::force, to_N, to_N > force_N(t));
    PlantScene::ramp_force(t, to_N, rate_N_s);
  }
  void halt(MonoTime t) override {
    note(t, Drive::halt, 0, false);
    PlantScene::halt(t);
  }

 private:
  void note(MonoTime t, Drive drive, double to, bool towards) {
    look(t);
    Change change;
    change.at = t;
    change.drive = drive;
    change.from_m = last_m_;
    change.force_N = force_N(t);
    change.to = to;
    change.is_towards = towards;
    changes.push_back(change);
    if (on_change) on_change(changes.back());
  }

  double last_m_;
};

}  // namespace lcrig
