// SPDX-License-Identifier: Apache-2.0
// The world behind a simulated frame, and a witness of what really happened there. Between two
// changes of its drive the force only rises or only falls, so looking at each change sees every
// extreme.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "drivers/zwick/sim.hpp"
#include "model/plant.hpp"

namespace lcrig {

// From one look to the next.
struct Extremes {
  Extremes() = default;
  double peak_N = 0;
  double top_m = -1e9, bottom_m = 1e9;
  double way_m = 0;  // there and back
  void add(double force_N, double travel_m) {
    peak_N = std::max(peak_N, force_N);
    top_m = std::max(top_m, travel_m);
    bottom_m = std::min(bottom_m, travel_m);
  }
};

class TruthScene final : public FrameScene {
 public:
  enum class Drive { travel, force, halt };
  struct Change {
    MonoTime at;
    Drive drive = Drive::halt;
    double from_m = 0, force_N = 0;  // there and then
    double to = 0;  // m or N
    bool is_towards = false;  // more travel, or more force
  };

  explicit TruthScene(Plant& plant) : plant_(plant) {
    last_m_ = plant.travel_m(MonoTime());
    all.add(0, last_m_);
  }

  Extremes all;  // of the run
  Extremes since;  // of what somebody began to watch
  std::vector<Change> changes;
  std::function<void(const Change&)> on_change;
  std::function<void(MonoTime)> on_look;

  // Also at the end, when nothing changes any more.
  void look(MonoTime t) {
    const double force = plant_.force_N(t), travel = plant_.travel_m(t);
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
    since.add(plant_.force_N(t), last_m_);
  }
  bool stands(MonoTime t) const {
    const auto arrival = plant_.arrival();
    return !arrival || *arrival <= t;
  }

  const PlantConfig& config() const override { return plant_.config(); }
  double travel_m(MonoTime t) const override { return plant_.travel_m(t); }
  double force_N(MonoTime t) const override { return plant_.force_N(t); }
  void move_to(MonoTime t, double travel_m, double speed_m_s) override {
    note(t, Drive::travel, travel_m, travel_m > plant_.travel_m(t));
    plant_.move_to(t, travel_m, speed_m_s);
  }
  void ramp_force(MonoTime t, double force_N, double rate_N_s) override {
    note(t, Drive::force, force_N, force_N > plant_.force_N(t));
    plant_.ramp_force(t, force_N, rate_N_s);
  }
  void halt(MonoTime t) override {
    note(t, Drive::halt, 0, false);
    plant_.halt(t);
  }
  std::optional<MonoTime> arrival() const override { return plant_.arrival(); }
  std::optional<MonoTime> force_crossing(double force_N, MonoTime from,
                                         MonoTime to) const override {
    return plant_.force_crossing(force_N, from, to);
  }
  double force_at_travel_N(double travel_m) const override {
    return plant_.force_at_travel_N(travel_m);
  }

 private:
  void note(MonoTime t, Drive drive, double to, bool towards) {
    look(t);
    Change change;
    change.at = t;
    change.drive = drive;
    change.from_m = last_m_;
    change.force_N = plant_.force_N(t);
    change.to = to;
    change.is_towards = towards;
    changes.push_back(change);
    if (on_change) on_change(changes.back());
  }

  Plant& plant_;
  double last_m_ = 0;
};

}  // namespace lcrig
