// SPDX-License-Identifier: Apache-2.0
#include "model/plant.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/bracket.hpp"

namespace lcrig {
namespace {

constexpr std::size_t kGridCells = 256;
constexpr double kCreepSteps = 50;  // steps within one creep time
constexpr int kSearchSteps = 200;
// The longest window of the meter (SLOW, 256 averages) lasts 97 s. A reading is computed for the
// middle of its window, and the link takes time, too.
constexpr Duration kLookBack = std::chrono::minutes(2);

// Rounds up, so that an event has happened at the instant that is returned for it.
Duration seconds_up(double s) {
  return Duration(static_cast<std::int64_t>(std::ceil(s * 1e9)));
}

}  // namespace

Plant::Plant(const SpecimenResponse& specimen, PlantConfig config)
    : specimen_(specimen), config_(config) {
  compliance_m_N_ = std::isfinite(config_.frame_stiffness_N_m) && config_.frame_stiffness_N_m > 0
                        ? 1 / config_.frame_stiffness_N_m
                        : 0;
  drive_.motion.value = drive_.motion.end = config_.start_travel_m;
  grid_N_ = std::max(config_.force_nominal_N, 1e-3) / kGridCells;
  for (std::size_t i = 0; i <= kGridCells; ++i) {
    grid_m_.push_back(shortening_m(grid_N_ * static_cast<double>(i)));
  }
}

double Plant::shortening_m(double force_N) const {
  return specimen_.shortening_m(force_N) + force_N * compliance_m_N_;
}

// Shortening rises with force, so the bracket always closes.
double Plant::solve_force(double target_m) const {
  double low = 0, high = grid_N_;
  double low_m = 0, high_m = grid_m_[1];
  if (target_m < grid_m_.back()) {
    const auto above = std::upper_bound(grid_m_.begin() + 1, grid_m_.end(), target_m);
    high = grid_N_ * static_cast<double>(above - grid_m_.begin());
    low = high - grid_N_;
    high_m = *above;
    low_m = *(above - 1);
  } else {
    low = grid_N_ * kGridCells;
    low_m = grid_m_.back();
    high = 2 * low;
    while ((high_m = shortening_m(high)) < target_m && high < 1e12) {
      low = high;
      low_m = high_m;
      high *= 2;
    }
  }
  const double close_enough = 1e-13 * target_m;
  Bracket bracket({low, low_m - target_m}, {high, high_m - target_m});
  double force = low;
  for (int i = 0; i < 100 && bracket.high().error > bracket.low().error; ++i) {
    force = bracket.next();
    const double error = shortening_m(force) - target_m;
    const double width = bracket.high().at - bracket.low().at;
    if (std::abs(error) <= close_enough || width <= 1e-15 * bracket.high().at) break;
    bracket.narrow({force, error});
  }
  return force;
}

double Plant::force_at_travel_N(double travel_m) const {
  const double pressed_m = travel_m - config_.contact_travel_m;
  return pressed_m > 0 ? solve_force(pressed_m) : 0;
}

double Plant::travel_at_force_m(double force_N) const {
  return config_.contact_travel_m + (force_N > 0 ? shortening_m(force_N) : 0);
}

Plant::Profile Plant::straight(MonoTime t, double from, double to, double speed) {
  Profile p;
  p.start = t;
  p.value = from;
  p.end = to;
  if (from != to && speed > 0) {
    p.rate = to > from ? speed : -speed;
    p.straight_s = (to - from) / p.rate;
  } else {
    p.end = speed > 0 ? to : from;  // without speed there is no motion
    p.value = p.end;
  }
  return p;
}

double Plant::Profile::braking_s() const {
  return brake > 0 ? std::abs(rate) / brake : 0;
}

MonoTime Plant::Profile::finish() const {
  return start + seconds_up(straight_s + braking_s());
}

double Plant::Profile::at(MonoTime t) const {
  if (t >= finish()) return end;
  const double s = std::max(to_seconds(t - start), 0.0);
  const double braked_s = std::max(s - straight_s, 0.0);
  const double v = value + rate * s - std::copysign(brake / 2 * braked_s * braked_s, rate);
  return rate > 0 ? std::min(v, end) : std::max(v, end);
}

MonoTime Plant::Profile::time_of(double v) const {
  if (rate == 0) return start;
  double s = (v - value) / rate;
  if (s > straight_s && brake > 0) {
    const double speed = std::abs(rate);
    const double beyond = (s - straight_s) * speed;  // distance into the parabola
    const double root = std::max(speed * speed - 2 * brake * beyond, 0.0);
    s = straight_s + (speed - std::sqrt(root)) / brake;
  }
  return start + seconds_up(s);
}

bool Plant::Drive::approaching(MonoTime t) const {
  return approach && t < approach->finish();
}

const Plant::Drive& Plant::drive_at(MonoTime t) const {
  const Drive* drive = &drive_;
  for (auto it = earlier_.rbegin(); t < drive->changed.t && it != earlier_.rend(); ++it) {
    drive = &*it;
  }
  return *drive;
}

Plant::Load Plant::load(MonoTime t) const {
  const Drive& drive = drive_at(t);
  return load_at(drive, t, creep_N(drive, t));
}

Plant::Load Plant::load_at(const Drive& drive, MonoTime t, double q_N) const {
  const double memory = config_.creep_fraction * q_N;
  if (drive.approaching(t)) return {0, memory};
  if (drive.control == Control::force) {
    const double force = drive.motion.at(t);
    return {force, force + memory};
  }
  if (memory == 0) {
    const double force = force_at_travel_N(drive.motion.at(t));
    return {force, force};
  }
  // Solves s(elastic) + (elastic - memory)/k = travel - contact. Where that leaves no force, the
  // probe has lifted off.
  const double pressed_m = drive.motion.at(t) - config_.contact_travel_m + memory * compliance_m_N_;
  const double elastic = pressed_m > 0 ? solve_force(pressed_m) : 0;
  return elastic > memory ? Load{elastic - memory, elastic} : Load{0, memory};
}

// One step of q, integrated exactly with the force in the middle of the step.
double Plant::creep_step(const Drive& drive, MonoTime from, Duration step, double q_N) const {
  const double force = load_at(drive, from + step / 2, q_N).force_N;
  return q_N + (force - q_N) * -std::expm1(-to_seconds(step) / config_.creep_time_s);
}

// Whole steps are counted from the last change and remembered. The answer then does not depend on
// which instants were asked for before.
double Plant::creep_N(const Drive& drive, MonoTime t) const {
  if (config_.creep_fraction <= 0) return 0;
  const Duration step = std::max(from_seconds(config_.creep_time_s / kCreepSteps), Duration(2));
  Memory& latest = drive.latest;
  if (t < latest.t) latest = drive.changed;
  while (t - latest.t >= step) {
    latest.q_N = creep_step(drive, latest.t, step, latest.q_N);
    latest.t += step;
  }
  return t > latest.t ? creep_step(drive, latest.t, t - latest.t, latest.q_N) : latest.q_N;
}

// Motions are monotonic, and so is the creep after them.
double Plant::peak_of_drive_N(MonoTime t) const {
  const MonoTime begin = drive_.changed.t, end = std::max(t, begin);
  const MonoTime reached = std::clamp(drive_.motion.finish(), begin, end);
  return std::max({load(begin).elastic_N, load(reached).elastic_N, load(end).elastic_N});
}

double Plant::peak_answered_N(MonoTime t) const {
  return std::max(peak_before_N_, peak_of_drive_N(t));
}

void Plant::change_at(MonoTime t, Drive next) {
  peak_before_N_ = std::max(peak_before_N_, peak_of_drive_N(t));
  next.changed = next.latest = {t, creep_N(drive_, t)};
  earlier_.push_back(std::exchange(drive_, std::move(next)));
  while (earlier_.size() > 1 && earlier_[1].changed.t < t - kLookBack) earlier_.pop_front();
}

double Plant::travel_m(MonoTime t) const {
  const Drive& drive = drive_at(t);
  if (drive.approaching(t)) return drive.approach->at(t);
  if (drive.control == Control::travel) return drive.motion.at(t);
  const Load now = load(t);
  return config_.contact_travel_m +
         (now.elastic_N > 0 ? specimen_.shortening_m(now.elastic_N) + now.force_N * compliance_m_N_
                            : 0);
}

double Plant::force_N(MonoTime t) const {
  return load(t).force_N;
}

Electrical Plant::electrical(MonoTime t) const {
  const double seconds = to_seconds(t.time_since_epoch());
  return {specimen_.capacitance_F(load(t).elastic_N) + config_.stray_capacitance_F +
              config_.thermal_drift_F_per_s * seconds,
          config_.dissipation};
}

void Plant::move_to(MonoTime t, double travel_m, double speed_m_s) {
  Drive next;
  next.motion = straight(t, this->travel_m(t),
                         std::clamp(travel_m, config_.travel_min_m, config_.travel_max_m),
                         std::min(std::abs(speed_m_s), config_.speed_max_m_s));
  change_at(t, next);
}

void Plant::ramp_force(MonoTime t, double force_N, double rate_N_s) {
  const double from_m = travel_m(t);
  Drive next;
  next.control = Control::force;
  MonoTime begin = t;
  if (from_m < config_.contact_travel_m) {
    next.approach = straight(t, from_m, config_.contact_travel_m, config_.force_approach_speed_m_s);
    begin = next.approach->finish();
  }
  next.motion = straight(begin, this->force_N(t), std::max(force_N, 0.0), std::abs(rate_N_s));
  change_at(t, next);
}

void Plant::put_load(MonoTime t, double force_N) {
  Drive next;
  next.control = Control::force;
  next.motion.start = t;
  next.motion.value = next.motion.end = std::max(force_N, 0.0);
  change_at(t, next);
}

// Speed of the travel. While the drive brakes, the speed that is left.
double Plant::speed_m_s(MonoTime t) const {
  const bool approaching = drive_.approaching(t);
  const Profile& motion = approaching ? *drive_.approach : drive_.motion;
  if (t >= motion.finish()) return 0;
  double rate = motion.rate;
  if (motion.brake > 0) {
    const double braked_s = std::max(to_seconds(t - motion.start) - motion.straight_s, 0.0);
    rate -= std::copysign(std::min(motion.brake * braked_s, std::abs(rate)), rate);
  }
  if (drive_.control == Control::force && !approaching) {
    const double force = force_N(t);
    const double step = 1e-6 * std::max(force, grid_N_);
    rate *= (shortening_m(force + step) - shortening_m(force)) / step;
  }
  return rate;
}

void Plant::halt(MonoTime t) {
  const double from = travel_m(t), rate = speed_m_s(t);
  Drive next;
  next.motion.start = t;
  next.motion.value = next.motion.end = from;
  if (rate != 0) {
    next.motion.rate = rate;
    next.motion.straight_s = config_.drive_lag_s;
    next.motion.brake = config_.deceleration_m_s2;
    next.motion.end = from + rate * (config_.drive_lag_s + next.motion.braking_s() / 2);
  }
  change_at(t, next);
}

std::optional<MonoTime> Plant::arrival() const {
  const bool moves = drive_.motion.rate != 0 || drive_.approach;
  return moves ? std::optional(drive_.motion.finish()) : std::nullopt;
}

std::optional<MonoTime> Plant::force_crossing(double force_N, MonoTime from, MonoTime to) const {
  const double first = this->force_N(from);
  const double last = this->force_N(to);
  if (first == force_N) return from;
  const bool rising = first < force_N;
  const auto passed = [&](double force) { return rising ? force >= force_N : force <= force_N; };
  if (!passed(last)) return std::nullopt;
  if (config_.creep_fraction > 0 && drive_.control == Control::travel) {
    return creeping_crossing(force_N, from, to);
  }
  const double value = drive_.control == Control::force ? force_N : travel_at_force_m(force_N);
  MonoTime t = std::clamp(drive_.motion.time_of(value), from, to);
  while (t < to && !passed(this->force_N(t))) {  // the inverse is off by a nanosecond or two
    t += Duration(1);
  }
  return t;
}

// With creep, the force at a travel depends on the past, so this searches forward and then bisects.
std::optional<MonoTime> Plant::creeping_crossing(double force_N, MonoTime from, MonoTime to) const {
  const bool rising = this->force_N(from) < force_N;
  const auto passed = [&](MonoTime t) {
    return rising ? this->force_N(t) >= force_N : this->force_N(t) <= force_N;
  };
  const Duration stride = std::max((to - from) / kSearchSteps, Duration(1));
  MonoTime before = from;
  MonoTime after = std::min(from + stride, to);
  while (!passed(after)) {
    if (after == to) return std::nullopt;
    before = after;
    after = std::min(after + stride, to);
  }
  while (after - before > Duration(1)) {
    const MonoTime middle = before + (after - before) / 2;
    (passed(middle) ? after : before) = middle;
  }
  return after;
}

}  // namespace lcrig
