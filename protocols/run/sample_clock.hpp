// SPDX-License-Identifier: Apache-2.0
// Measures how old samples are when they arrive, by the device's own clock, and judges whether that
// clock can be believed. The two clocks have no common zero, and the device's may run a little
// faster or slower. A sample is as old as the earlier ones prove, whatever the rate may be. Used by
// Losses.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

class SampleClock {
 public:
  using News = std::pair<EventKind, std::string>;  // an event about the device's clock
  struct Finding {
    double age_s = 0;  // of the oldest sample in this batch, at least
    std::optional<News> news;
  };
  Finding add(std::span<const FrameSample> batch);
  void forget() { *this = SampleClock(); }  // call it after a gap, or in a new session

  static constexpr double kLate_s = 0.2;
  // A clock whose rate is further off is none: an RC oscillator keeps 2 %.
  static constexpr double kMostError = 0.025;

 private:
  struct Arrival {
    double host_s, device_s;
  };
  bool steps_within(std::span<const FrameSample> batch);
  std::optional<News> follow(double host_s, double device_s, bool moves);
  std::optional<News> judge_rate();
  void remember(Arrival now);
  double age_s(double host_s, double device_s) const;

  std::optional<double> last_device_s_;
  std::int64_t last_seq_ = 0;
  double period_s_ = 0;  // shortest time between two samples; 0: not known
  double last_each_s_ = 0;  // the last one
  std::optional<double> stands_since_s_;  // host time when the device's clock stopped
  std::deque<Arrival> quickest_;  // the quickest one of each part of the last seconds
  double slowest_ = 1 - kMostError, fastest_ = 1 + kMostError;  // rates that it may have
  bool is_measured_ = false;
  bool frozen_reported_ = false, rate_reported_ = false;
  bool is_useless_ = false;  // its rate is no clock's
};

}  // namespace lcrig
