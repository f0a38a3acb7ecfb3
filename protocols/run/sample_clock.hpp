// SPDX-License-Identifier: Apache-2.0
// How old samples are when they arrive, by the device's own clock, and whether that clock can be
// believed. The two clocks have no common zero: the quickest arrivals of the last seconds count as
// fresh.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "drivers/load_frame.hpp"

namespace lcrig {

class SampleClock {
 public:
  using News = std::pair<EventKind, std::string>;  // of the device's clock, an event
  struct Finding {
    double age_s = 0;  // of the oldest sample of this batch
    std::optional<News> news;
  };
  Finding add(std::span<const FrameSample> batch);
  void forget() { *this = SampleClock(); }  // after a gap, or in a new session

  static constexpr double kLate_s = 0.2;

 private:
  std::optional<News> judge(double host_s, double device_s);

  std::optional<double> first_host_s_, first_device_s_;  // of the present judgement of its rate
  std::optional<double> last_device_s_;
  std::optional<double> stands_since_s_;  // host time since which the device's clock has not moved
  double quickest_s_ = 0, quickest_before_s_ = 0;  // least arrival minus taking, in two windows
  double window_begin_s_ = 0;
  bool has_window_ = false;
  bool frozen_told_ = false, rate_told_ = false;
};

}  // namespace lcrig
