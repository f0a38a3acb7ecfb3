// SPDX-License-Identifier: Apache-2.0
#include "tests/property/reach.hpp"

#include <algorithm>
#include <cmath>

namespace lcrig::property {

double even(int at, double low, double high) {
  return low + (high - low) * at / 1000;
}
double scale(int at, double low, double high) {
  return low * std::pow(high / low, at / 1000.0);
}
double typed(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3);
  return std::floor(value / unit) * unit;
}
double typed_mm(double travel_m) {
  return std::round(travel_m * 1e6) * 1e-3;
}

Reach::Reach(const Recipe& recipe, const sim::RandomRig& rig)
    : recipe_(recipe), rig_(rig), caps_(rig.declared()), contact_(rig) {
  settle_forces();
  settle_search();
  settle_ways();
  const int s = base(1) % 100;
  if (may_press) {
    style = s < 75 ? Style::search : (s < 88 ? Style::stated : Style::blind);
  } else {
    style = s < 50 ? Style::stated : Style::blind;
  }
}

// Chooses the forces, and how far the specimen may give way.
void Reach::settle_forces() {
  limit_N = typed(even(base(0), 1.0, 0.6) * rig_.limit_N);
  zeroed = base(1) < 500;
  blind_N = 0.1 * rig_.limit_N + 6 * rig_.plant.force_noise_N;
  const double zero_N = 5 * rig_.plant.force_noise_N + 0.005 * limit_N;
  off_N = zeroed ? zero_N : blind_N;
  end_N = limit_N - off_N;
  most_N = 0.7 * end_N - off_N;
  least_N = std::min(2 * off_N + 10 * rig_.plant.force_noise_N, 0.9 * most_N);
  room_m = rig_.plant.travel_max_m - rig_.plant.contact_travel_m - 0.1e-3;
  while (most_N > least_N && likely_m(most_N) > 0.6 * room_m) most_N *= 0.7;
  may_press = contact_.is_bounded() && most_N > least_N;
  rise_N = std::max(12 * rig_.plant.force_noise_N, even(base(2), 0.02, 0.2) * end_N);
  if (rise_N > 0.6 * end_N || likely_m(rise_N) > 0.5 * room_m) may_press = false;
}

void Reach::settle_search() {
  const double fast = own_fastest_m_s(rig_, rise_N, rise_N + 0.4 * (end_N - rise_N));
  search_m_s = typed(std::min(kSlack * fast, 0.9 * caps_.speed_max.si()));
  if (search_m_s < 2 * caps_.speed_min.si()) may_press = false;
  if (!may_press) search_m_s = 0.1 * caps_.speed_max.si();
  slow_down = base(4) > 500;
  asked_m_s = search_m_s;
  if (slow_down) {
    asked_m_s = typed(std::min(scale(base(4), 1, 30) * search_m_s, caps_.speed_max.si()));
  }
  gap_m = std::max(std::min(rig_.gap_m, even(base(5), 0.2, 1) * kPatience_s * search_m_s), 2e-6);
}

void Reach::settle_ways() {
  // When the search reports contact, the probe is already inside the specimen.
  inside_m = 1.3 * (likely_m(rise_N) + own_stopping_way_m(rig_, search_m_s)) + 20e-6;
  const double above_m = rig_.plant.contact_travel_m - rig_.plant.travel_min_m;
  clear_m = typed(std::min(inside_m + even(base(3), 0.05e-3, 4e-3), 0.5 * above_m));
  if (clear_m < inside_m) may_press = false;
  depth_m = typed(std::max(0.8 * room_m, 1.2 * likely_m(most_N)));
  top_m = typed(std::max(2 * std::max(gap_m, clear_m), 1e-3) + 1e-3);
}

double Reach::likely_m(double force_N) const {
  const double frame_m = force_N / rig_.plant.frame_stiffness_N_m;
  const double true_m = rig_.specimen().shortening_m(force_N) + frame_m;
  return std::max(true_m, contact_.generous_way_m(force_N));
}

double Reach::pressure_kPa(double force_N) const {
  const double probe_m2 = 0.7853981633974483 * rig_.probe_diameter_m * rig_.probe_diameter_m;
  return force_N / probe_m2 * 1e-3;
}

double Reach::air_m_s(int at) const {
  const double most = 0.95 * caps_.speed_max.si();
  return typed(scale(at, std::min(20e-6, most), most));
}

double Reach::back_m() const {
  const double most = std::min({1e-3, 0.3 * kPatience_s * search_m_s, clear_m});
  return typed(std::max(even(base(8), 0.1, 1) * most, 1e-6) + inside_m);
}

double Reach::press_m_s(double force_N, double air_m, int at) const {
  if (!may_press) return 0;
  const double fast = kSlack * own_fastest_m_s(rig_, force_N + off_N, end_N);
  const double v = typed(std::min(even(at, 0.3, 1) * fast, 0.9 * caps_.speed_max.si()));
  const double way_m = air_m + likely_m(force_N);
  return v < 2 * caps_.speed_min.si() || way_m / v > 4 * kPatience_s ? 0 : v;
}

double Reach::ease_m_s(double force_N) const {
  const double fast = kSlack * own_fastest_m_s(rig_, 0, 0.3 * force_N);
  const double v = typed(std::min(fast, 0.9 * caps_.speed_max.si()));
  const bool slow = v < 2 * caps_.speed_min.si() || 2 * likely_m(limit_N) / v > 4 * kPatience_s;
  return slow ? 0 : v;
}

double Reach::blind_m_s() const {
  const double least = std::max(1e-3 * caps_.force_max.si(), 8 * rig_.plant.force_noise_N);
  return kSlack * own_fastest_m_s(rig_, least, end_N);
}

double Reach::free_m() const {
  return contact_.way_m(end_N) - contact_.way_m(rise_N + off_N);
}

const ForceLoop* Reach::loop() const {
  if (!caps_.force_hold) return nullptr;
  if (caps_.force_loop) return &*caps_.force_loop;
  return rig_.force_loop ? &*rig_.force_loop : nullptr;
}

bool Reach::loop_holds(double force_N) const {
  const ForceLoop* l = loop();
  return l != nullptr && contact_.is_bounded() &&
         contact_.stiffness_N_m(1.1 * force_N + off_N) < kSlack * l->stiffness_max.si();
}

bool Reach::loop_may_land(const ForceLoop& l) const {
  const double way_m = own_stopping_way_m(rig_, l.approach.si());
  return contact_.force_after_N(l.contact.si() + off_N, way_m) < kSlack * end_N;
}

double Reach::ramp_N_s(double force_N) const {
  const ForceLoop* l = loop();
  const double lag_s = l != nullptr ? to_seconds(l->lag) : 0.01;
  const double most = l != nullptr ? l->rate_max.si() : 5;
  const double room = end_N - force_N - off_N - (l != nullptr ? l->ripple.si() : 0);
  return std::min(kSlack * most, lag_s > 0 ? kSlack * room / lag_s : most);
}

}  // namespace lcrig::property
