// SPDX-License-Identifier: Apache-2.0
// What a run does with samples that cannot be true, and whether a motion ended where it was told
// to.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "protocols/run/run.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr double kDriftSigmas = 6;  // what no sample shows by chance, however many there are
// A specimen relaxes while it is pressed slowly, and gives back less than it took.
constexpr double kRelaxes = 0.3, kGivesBack = 0.05;  // of the force that is felt
constexpr double kLeastOfLimit = 0.02;
constexpr double kSettles = 0.1;  // of the force, from the stop to the next sample

}  // namespace

// What is known of the unloaded cell: everything that is derived of it, too.
void Run::learn_rest(const Rest& rest, Under under) {
  // A cell that was alive and shows one value is none to learn from: it may just have frozen.
  if (plausible_ && scatter_.alive && !rest.is_alive()) return;
  rest_ = rest;
  if (under == Under::nothing) bare_ = rest;
  if (!plausible_) return;
  if (rest.drifts()) {
    drift_N_s_ = std::abs(rest.drift_N_s()) + kSureOfDrift * rest.drift_error_N_s();
  }
  learn_scatter(rest);
}

// Of a cell that may be loaded, too.
void Run::learn_scatter(const Rest& rest) {
  scatter_.add(rest, plausible_->figures().frozen_samples);
  WatchFigures figures =
      watch_figures(setup_.frame.capabilities(), pressing_->forecast().bound(),
                    setup_.limits.force_max_N, setup_.frame_rate_Hz, scatter_, scatter_.noise_N);
  // The scatter is an estimate each time: what was promised once is kept.
  const WatchFigures& before = plausible_->figures();
  if (before.frozen_samples &&
      figures.frozen_samples.value_or(INT64_MAX) > *before.frozen_samples) {
    figures.frozen_samples = before.frozen_samples;
    figures.frozen_force_s = before.frozen_force_s;
  }
  plausible_->set_figures(figures);
  event(EventKind::watch, to_json(plausible_->figures()).dump());
}

// Samples that are old say nothing of what happens now: a motion that nobody can watch is stopped.
// If this program itself did not run meanwhile they are not late by the gateway's fault.
void Run::judge_age(std::span<const FrameSample> samples) {
  const MonoTime now = setup_.clock.now();
  const auto finding = sample_clock_.add(samples);
  if (finding.news) event(finding.news->first, finding.news->second);
  if (finding.age_s <= SampleClock::kLate_s || now - tick_ > 2 * kTick) return;
  if (now - age_told_ >= 1s || age_told_ == MonoTime()) {
    age_told_ = now;
    event(LateSamplesEvent{finding.age_s});
  }
  if (!in_motion_ || finishing_) return;
  lose_frame(
      Error(Errc::no_reply, fmt::format("the samples of the frame are {:.2f} s old when they "
                                        "arrive: nobody can watch a motion like that",
                                        finding.age_s)));
}

// Tolerances of a motion that begins now.
Plausibility::Motion Run::motion_now(double direction, double speed_m_s) const {
  Plausibility::Motion m;
  m.direction = direction;
  m.speed_m_s = speed_m_s;
  m.force_N = force_N_.value_or(0);
  m.rest_N = rest_ ? rest_->force_N() : 0;
  const double felt_N = std::abs(m.force_N - m.rest_N);
  // A frame that hunts in contact wavers by more than its cell scatters.
  const double noise_N = std::max(
      {rest_ ? rest_->scatter_N() : 0, wavers_N_, plausible_ ? plausible_->wavers_N() : 0});
  const double least_N = std::max(kDriftSigmas * noise_N, kLeastOfLimit * guard_.force_max_N());
  m.against_N = least_N + (direction > 0 ? kRelaxes : kGivesBack) * felt_N + zero_doubt_N();
  m.drift_N_s = drift_N_s_;
  if (direction > 0) {  // a specimen that is pressed does not pull
    const double room_N = m.force_N - guard_.limits().force_min_N;
    m.against_N = std::min(m.against_N, std::max(room_N, kDriftSigmas * noise_N));
  }
  return m;
}

Plausibility::Motion Run::holding() const {
  Plausibility::Motion m = motion_now(0, 0);
  m.holds = true;
  if (const auto& loop = setup_.frame.capabilities().force_loop) m.waver_N = loop->ripple.si();
  return m;
}

void Run::judge_truth(const FrameSample& sample) {
  if (!plausible_) return;
  const auto no = plausible_->check(sample);
  if (stop_pending_) return;
  if (ending_) {  // it was stopped, and nothing was asked since
    if (no && no->disbelief == Disbelief::stillness) moves_again_ = no->why;
    return;
  }
  if (no) return disbelieve(*no);
  judge_fall(sample);
}

// Below the lower limit. A specimen that pulls is left to a person. A cell that lies is not
// believed, and the probe leaves.
void Run::judge_fall(const FrameSample& sample) {
  const double least_N = guard_.limits().force_min_N;
  if (sample.force_N.value_or(least_N) >= least_N) return;
  const double felt_N = std::max(guard_.peak_force_N(), guard_.force_max_N());
  const double stiffness_N_m = pressing_ ? pressing_->forecast().bound().stiffness_N_m(felt_N) : 0;
  if (pressing_ && plausible_->changed_sign(stiffness_N_m)) {
    return disbelieve(Contradiction(
        Disbelief::force,
        fmt::format("the force falls to {:.4f} N at once, which is what it was with the other "
                    "sign: the load cell is connected the wrong way",
                    *sample.force_N)));
  }
  if (plausible_->may_pull()) return;
  disbelieve(Contradiction(
      Disbelief::force,
      fmt::format(
          "the force falls to {:.4f} N though the frame does not move away from the "
          "specimen, which can only pull then: the load cell is connected the wrong way, or "
          "lost its zero",
          *sample.force_N)));
}

// Stopped at once; what is still allowed then depends upon what is not believed any more.
void Run::disbelieve(const Contradiction& contradiction) {
  const std::string& why = contradiction.why;
  plausible_->look_away();
  event(EventKind::contradiction, why);
  switch (contradiction.disbelief) {
    case Disbelief::force:
      plausible_->distrust_force();
      guard_.distrust_zero(setup_.frame.capabilities().force_max.si());
      if (pressing_) pressing_->distrust(why);
      break;
    case Disbelief::drive: return keep_hands_off(why);
    case Disbelief::stillness: break;
  }
  interrupt(InterruptRequest(Interrupt::fault, Error(Errc::refused, why)));
}

namespace {

// `direction`: of the force. Whether it came there, as far as one value tells.
bool is_there(double force_N, double target_N, int direction, double allowed_N) {
  if (direction == 0) return std::abs(force_N - target_N) <= allowed_N;
  return direction > 0 ? force_N >= target_N - allowed_N : force_N <= target_N + allowed_N;
}

}  // namespace

// How far the frame is from where the motion should have ended, by its own last word and by what
// its samples show; empty: nowhere.
std::string Run::disagreement(const Order& order, const MotionOutcome& outcome) const {
  const WatchFigures& f = plausible_->figures();
  if (order.travel_m) {
    for (const auto& x : {outcome.travel_m, shown_travel_m_}) {
      if (!x || std::abs(*x - *order.travel_m) <= f.order_travel_m) continue;
      return fmt::format("it was to go to {:.4f} mm, and shows {:.4f} mm", *order.travel_m * 1e3,
                         *x * 1e3);
    }
  }
  if (!order.force_N || guard_.is_distrusted()) return {};
  const double rest_N = rest_ ? rest_->force_N() : 0;
  const double felt_N =
      std::max(std::abs(*order.force_N - rest_N), std::abs(order.motion.force_N - rest_N));
  const double allowed_N = f.order_force_N + order.waver_N + kSettles * felt_N + zero_doubt_N();
  for (const auto& force : {outcome.force_N, shown_force_N_}) {
    if (!force || is_there(*force, *order.force_N, order.side, allowed_N)) continue;
    return fmt::format("it was to go to {:.4f} N, and shows {:.4f} N", *order.force_N, *force);
  }
  return {};
}

// `target` is the frame's word: what it shows has to agree, at the latest in the samples that come
// next.
Task<Result<>> Run::believe(const Order& order, const MotionOutcome& outcome) {
  if (!plausible_ || outcome.reason != MotionEnd::target) co_return Result<>();
  const MonoTime limit = setup_.clock.now() + from_seconds(plausible_->figures().settled_s);
  std::string why = disagreement(order, outcome);
  while (!why.empty() && setup_.clock.now() < limit) {
    co_await setup_.clock.wait_for(10ms);
    why = disagreement(order, outcome);
  }
  if (why.empty()) co_return Result<>();
  event(EventKind::contradiction, why);
  co_return fail(Errc::refused, "step {}: the frame says DONE, but that is not true: {}", step_->id,
                 why);
}

}  // namespace lcrig
