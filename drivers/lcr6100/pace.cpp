// SPDX-License-Identifier: Apache-2.0
#include "drivers/lcr6100/pace.hpp"

#include <algorithm>

namespace lcrig::lcr6100 {

namespace {
using namespace std::chrono_literals;

constexpr std::int64_t kAnchorEdges = 256;
// The newest edge replaces an anchor this many times less certain: it gives the longest period
// sooner.
constexpr int kCoarser = 4;
constexpr int kUnverified = 3;  // new values in a row, after which an old one is asked for

Duration scaled(Duration d, double factor) {
  return Duration(static_cast<std::int64_t>(static_cast<double>(d.count()) * factor));
}
}  // namespace

void Pace::widen_period(double below, double above) {
  period_min_ = scaled(nominal_, below);
  period_max_ = scaled(nominal_, above);
}

void Pace::restart(MonoTime now, Duration nominal) {
  *this = Pace();
  nominal_ = nominal;
  first_poll_ = now + nominal;
  stale_at_ = now;
  widen_period(0.5, 1.6);
}

MonoTime Pace::next_poll(MonoTime now) const {
  if (!started_) return std::max({now, first_poll_, stale_at_ + kStep});
  const MonoTime begin = std::max(lo_ + period_min_ - kJitter, stale_at_);
  const MonoTime end = hi_ + period_max_ + kJitter;
  MonoTime t = end;
  if (unverified_ >= kUnverified && begin < end && begin > stale_at_) {
    t = begin;  // an old value there shows that the window is right
  } else if (begin >= end) {  // overdue: two equal values, or a slower meter
    t = stale_at_ + (stale_at_ < end + nominal_ / 4 ? kStep : std::max(kStep, nominal_ / 8));
  } else if (end - begin > 2 * kStep) {
    t = begin + kStep;
  } else if (end - begin > kStep) {
    t = begin + (end - begin) / 2;
  }
  return std::max({now, t, stale_at_ + 1ms});
}

void Pace::lose_phase(MonoTime asked, MonoTime answered) {
  lo_ = std::max(stale_at_, asked - period_max_);
  hi_ = answered;
  anchor_lo_ = lo_;
  anchor_hi_ = hi_;
  since_anchor_ = 0;
}

// The value came after its window. If the elapsed time is not much longer than the nominal period,
// it gives the new period. Otherwise two consecutive values were equal, or the meter paused.
void Pace::late(MonoTime asked, MonoTime answered) {
  const Duration shortest = stale_at_ - hi_;
  const Duration longest = answered - lo_;
  if (longest < scaled(nominal_, 1.6)) {
    period_min_ = shortest;
    period_max_ = longest;
  }
  lose_phase(asked, answered);
}

void Pace::narrow_period(std::int64_t steps) {
  since_anchor_ += steps;
  period_min_ = std::max(period_min_, (lo_ - anchor_hi_) / since_anchor_);
  period_max_ = std::min(period_max_, (hi_ - anchor_lo_) / since_anchor_);
  if (period_min_ > period_max_) {
    const double middle = static_cast<double>(period().count());
    const double ratio = middle / static_cast<double>(nominal_.count());
    widen_period(0.95 * ratio, 1.05 * ratio);
  } else if (since_anchor_ < kAnchorEdges && anchor_hi_ - anchor_lo_ <= kCoarser * (hi_ - lo_)) {
    return;
  }
  period_min_ = scaled(period_min_, 0.9998);
  period_max_ = scaled(period_max_, 1.0002);
  anchor_lo_ = lo_;
  anchor_hi_ = hi_;
  since_anchor_ = 0;
}

void Pace::fresh(MonoTime asked, MonoTime answered) {
  if (!started_) {
    started_ = true;
    lose_phase(asked, answered);
    lo_ = std::max(lo_, answered - nominal_);
    return;
  }
  const MonoTime window_begin = lo_ + period_min_ - kJitter;
  const MonoTime window_end = hi_ + period_max_ + kJitter;
  if (stale_at_ >= window_end) return late(asked, answered);
  // Counts the edges that have certainly passed. There may have been one more.
  std::int64_t steps = std::max<std::int64_t>(0, (asked - hi_ - kJitter) / period_max_);
  const bool maybe_more = lo_ + (steps + 1) * period_min_ - kJitter < answered;
  if (steps == 0 && answered < window_begin) {  // earlier than the assumed period allows
    widen_period(0.4, 1.6);
    return lose_phase(asked, answered);
  }
  if (steps > 0 && maybe_more) return lose_phase(asked, answered);
  steps = std::max<std::int64_t>(1, steps);
  unverified_ = stale_at_ >= window_begin || answered >= window_end ? 0 : unverified_ + 1;
  const MonoTime earliest = lo_ + steps * period_min_ - kJitter;
  const MonoTime latest = hi_ + steps * period_max_ + kJitter;
  lo_ = std::max(earliest, stale_at_);
  hi_ = std::min(latest, answered);
  if (unverified_ > kUnverified || lo_ > hi_) {
    unverified_ = 0;
    widen_period(0.4, 1.6);
    return lose_phase(asked, answered);
  }
  narrow_period(steps);
}

}  // namespace lcrig::lcr6100
