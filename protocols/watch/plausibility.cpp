// SPDX-License-Identifier: Apache-2.0
#include "protocols/watch/plausibility.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// When the frame reports standstill, samples of the motion may still be on their way.
constexpr Duration kGrace = 300ms;
constexpr double kLeastProgress = 0.1;  // of the way at the ordered speed
constexpr double kLeastRate = 0.2;  // of the rate of the force, or of what the contact pushes back
constexpr int kQuarters = 4;
constexpr double kOneDigit = 1.5;  // digits of the travel; a smaller change is no motion
// A jump of the force while the frame stands is seen by the medians of two short intervals. They
// are so far apart that no knock lasts as long, and no relaxation is as quick.
constexpr Duration kSettled = 1500ms, kShort = 300ms, kApart = 1000ms;
constexpr Duration kBetween = 100ms;  // between two comparisons
constexpr double kCreeps = 0.2;  // of the tolerated way, if the force changes with it
constexpr double kOneStep = 0.6;  // a jump has a single step of at least this part
constexpr double kJump = 0.1;  // of the felt force
constexpr double kFalls = 0.4;  // of the largest force in a motion that presses
constexpr int kSureFalls = 2;  // consecutive forces; a single one may be a spike
constexpr double kSpeedDoubt = 1.2;
constexpr Duration kOnTheWay = 200ms;  // delay of a sample
constexpr double kContactDoubt_m = 1e-6;  // error of the place of contact
constexpr double kSmooth = 0.2;  // weight of a new sample
constexpr double kSmoothSquare = 0.05;  // weight of its square
constexpr double kLeastLook_s = 0.5;  // at a force that may relax

}  // namespace

void Plausibility::begin(const Motion& motion, MonoTime now) {
  PressWatch::Motion press;
  press.felt_N = motion.force_N - motion.rest_N;
  press.speed_m_s = motion.speed_m_s;
  press.relaxes_N_s = relaxes_N_s();
  press.holds = motion.holds;
  press_.begin(press, now);
  see_end_of_motion(now);
  state_ = State::moving;
  motion_ = motion;
  since_ = now;
  furthest_m_.reset();
  peak_N_.reset();
  before_N_.reset();
  fallen_ = 0;
  progress_.reset();
  idle_quarters_ = 0;
}

void Plausibility::stand(MonoTime now, std::optional<double> travel_m) {
  see_end_of_motion(now);
  // The reported place of standstill is compared with the next samples, even if a new order has
  // come by then.
  if (travel_m || state_ != State::standing) said_m_ = travel_m;
  state_ = State::standing;
  since_ = now;
  stood_m_.reset();
  moving_flags_ = 0;
  recent_.clear();
  stood_first_.reset();
  stood_last_.reset();
  wavers_N2_ = 0;
}

void Plausibility::see_end_of_motion(MonoTime now) {
  if (state_ == State::moving && motion_.direction < 0) falls_until_ = now + motion_.shown_after;
  const auto worst_N = std::exchange(motion_.worst_N, std::nullopt);
  if (!worst_N) return;
  follows_to_N_ = *worst_N;
  follows_until_ = now + motion_.shown_after;
}

// While the cell's filter still follows the last motion, the force shown on a way away may rise to
// what that motion can have reached. After a way away it may fall to that of the unloaded cell
// while the frame comes closer again. It then counts as the force at the beginning.
void Plausibility::follow_filter(MonoTime t, double force_N) {
  if (motion_.direction < 0 && t <= follows_until_) {
    motion_.force_N = std::max(motion_.force_N, std::min(force_N, follows_to_N_));
  }
  if (!may_still_fall(t)) return;
  // A zero that was taken under load has moved what the unloaded cell shows.
  const double unloaded_N = std::min(motion_.rest_N, motion_.free_N.value_or(motion_.rest_N));
  motion_.force_N = std::min(motion_.force_N, std::max(force_N, unloaded_N));
  peak_N_.reset();
  press_.forget_peak();
}

bool Plausibility::may_still_fall(MonoTime t) const {
  return motion_.direction > 0 && t <= falls_until_;
}

void Plausibility::zero_force(MonoTime now) {
  follows_until_ = MonoTime();
  zeroed_ = now;
  recent_.clear();
}

void Plausibility::look_away() {
  state_ = State::unknown;
  said_m_.reset();
  equals_ = 0;
}

void Plausibility::remember(const FrameSample& sample) {
  if (!sample.force_N) return;
  place_before_ = place_;
  place_.emplace(*sample.force_N, sample.travel_m);
}

double Plausibility::travel_doubt_m() const {
  return kContactDoubt_m + kOneDigit * digit_m_ + kNoiseSigmas * figures_.travel_noise_m;
}

double Plausibility::still_m() const {
  return std::max(figures_.against_m, kOneDigit * digit_m_);
}

bool Plausibility::changed_sign(double stiffness_N_m) const {
  if (!force_believed_ || !place_before_ || !place_) return false;
  if (!place_->travel_m || !place_before_->travel_m) return false;
  const double way_m = std::abs(*place_->travel_m - *place_before_->travel_m) + travel_doubt_m();
  const double by_way_N = stiffness_N_m * way_m + 2 * figures_.contact_force_N;
  const double before_N = place_before_->force_N - motion_.rest_N;
  const double now_N = place_->force_N - motion_.rest_N;
  return before_N - now_N > by_way_N && std::abs(before_N + now_N) < by_way_N;
}

std::optional<Contradiction> Plausibility::check(const FrameSample& sample) {
  learn_digit(sample.travel_m);
  remember(sample);
  if (state_ == State::unknown) return std::nullopt;
  if (auto no = check_digits(sample)) return no;
  if (state_ == State::standing) return check_stillness(sample);
  if (sample.travel_m) {
    if (auto no = check_begin(sample.received, *sample.travel_m)) return no;
    if (auto no = check_direction(*sample.travel_m)) return no;
  }
  if (sample.force_N) {
    if (auto no = check_force(sample.received, *sample.force_N)) return no;
  }
  if (auto no = check_press(sample)) return no;
  return check_progress(sample);
}

// Learns the last digit of the travel. A coarse travel may flip by one digit at standstill.
void Plausibility::learn_digit(std::optional<double> travel_m) {
  if (!travel_m) return;
  const double step = last_travel_m_ ? std::abs(*travel_m - *last_travel_m_) : 0;
  last_travel_m_ = travel_m;
  if (step > kLeastDigit_m && step < kCoarsestDigit_m && (digit_m_ == 0 || step < digit_m_)) {
    digit_m_ = step;
  }
}

std::optional<Contradiction> Plausibility::check_digits(const FrameSample& sample) {
  if (!sample.force_N || !force_believed_) return std::nullopt;
  const bool same = last_force_N_ == sample.force_N;
  last_force_N_ = sample.force_N;
  equals_ = same ? equals_ + 1 : 1;
  if (!figures_.frozen_samples || equals_ <= *figures_.frozen_samples) return std::nullopt;
  return Contradiction(
      Disbelief::force,
      fmt::format("the load cell is frozen: {:.6g} N in {} samples one after another, and its last "
                  "digit changed all the time before",
                  *sample.force_N, equals_));
}

// For a motion that follows at once: compares its first sample with the place where the frame
// reported standstill, because no sample of that standstill has come.
std::optional<Contradiction> Plausibility::check_begin(MonoTime t, double travel_m) {
  if (!said_m_) return std::nullopt;
  const double from_m = *std::exchange(said_m_, std::nullopt);
  if (motion_.direction == 0) return std::nullopt;
  const double way_m = kSpeedDoubt * motion_.speed_m_s * to_seconds(t - since_ + kOnTheWay);
  const double off_m = std::abs(travel_m - from_m);
  if (off_m <= figures_.order_travel_m + way_m + kOneDigit * digit_m_) return std::nullopt;
  return Contradiction(
      Disbelief::stillness,
      fmt::format("the frame said that it stands at {:.4f} mm, and shows {:.4f} mm", from_m * 1e3,
                  travel_m * 1e3));
}

std::optional<Contradiction> Plausibility::check_direction(double travel_m) {
  if (motion_.direction == 0) return std::nullopt;
  const double there = motion_.direction * travel_m;
  furthest_m_ = std::max(furthest_m_.value_or(there), there);
  const double back_m = *furthest_m_ - there;
  const double allowed_m = std::max(figures_.against_m, kOneDigit * digit_m_);
  // A servo may overshoot its end and come back.
  const bool is_there =
      motion_.target_m && there >= motion_.direction * *motion_.target_m - allowed_m;
  if (is_there) return std::nullopt;
  if (back_m <= allowed_m) return std::nullopt;
  return Contradiction(
      Disbelief::drive,
      fmt::format("the frame runs against the command: {:.4f} mm {} the specimen instead of {} it",
                  back_m * 1e3, motion_.direction > 0 ? "away from" : "towards",
                  motion_.direction > 0 ? "towards" : "away from"));
}

std::optional<Contradiction> Plausibility::check_force(MonoTime t, double force_N) {
  if (!force_believed_) return std::nullopt;
  if (!std::exchange(motion_.force_known, true)) motion_.force_N = force_N;
  follow_filter(t, force_N);
  const double allowed_N = motion_.against_N + motion_.drift_N_s * to_seconds(t - since_);
  // Compares with the largest force that two consecutive samples of this motion reached.
  const double felt_N = std::min(force_N, before_N_.value_or(force_N));
  peak_N_ = std::max(peak_N_.value_or(felt_N), felt_N);
  before_N_ = force_N;
  const double falls_N = allowed_N + kFalls * std::abs(*peak_N_ - motion_.rest_N);
  fallen_ = motion_.direction > 0 && force_N < *peak_N_ - falls_N ? fallen_ + 1 : 0;
  const double limit_N = motion_.force_N - allowed_N;
  if (fallen_ >= kSureFalls || (motion_.direction > 0 && force_N < limit_N)) {
    const double before_N = fallen_ >= kSureFalls ? *peak_N_ : motion_.force_N;
    return Contradiction(
        Disbelief::force,
        fmt::format(
            "the force falls while the frame presses: {:.4f} N after {:.4f} N; the load "
            "cell {}, or the specimen gave way",
            force_N, before_N,
            force_N < limit_N ? "is connected the wrong way, lost its zero" : "shows too little"));
  }
  if (force_N < limit_N) follows_until_ = MonoTime();  // it falls, so the filter has followed
  // A specimen that sticks pulls until it lets go; after that the cell shows its force at rest.
  const double most_N =
      std::max({motion_.force_N, motion_.rest_N, motion_.free_N.value_or(motion_.rest_N)}) +
      allowed_N;
  if (motion_.direction < 0 && force_N > most_N) {
    return Contradiction(
        Disbelief::drive,
        fmt::format("the force rises against the command, which leads away from the specimen: "
                    "{:.4f} N after {:.4f} N",
                    force_N, motion_.force_N));
  }
  return std::nullopt;
}

std::optional<Contradiction> Plausibility::check_press(const FrameSample& sample) {
  if (!sample.travel_m || !sample.force_N || !force_believed_) return std::nullopt;
  const double felt_N = *sample.force_N - motion_.rest_N;
  if (motion_.direction < 0) {
    press_.rest(*sample.travel_m, felt_N);
    return std::nullopt;
  }
  const double drifts_N = motion_.drift_N_s * to_seconds(sample.received - since_);
  const double tolerance_N = figures_.order_force_N + motion_.waver_N + drifts_N;
  auto why = press_.check(sample.received, *sample.travel_m, felt_N, tolerance_N, travel_doubt_m());
  if (!why) return std::nullopt;
  return Contradiction(Disbelief::force, std::move(*why));
}

void Plausibility::mark(const FrameSample& sample) {
  progress_.emplace();
  progress_->t = sample.received;
  progress_->travel_m = sample.travel_m;
  progress_->force_N = sample.force_N;
}

// At the slowest speeds the expected way must exceed what a drive may hunt.
double Plausibility::stall_s() const {
  if (motion_.direction == 0) {
    return std::max(figures_.stall_s, 4 * figures_.order_force_N / motion_.rate_N_s);
  }
  // A travel that has not changed yet may be as coarse as stated, or as one can be.
  const double digit_m = digit_m_ > 0 ? digit_m_ : figures_.coarsest_digit_m;
  const double way_m = std::max(1.5 * figures_.against_m, 3 * digit_m);
  return std::max(figures_.stall_s, way_m / motion_.speed_m_s);
}

// Looks in quarters of the allowed time, so that a stall is noticed soon after it.
std::optional<Contradiction> Plausibility::check_progress(const FrameSample& sample) {
  if (motion_.direction == 0 && !(motion_.rate_N_s > 0)) return std::nullopt;
  if (!sample.travel_m || !sample.force_N) return std::nullopt;
  if (!progress_ || !progress_->travel_m) mark(sample);
  const double dt = to_seconds(sample.received - progress_->t);
  if (dt < stall_s() / kQuarters) return std::nullopt;
  const double way_m = std::abs(*sample.travel_m - *progress_->travel_m);
  const double change_N = std::abs(*sample.force_N - *progress_->force_N);
  const bool by_loop = motion_.direction == 0;
  const bool loads = by_loop && change_N >= kLeastRate * motion_.rate_N_s * dt;
  const bool moves = way_m >= kLeastProgress * motion_.speed_m_s * dt;
  // A force loop that goes on in a contact which should push back, and does not, is no progress.
  const double should_N = by_loop ? press_.stiffness_N_m(*sample.travel_m) * way_m : 0;
  const bool follows = change_N >= kLeastRate * should_N;
  const bool went = loads || (moves && follows);
  idle_quarters_ = went ? 0 : idle_quarters_ + 1;
  mark(sample);
  if (idle_quarters_ < kQuarters) return std::nullopt;
  if (moves) {
    return Contradiction(
        Disbelief::force,
        fmt::format("the force loop goes on, {:.4f} mm in the last {:.1f} s, and the force does "
                    "not follow: {:.4f} N; the load cell shows too little, or the specimen gave "
                    "way",
                    way_m * 1e3, dt, *sample.force_N));
  }
  return Contradiction(
      Disbelief::drive,
      fmt::format("the frame does not move as it was told to, and does not say that it stands: "
                  "{:.4f} mm in the last {:.1f} s{}",
                  way_m * 1e3, dt,
                  motion_.speed_m_s > 0
                      ? fmt::format(", where {:.4g} mm/s were ordered", motion_.speed_m_s * 1e3)
                      : std::string()));
}

std::optional<Contradiction> Plausibility::check_stillness(const FrameSample& sample) {
  const bool settled = sample.received - since_ > kGrace;
  moving_flags_ = settled && (sample.flags & frame_flag::kMoving) != 0 ? moving_flags_ + 1 : 0;
  if (sample.travel_m && !stood_m_) stood_m_ = sample.travel_m;
  if (sample.force_N && settled) see_relaxation(sample.received, *sample.force_N);
  if (sample.force_N && sample.travel_m) {
    press_.rest(*sample.travel_m, *sample.force_N - motion_.rest_N);
  }
  const bool arrived = to_seconds(sample.received - since_) > figures_.settled_s;
  if (sample.travel_m && said_m_ && arrived) {
    const double said_m = *std::exchange(said_m_, std::nullopt);
    const double off_m = std::abs(*sample.travel_m - said_m);
    if (off_m > figures_.order_travel_m + kOneDigit * digit_m_) {
      return Contradiction(
          Disbelief::stillness,
          fmt::format("the frame moves while nobody told it to: it said that it stands at {:.4f} "
                      "mm, and shows {:.4f} mm",
                      said_m * 1e3, *sample.travel_m * 1e3));
    }
  }
  const double way_m = sample.travel_m ? *sample.travel_m - *stood_m_ : 0;
  const auto moved = [&](double allowed_m) {
    return std::abs(way_m) > std::max(allowed_m, kOneDigit * digit_m_);
  };
  auto step = sample.force_N ? check_step(sample.received, *sample.force_N) : std::nullopt;
  // A force that changes together with the travel is real.
  const bool creeps = moved(figures_.standing_m) || (step && moved(kCreeps * figures_.standing_m));
  if (moving_flags_ <= 1 && !creeps) return step;
  return Contradiction(
      Disbelief::stillness,
      fmt::format("the frame moves while nobody told it to: {:+.4f} mm since it stood{}",
                  way_m * 1e3, moving_flags_ > 1 ? ", and it says that it moves" : ""));
}

void Plausibility::see_relaxation(MonoTime t, double force_N) {
  const auto smooth = [&](Seen& s, double weight) {
    s.t = t;
    s.force_N += weight * (force_N - s.force_N);
  };
  if (!stood_first_) stood_first_.emplace(t, force_N);
  if (!stood_last_) stood_last_.emplace(t, force_N);
  const double off_N = force_N - stood_last_->force_N;
  wavers_N2_ += kSmoothSquare * (off_N * off_N - wavers_N2_);
  if (to_seconds(t - since_) < kLeastLook_s) smooth(*stood_first_, kSmooth);
  smooth(*stood_last_, kSmooth);
}

// Rate of relaxation while the frame stood; later it relaxes ever more slowly. nullopt: watched too
// briefly.
std::optional<double> Plausibility::relaxes_N_s() const {
  if (state_ != State::standing || !stood_first_ || !stood_last_) return std::nullopt;
  const double dt = to_seconds(stood_last_->t - stood_first_->t);
  if (dt < kLeastLook_s) return std::nullopt;
  const double lost_N = stood_first_->force_N - stood_last_->force_N;
  return std::max(0.0, lost_N + figures_.contact_force_N) / dt;
}

std::optional<Contradiction> Plausibility::check_step(MonoTime t, double force_N) {
  if (!force_believed_ || t - std::max(since_, zeroed_) < kSettled) return std::nullopt;
  recent_.emplace_back(t, force_N);
  if (t - compared_ < kBetween) return std::nullopt;
  compared_ = t;
  while (t - recent_.front().t > kApart + kShort) recent_.pop_front();
  std::vector<double> old_N, new_N;
  double steepest_N = 0;  // largest change between two samples
  for (std::size_t i = 1; i < recent_.size(); ++i) {
    steepest_N = std::max(steepest_N, std::abs(recent_[i].force_N - recent_[i - 1].force_N));
  }
  for (const Seen& s : recent_) {
    if (t - s.t >= kApart) old_N.push_back(s.force_N);
    if (t - s.t <= kShort) new_N.push_back(s.force_N);
  }
  if (old_N.size() < 2 || new_N.size() < 2) return std::nullopt;
  const double before = upper_median(old_N), after = upper_median(new_N);
  const double felt_N = std::max(std::abs(before), std::abs(after));
  const double allowed_N =
      std::max(2 * figures_.contact_force_N, figures_.order_force_N) + kJump * felt_N;
  const double change_N = std::abs(after - before);
  // Relaxation and creep take many small steps.
  if (change_N <= allowed_N || steepest_N < kOneStep * change_N) return std::nullopt;
  return Contradiction(
      Disbelief::force,
      fmt::format("the force jumped from {:.4f} N to {:.4f} N while the frame stood: the zero of "
                  "the load cell was lost, or somebody touched the rig",
                  before, after));
}

}  // namespace lcrig
