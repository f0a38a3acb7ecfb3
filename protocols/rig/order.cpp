// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/order.hpp"

namespace lcrig {

WatchInputEvent to_input(const Order& m) {
  WatchInputEvent e(WatchInput::order);
  e.direction = m.direction;
  e.speed_m_s = m.speed_m_s;
  e.rate_N_s = m.rate_N_s;
  e.force_N = m.force_N;
  e.force_known = m.force_known;
  e.rest_N = m.zero_N;
  e.free_N = m.free_N;
  e.against_N = m.against_N;
  e.drift_N_s = m.drift_N_s;
  e.waver_N = m.loop_N;
  e.target_m = m.target_m;
  e.threshold_N = m.to_N;
  e.holds = m.holds;
  e.worst_N = m.worst_N;
  return e;
}

Order order_of(const WatchInputEvent& e) {
  Order m;
  m.direction = e.direction.value_or(0);
  m.speed_m_s = e.speed_m_s.value_or(0);
  m.rate_N_s = e.rate_N_s.value_or(0);
  m.force_N = e.force_N.value_or(0);
  m.force_known = e.force_known.value_or(true);
  m.zero_N = e.rest_N.value_or(0);
  m.free_N = e.free_N;
  m.against_N = e.against_N.value_or(0);
  m.drift_N_s = e.drift_N_s.value_or(0);
  m.loop_N = e.waver_N.value_or(0);
  m.target_m = e.target_m;
  m.to_N = e.threshold_N;
  m.holds = e.holds.value_or(false);
  m.worst_N = e.worst_N;
  return m;
}

WatchInputEvent to_input(const Permit& permit) {
  WatchInputEvent e(WatchInput::permit);
  e.threshold_N = permit.threshold_N;
  e.limit_N = permit.limits.force_max.si();
  e.worst_N = permit.worst_N;
  e.expected_N = permit.expected_N;
  e.presses = permit.presses;
  e.travel_m = permit.from_m;
  return e;
}

Permit permit_of(const WatchInputEvent& e) {
  Permit p;
  p.threshold_N = e.threshold_N;
  p.limits.force_max = Force::from_si(e.limit_N.value_or(0));
  p.worst_N = e.worst_N.value_or(0);
  p.expected_N = e.expected_N;
  p.presses = e.presses.value_or(false);
  p.from_m = e.travel_m;
  return p;
}

}  // namespace lcrig
