// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/stored_frame.hpp"

namespace lcrig {

namespace {

StoredForceLoop stored_loop(const ForceLoop& loop) {
  StoredForceLoop out;
  out.approach_m_s = loop.approach.si();
  out.contact_N = loop.contact.si();
  out.rate_max_N_s = loop.rate_max.si();
  out.lag_s = to_seconds(loop.lag);
  out.ripple_N = loop.ripple.si();
  out.stiffness_max_N_m = loop.stiffness_max.si();
  return out;
}

ForceLoop force_loop(const StoredForceLoop& stored) {
  ForceLoop out;
  out.approach = Velocity::from_si(stored.approach_m_s);
  out.contact = Force::from_si(stored.contact_N);
  out.rate_max = ForceRate::from_si(stored.rate_max_N_s);
  out.lag = from_seconds(stored.lag_s);
  out.ripple = Force::from_si(stored.ripple_N);
  out.stiffness_max = Stiffness::from_si(stored.stiffness_max_N_m);
  return out;
}

// Copies what is stored as it is, in either direction.
template <class From, class To>
void copy_flags(const From& from, To& to) {
  to.motion = from.motion;
  to.force_hold = from.force_hold;
  to.device_stop = from.device_stop;
  to.weights = from.weights;
  to.force_channel = from.force_channel;
  to.travel_channel = from.travel_channel;
  to.zero_force = from.zero_force;
  to.zero_travel = from.zero_travel;
  to.sample_rate_max_Hz = from.sample_rate_max_Hz;
}

}  // namespace

StoredCapabilities stored_capabilities(const FrameCapabilities& c) {
  StoredCapabilities out;
  copy_flags(c, out);
  out.force_max_N = c.force_max.si();
  out.speed_min_m_s = c.speed_min.si();
  out.speed_max_m_s = c.speed_max.si();
  out.travel_min_m = c.travel_min.si();
  out.travel_max_m = c.travel_max.si();
  out.reaction_s = to_seconds(c.reaction);
  out.deceleration_m_s2 = c.deceleration.si();
  if (c.force_class) out.force_class_percent = c.force_class->percent();
  if (c.force_loop) out.force_loop = stored_loop(*c.force_loop);
  if (c.travel_step) out.travel_step_m = c.travel_step->si();
  if (c.force_step) out.force_step_N = c.force_step->si();
  if (c.filter) out.filter_s = to_seconds(*c.filter);
  if (c.play) out.play_m = c.play->si();
  return out;
}

FrameCapabilities frame_capabilities(const StoredCapabilities& s) {
  FrameCapabilities out;
  copy_flags(s, out);
  out.force_max = Force::from_si(s.force_max_N);
  out.speed_min = Velocity::from_si(s.speed_min_m_s);
  out.speed_max = Velocity::from_si(s.speed_max_m_s);
  out.travel_min = Length::from_si(s.travel_min_m);
  out.travel_max = Length::from_si(s.travel_max_m);
  out.reaction = from_seconds(s.reaction_s);
  out.deceleration = Acceleration::from_si(s.deceleration_m_s2);
  if (s.force_class_percent && is_force_class(*s.force_class_percent)) {
    out.force_class = ForceClass(*s.force_class_percent);
  }
  if (s.force_loop) out.force_loop = force_loop(*s.force_loop);
  if (s.travel_step_m) out.travel_step = Length::from_si(*s.travel_step_m);
  if (s.force_step_N) out.force_step = Force::from_si(*s.force_step_N);
  if (s.filter_s) out.filter = from_seconds(*s.filter_s);
  if (s.play_m) out.play = Length::from_si(*s.play_m);
  return out;
}

}  // namespace lcrig
