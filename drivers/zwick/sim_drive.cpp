// SPDX-License-Identifier: Apache-2.0
#include "drivers/zwick/sim_drive.hpp"

#include <cmath>

namespace lcrig::frame_link {

void SimDrive::set_reversed(MonoTime t, bool on) {
  if (on == reversed_) return;
  reversed_ = on;
  const auto arrival = world_.arrival();
  if (order_ && arrival && *arrival > t) obey(t);
}

void SimDrive::set_mirrored(MonoTime t, bool on) {
  if (on == mirror_m_.has_value()) return;
  mirror_m_ = on ? std::optional(world_.travel_m(t)) : std::nullopt;
  const auto arrival = world_.arrival();
  if (order_ && arrival && *arrival > t) obey(t);
}

void SimDrive::creep(MonoTime t, double speed_m_s) {
  const PlantConfig& p = world_.config();
  order_.reset();
  creeps_ = speed_m_s != 0;
  if (!creeps_) return world_.halt(t);
  world_.move_to(t, speed_m_s > 0 ? p.travel_max_m : p.travel_min_m, std::abs(speed_m_s));
}

void SimDrive::move_to(MonoTime t, double travel_m, double speed_m_s) {
  order_ = {false, travel_m, speed_m_s};
  obey(t);
}

void SimDrive::ramp_force(MonoTime t, double force_N, double rate_N_s) {
  order_ = {true, force_N, rate_N_s};
  obey(t);
}

void SimDrive::halt(MonoTime t) {
  order_.reset();
  creeps_ = false;
  world_.halt(t);
}

void SimDrive::obey(MonoTime t) {
  creeps_ = false;
  if (reversed_) return disobey(t);
  if (order_->is_force) return world_.ramp_force(t, order_->to, order_->rate);
  world_.move_to(t, seen_m(order_->to), order_->rate);
}

bool SimDrive::wants_more(MonoTime t) const {
  return order_->to > (order_->is_force ? world_.force_N(t) : world_.travel_m(t));
}

// The controller drives the wrong way, sees the distance to its target grow, and drives on to the
// end of travel.
void SimDrive::disobey(MonoTime t) {
  const PlantConfig& p = world_.config();
  const bool towards = !wants_more(t);
  if (order_->is_force && towards) {
    return world_.ramp_force(t, world_.force_at_travel_N(p.travel_max_m), order_->rate);
  }
  const double speed = order_->is_force ? p.force_approach_speed_m_s : order_->rate;
  world_.move_to(t, towards ? p.travel_max_m : p.travel_min_m, speed);
}

}  // namespace lcrig::frame_link
