// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/standstill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocols/rig/constants.hpp"

namespace lcrig {

namespace {

// A motion at the last ordered speed leaves the tolerance twice within the look.
constexpr double kLeaves = 2;
// A batch may be under way, and one be late.
const Duration kArriving = from_seconds(kUnderWay_s + kBatch_s);

}  // namespace

std::string_view alarm_words(Standstill standstill) {
  switch (standstill) {
    case Standstill::not_confirmed: return "standstill not confirmed: use the E-stop";
    case Standstill::unknown:
      return "standstill unknown, its link is lost: use the E-stop if it moves";
    case Standstill::cannot_move:
    case Standstill::not_asked:
    case Standstill::awaited:
    case Standstill::confirmed: break;
  }
  return {};
}

std::string alarm_words_after(std::int64_t run) {
  return fmt::format(
      "frame: {} (since run {} ended); STOP is sent once a second, and nothing begins before the "
      "frame stands",
      alarm_words(Standstill::not_confirmed), run);
}

std::string stood_words(double after_s) {
  return fmt::format("the frame confirmed standstill {:.0f} s after the end of the run", after_s);
}

void StandstillWatch::order(double speed_m_s) {
  asked_ = said_ = confirmed_ = looks_longer_ = false;
  speed_m_s_ = std::abs(speed_m_s);
}

void StandstillWatch::ask(MonoTime now, Duration brakes) {
  // A STOP that is only repeated does not put off the alarm.
  if (!asked_ || confirmed_) {
    deadline_ = now + kPatience + brakes;
    extended_ = false;
  }
  asked_ = true;
  said_ = confirmed_ = false;
}

void StandstillWatch::confirm(MonoTime now, std::optional<Duration> period) {
  if (lost_) return;
  said_ = true;
  moved_ = false;
  said_at_ = now;
  anchor_.reset();
  confirmed_ = !period;
  if (confirmed_) return;
  look_ends_ = now + kLongLook + kArriving + kSilentPeriods.count() * *period;
  if (now > deadline_ || std::exchange(extended_, true)) return;
  deadline_ = std::max(deadline_, look_ends_);
}

void StandstillWatch::allow_lag(Duration late) {
  said_at_ += late;
  look_ends_ += late;
  deadline_ += late;
}

Duration StandstillWatch::look_time(double tolerance_m) const {
  if (looks_longer_) return kLongLook;
  if (!(speed_m_s_ > 0)) return kShortLook;
  const double leaves_s = std::min(kLeaves * tolerance_m / speed_m_s_, to_seconds(kLongLook));
  return std::max(from_seconds(leaves_s), kShortLook);
}

void StandstillWatch::take(const FrameSample& sample, double tolerance_m) {
  if (!said_ || confirmed_) return;
  const bool moves = (sample.flags & frame_flag::kMoving) != 0;
  const bool elsewhere = anchor_ && sample.travel_m && anchor_->travel_m &&
                         std::abs(*sample.travel_m - *anchor_->travel_m) > tolerance_m;
  if (!anchor_ || moves || elsewhere) {
    moved_ = anchor_ && sample.received > said_at_ + kArriving;
    if (moved_) look_longer();
    anchor_ = sample;
    return;
  }
  if (!anchor_->travel_m) anchor_->travel_m = sample.travel_m;
  confirmed_ = sample.received - anchor_->received >= look_time(tolerance_m);
}

void StandstillWatch::contradict(MonoTime now) {
  if (!asked_) return;
  look_longer();
  said_ = confirmed_ = false;
  deadline_ = std::min(deadline_, now);
}

void StandstillWatch::lose() {
  lost_ = true;
  said_ = confirmed_ = false;
}

void StandstillWatch::rejoin() {
  lost_ = asked_ = said_ = confirmed_ = false;
}

Standstill StandstillWatch::at(MonoTime now) const {
  if (!can_move_) return Standstill::cannot_move;
  if (lost_) return Standstill::unknown;
  if (!asked_) return Standstill::not_asked;
  if (confirmed_) return Standstill::confirmed;
  return now >= deadline_ ? Standstill::not_confirmed : Standstill::awaited;
}

}  // namespace lcrig
