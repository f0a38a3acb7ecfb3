// SPDX-License-Identifier: Apache-2.0
// The search for contact: its threshold, its speed, its longest way.
#include <algorithm>
#include <cmath>

#include "protocols/file/words.hpp"
#include "protocols/plan/planner.hpp"

namespace lcrig {

// Where the limits or the machine end, seen from here; infinite when nobody has said.
double Planner::window_end(double travel) const {
  const double machine = rig_.frame.travel_max.si();
  const double end = limits_.travel_max_m ? std::min(*limits_.travel_max_m, machine) : machine;
  if (rig_.start_travel || rig_.expected_contact) return std::max(0.0, end - travel);
  return rig_.frame.travel_max.si() - rig_.frame.travel_min.si();
}

// With slow_down: as fast as the file says, and no faster than half of the room up to the limit
// allows.
double Planner::slowed_down(const FindContactStep& s) {
  const double v = env_.get(s.speed), rise = env_.get(s.force), limit = limits_.force_max_N;
  if (!s.slow_down) return v;
  const double fastest = forecast_.fastest_m_s(rise, rise + 0.5 * (limit - rise));
  return std::max(std::min(v, fastest), std::min(v, rig_.frame.speed_min.si()));
}

// What the noise shows by itself is no contact.
void Planner::check_threshold(const FindContactStep& s, Outcome& out) {
  const double noise = force_noise_N(rig_).value_or(0), rise = env_.get(s.force);
  const double least = kContactSigmas * noise;
  if (!exceeds(least, rise)) return;
  out.refuse(
      Refusal(fmt::format("contact at {:.3g} N, but the load cell scatters by {:.3g} N (standard "
                          "deviation) while it rests: at least {:.3g} N, {:.0f} times that",
                          rise, noise, least, kContactSigmas),
              at_least(s.force, 1.05 * least, protocol_)));
}

Planner::Outcome Planner::on(const FindContactStep& s) {
  Outcome out;
  check_threshold(s, out);
  use_speed(s.speed, out);
  const double rise = env_.get(s.force), back = env_.get(s.back_off);
  const double v = slowed_down(s);
  Number speed = s.speed;
  if (v < env_.get(s.speed)) {
    add_note(out.note, fmt::format("slowed down to {:.3g} mm/s", v * 1e3));
    speed = Number(v);
  }
  const double approach = std::max(0.0, contact_ - travel_);
  if (contact_state_ == Contact::unknown && approach > 0) {
    add_note(out.note, fmt::format("assumes a gap of {:.3g} mm", approach * 1e3));
  }
  double longest = std::min(window_end(travel_), v * env_.get(s.timeout));
  if (s.within) longest = std::min(longest, env_.get(*s.within));
  add_note(out.note, fmt::format("searches at most {:.4g} mm", longest * 1e3));
  way_ = approach;
  out.seconds = approach / v + back / env_.get(s.speed) + kSearchStop_s;
  contact_state_ = Contact::unknown;  // nothing is measured yet
  go_to_force(rise, &s.force, out);
  check_stop(rise, speed, s.overshoot, s.timeout, out);
  check_timeout(s.timeout, out);
  if (rig_.found_contact) contact_ = rig_.found_contact->si();
  contact_state_ = Contact::found;
  forecast_.expect_measurement(rise);
  contact_N_ = forecast_.stop_N(rise, v);
  placed_ = placed_ || rig_.found_contact.has_value();
  if (placed_) limits_.place_contact(contact_);
  go_to_travel(travel_at(rise), nullptr, out);
  go_to_travel(contact_ - back, nullptr, out);
  force_ = 0;
  return out;
}

}  // namespace lcrig
