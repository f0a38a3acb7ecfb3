// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_view.hpp"

#include <algorithm>
#include <utility>

#include "base/clock.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr Duration kForceAge = 500ms;  // an older force does not tell the direction of a motion
constexpr Duration kLifeTime = 3s;  // a live cell changes its last digit within this time
constexpr std::int64_t kRestSamples = 10;
constexpr double kNewSamples = 2;  // sample periods; an older force is not the present one

}  // namespace

void FrameView::add(std::span<const FrameSample> samples) {
  memory_.feed(samples);
  samples_ += std::ssize(samples);
  last_sample_ = setup_.clock.now();
  if (watched_) watched_->add(samples);
  for (const FrameSample& s : samples) {
    if (s.force_N) force_N_ = shown_force_N_ = s.force_N, force_known_ = *last_sample_;
    if (s.travel_m) shown_travel_m_ = s.travel_m;
    overloaded_ = (s.flags & frame_flag::kForceOverload) != 0;
  }
}

void FrameView::take_standstill(const MotionOutcome& outcome) {
  done_force_N_ = outcome.force_N;
  if (outcome.travel_m) memory_.travel_m = outcome.travel_m;
  if (!outcome.force_N) return;
  force_N_ = outcome.force_N;
  force_known_ = setup_.clock.now();
}

Result<double> FrameView::present_force_N() const {
  const Duration age = setup_.clock.now() - force_known_;
  const Duration most = std::max<Duration>(kForceAge, from_seconds(3 * (1 / setup_.frame_rate_Hz)));
  if (force_N_ && age <= most) return *force_N_;
  if (!force_N_) return fail(Errc::no_reply, "step {}: {}", log_.step_id(), no_force());
  return fail(
      Errc::no_reply,
      "step {}: the last known force, {:.4f} N, is {:.1f} s old: nobody knows which way leads "
      "to less",
      log_.step_id(), *force_N_, to_seconds(age));
}

std::string_view FrameView::no_force() const {
  return overloaded_ ? "the load is beyond the range of the load cell: unload at the machine, then "
                       "look at the specimen and the cell"
                     : "the frame sends no force";
}

bool FrameView::shows_force() const {
  if (!force_N_ || overloaded_) return false;
  const Duration new_enough = from_seconds(kNewSamples / setup_.frame_rate_Hz);
  return !last_sample_ || *last_sample_ - force_known_ <= new_enough;
}

void FrameView::forget(bool zeroed) {
  memory_ = FrameMemory();
  memory_.zeroed = zeroed;
}

Task<Result<Rest>> FrameView::watch_rest(Duration at_least) {
  watched_.emplace(samples_);
  const MonoTime begin = setup_.clock.now();
  const auto enough = [&] { return watched_->forces() >= kRestSamples; };
  co_await setup_.clock.wait_for(at_least);
  while (!enough() && setup_.clock.now() - begin < kLifeTime) co_await setup_.clock.wait_for(50ms);
  Rest rest = *std::exchange(watched_, std::nullopt);
  wavers_N_ = rest.scatter_N();
  if (rest.forces() == 0) {
    const std::string& step = log_.step_id();
    co_return fail(Errc::no_reply, "{}{}", step.empty() ? step : "step " + step + ": ", no_force());
  }
  co_return rest;
}

Task<Result<Rest>> FrameView::living_rest() {
  auto rest = co_await watch_rest(kRestTime);
  if (rest && !rest->is_alive()) rest = co_await watch_rest(kLifeTime);
  if (!rest || rest->is_alive()) co_return rest;
  co_return fail(Errc::refused,
                 "step {}: the load cell shows {:.4f} N in all of {} samples: it is frozen or not "
                 "connected, and nothing is approached with it",
                 log_.step_id(), rest->force_N(), rest->forces());
}

Task<Result<>> FrameView::await_samples(bool feels) {
  const double period_s = 1 / setup_.frame_rate_Hz;
  const MonoTime begin = setup_.clock.now();
  const MonoTime limit = begin + std::max<Duration>(2s, from_seconds(3 * period_s));
  const std::int64_t before = samples_;
  const auto heard = [&] { return samples_ > before && (!feels || force_known_ > begin); };
  while (!heard() && setup_.clock.now() < limit) co_await setup_.clock.wait_for(20ms);
  const bool needed = setup_.frame.capabilities().motion;
  if (samples_ == before && needed) co_return fail(Errc::no_reply, "the frame sends no samples");
  if (!heard() && needed) co_return fail(Errc::no_reply, "{}", no_force());
  co_return Result<>();
}

}  // namespace lcrig
