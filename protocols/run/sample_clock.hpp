// SPDX-License-Identifier: Apache-2.0
// Measures how old samples are when they arrive, by the device's own clock, and judges whether that
// clock can be believed. The two clocks have no common zero, so the quickest arrivals of the last
// seconds count as fresh. Used by Losses.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

class SampleClock {
 public:
  using News = std::pair<EventKind, std::string>;  // an event about the device's clock
  struct Finding {
    double age_s = 0;  // of the oldest sample in this batch
    std::optional<News> news;
  };
  Finding add(std::span<const FrameSample> batch);
  void forget() { *this = SampleClock(); }  // call it after a gap, or in a new session

  static constexpr double kLate_s = 0.2;

 private:
  std::optional<News> judge(double host_s, double device_s);

  std::optional<double> first_host_s_, first_device_s_;  // start of the current check of its rate
  std::optional<double> last_device_s_;
  std::optional<double> stands_since_s_;  // host time when the device's clock stopped
  double quickest_s_ = 0, quickest_before_s_ = 0;  // least delay of arrival, in two windows
  double window_begin_s_ = 0;
  bool has_window_ = false;
  bool frozen_told_ = false, rate_told_ = false;
};

}  // namespace lcrig
