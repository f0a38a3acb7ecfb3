// SPDX-License-Identifier: Apache-2.0
// The drive of the simulated machine (sim_machine.hpp), between its controller and the scene. It
// obeys or, as a fault, runs the other way or creeps.
#pragma once

#include <optional>

#include "drivers/zwick/sim.hpp"

namespace lcrig::frame_link {

class SimDrive final : public FrameScene {
 public:
  explicit SimDrive(FrameScene& world) : world_(world) {}

  // Also reverses a motion under way.
  void set_reversed(MonoTime t, bool on);
  // From here on it moves to the other side by as much as it shows.
  void set_mirrored(MonoTime t, bool on);
  // Positive: towards the specimen. Creeps until it is halted or told to move.
  void creep(MonoTime t, double speed_m_s);
  bool is_creeping() const { return creeps_; }
  // It runs away from its target and will never arrive.
  bool is_astray() const { return order_ && reversed_; }
  bool is_backwards() const { return is_astray() || mirror_m_; }

  const PlantConfig& config() const override { return world_.config(); }
  double travel_m(MonoTime t) const override { return seen_m(world_.travel_m(t)); }
  double force_N(MonoTime t) const override { return world_.force_N(t); }
  void move_to(MonoTime t, double travel_m, double speed_m_s) override;
  void ramp_force(MonoTime t, double force_N, double rate_N_s) override;
  void halt(MonoTime t) override;
  std::optional<MonoTime> arrival() const override { return world_.arrival(); }
  std::optional<MonoTime> force_crossing(double force_N, MonoTime from,
                                         MonoTime to) const override {
    return world_.force_crossing(force_N, from, to);
  }
  double force_at_travel_N(double travel_m) const override {
    return world_.force_at_travel_N(seen_m(travel_m));
  }

 private:
  struct Order {
    bool is_force = false;
    double to = 0, rate = 0;  // m and m/s, or N and N/s
  };
  void obey(MonoTime t);
  void disobey(MonoTime t);
  // The travel that is shown of a true one, and the other way round.
  double seen_m(double travel_m) const { return mirror_m_ ? 2 * *mirror_m_ - travel_m : travel_m; }
  bool wants_more(MonoTime t) const;  // the target lies above the present travel or force

  FrameScene& world_;
  bool reversed_ = false, creeps_ = false;
  std::optional<double> mirror_m_;
  std::optional<Order> order_;  // empty after a halt
};

}  // namespace lcrig::frame_link
