// SPDX-License-Identifier: Apache-2.0
// Decides when the driver of the LCR-6100 polls a meter that converts continuously, so that nearly
// every poll finds a new value and none is missed. The meter finishes conversions at the edges of a
// grid. Phase and period of the grid are known only as intervals, and each answer narrows them: an
// old value shows that the edge came after the question, a new value that it came before the
// answer.
#pragma once

#include <algorithm>

#include "base/time.hpp"

namespace lcrig::lcr6100 {

class Pace {
 public:
  static constexpr Duration kStep = std::chrono::milliseconds(4);  // a new value is found at most
                                                                   // this late
  static constexpr Duration kJitter = std::chrono::microseconds(200);  // uncertainty of one edge
  // While the edge is known well, each question comes this much later after its edge than the one
  // before. Once the edge could lie anywhere within kStep, the next question comes earlier by
  // kEarlier, to find the edge again.
  static constexpr Duration kLater = kJitter, kEarlier = kStep / 2;

  // A new grid begins at about `now`; `nominal` is the expected period.
  void restart(MonoTime now, Duration nominal);
  // At least `now`, and at least 1 ms after the last question that got an old value.
  MonoTime next_poll(MonoTime now) const;
  void fresh(MonoTime asked, MonoTime answered);
  void stale(MonoTime asked) { stale_at_ = std::max(stale_at_, asked); }
  Duration period() const { return (period_min_ + period_max_) / 2; }

 private:
  void lose_phase(MonoTime asked, MonoTime answered);
  void late(MonoTime asked, MonoTime answered);
  void narrow_period(std::int64_t steps);
  void widen_period(double below, double above);

  Duration nominal_{};
  Duration period_min_{}, period_max_{};
  bool started_ = false;  // an edge has been seen
  MonoTime first_poll_{};
  MonoTime lo_{}, hi_{};  // the newest edge seen lies in (lo_, hi_]
  MonoTime stale_at_{};  // the newest question that got an old value
  MonoTime anchor_lo_{}, anchor_hi_{};  // an older edge, to measure the period
  std::int64_t since_anchor_ = 0;  // edges since the anchor
  int unverified_ = 0;  // consecutive early polls that found a new value
};

}  // namespace lcrig::lcr6100
