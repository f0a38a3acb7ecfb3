// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/press_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lcrig {

namespace {

// Fractions of the stiffness at contact that must be seen at least. A foam that buckles keeps about
// a tenth of it. Relaxation of a specimen that is pressed slowly takes less than the difference.
constexpr double kNear = 0.25;  // near the place where the stiffness was measured
constexpr double kNearForces = 4;  // "near" reaches to this multiple of the force there
constexpr double kFar = 0.05;
constexpr double kComesBack = 0.25;  // of a force, at the depth where it was felt last
constexpr double kRelaxesUnseen = 0.3;  // of a force whose rate of relaxation nobody saw
constexpr double kSooner = 1.5;  // faster after a disturbance
// Creep per second, as a fraction of the indentation: while the specimen is pressed, and under a
// held force.
constexpr double kCreeps_s = 0.01, kCreepsHeld_s = 0.1;
constexpr double kThermal_m_s = 1e-9;  // 3.6 um in an hour: thermal expansion of rig and specimen
constexpr double kThere_m = 1e-6;
constexpr double kGoesOn = 0.5;  // of the ordered speed
constexpr int kSurelyShort = 2;  // consecutive samples; a single one may be a spike

}  // namespace

void PressWatch::know(MonoTime now, double travel_m, double felt_N, double stiffness_N_m) {
  contact_.emplace(now, travel_m, felt_N, stiffness_N_m);
}

void PressWatch::begin(const Motion& motion, MonoTime now) {
  motion_ = motion;
  begun_ = last_ = now;
  short_of_ = 0;
  crept_m_ = 0;
  beyond_N_.reset();
  best_N_.reset();
  if (!contact_) return;
  loaded_ = travel_m_ && *travel_m_ >= contact_->deepest_m - kThere_m;
  base_m_ = loaded_ ? std::max(*travel_m_, contact_->deepest_m) : contact_->deepest_m;
  base_N_ = loaded_ ? motion.felt_N : kComesBack * contact_->there_N;
}

// The range of force that is left in which the contact is as stiff as measured.
double PressWatch::near_N() const {
  const Contact& c = *contact_;
  return std::max(0.0, kNearForces * c.felt_N - c.stiffness_N_m * (base_m_ - c.travel_m));
}

double PressWatch::from_m(MonoTime t, double doubt_m) const {
  const double thermal_m = loaded_ ? 0 : kThermal_m_s * to_seconds(t - contact_->since);
  return base_m_ + thermal_m + doubt_m;
}

double PressWatch::least_N(MonoTime t, double travel_m, double doubt_m) const {
  const double elastic_N = contact_->stiffness_N_m * (travel_m - from_m(t, doubt_m));
  const double near = std::min(elastic_N, near_N());
  const double rise_N = kNear * near + kFar * (elastic_N - near);
  return base_N_ - relaxed_N(t) + rise_N;
}

// The part of the initial force that may have relaxed by now.
double PressWatch::relaxed_N(MonoTime t) const {
  const double most_N = kRelaxesUnseen * std::max(0.0, motion_.felt_N);
  if (!motion_.relaxes_N_s) return most_N;
  return std::min(kSooner * *motion_.relaxes_N_s * to_seconds(t - begun_), most_N);
}

// The smallest possible force now: the largest of this motion so far, plus the least rise since
// then. A specimen that is pressed ever deeper loses at most the force with which the motion began.
double PressWatch::least_since_then_N(double travel_m, double felt_N, double tolerance_N,
                                      bool is_in) {
  const Contact& c = *contact_;
  if (!is_in && !best_N_ && felt_N < std::max(c.felt_N, 2 * tolerance_N)) return -HUGE_VAL;
  const double rise_N = kFar * c.stiffness_N_m * (travel_m - crept_m_);
  const double beyond_N = felt_N - rise_N;
  const double surely_N = std::min(beyond_N, beyond_N_.value_or(beyond_N));  // ignores a single
                                                                             // spike
  beyond_N_ = beyond_N;
  if (!best_N_ || surely_N >= *best_N_) {
    best_N_ = surely_N;
    best_at_ = last_;
    best_m_ = travel_m;
  }
  const double way_m = kGoesOn * motion_.speed_m_s * to_seconds(last_ - best_at_);
  const bool goes_on = travel_m - best_m_ >= way_m;
  return goes_on ? *best_N_ + rise_N - relaxed_N(last_) : -HUGE_VAL;
}

std::optional<std::string> PressWatch::check(MonoTime t, double travel_m, double felt_N,
                                             double tolerance_N, double doubt_m) {
  travel_m_ = travel_m;
  if (!contact_) return std::nullopt;
  Contact& c = *contact_;
  const double creeps_s = motion_.holds ? kCreepsHeld_s : kCreeps_s;
  const double creeps_m =
      creeps_s * std::max(0.0, felt_N) / c.stiffness_N_m * to_seconds(t - last_);
  base_m_ += creeps_m;
  crept_m_ += creeps_m;
  last_ = t;
  if (travel_m > c.deepest_m) c.deepest_m = travel_m, c.there_N = felt_N;
  const bool is_in = travel_m > from_m(t, doubt_m);
  double least = least_since_then_N(travel_m, felt_N, tolerance_N, is_in);
  if (is_in) least = std::max(least, least_N(t, travel_m, doubt_m));
  short_of_ = felt_N < least - tolerance_N ? short_of_ + 1 : 0;
  if (short_of_ < kSurelyShort) return std::nullopt;
  return fmt::format(
      "the force does not follow the way into the specimen: {:.4f} N at {:.4f} mm beyond contact, "
      "which was {:.3g} N/mm stiff when it was found and should show {:.3g} N at least; the load "
      "cell shows too little, or the specimen gave way",
      felt_N, (travel_m - c.travel_m) * 1e3, c.stiffness_N_m * 1e-3, least);
}

void PressWatch::rest(double travel_m, double felt_N) {
  travel_m_ = travel_m;
  if (!contact_ || travel_m < contact_->deepest_m - kThere_m) return;
  contact_->deepest_m = std::max(contact_->deepest_m, travel_m);
  contact_->there_N = felt_N;
}

std::optional<double> PressWatch::furthest_m(MonoTime now, double felt_N, double tolerance_N,
                                             double doubt_m) const {
  if (!contact_) return std::nullopt;
  PressWatch next = *this;
  Motion motion;
  motion.felt_N = contact_->there_N;
  next.begin(motion, now);
  const double k = contact_->stiffness_N_m, near = next.near_N();
  const double lost_N = next.loaded_ ? kRelaxesUnseen * std::max(0.0, next.base_N_) : 0;
  const double rise_N = std::max(0.0, felt_N + tolerance_N + lost_N - next.base_N_);
  const double by_near_N = std::min(rise_N, kNear * near);
  return next.from_m(now, doubt_m) + by_near_N / kNear / k + (rise_N - by_near_N) / kFar / k;
}

}  // namespace lcrig
