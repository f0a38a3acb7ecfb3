// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/sample_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lcrig {

namespace {

constexpr double kWindow_s = 10;  // a crystal clock drifts by microseconds within it
constexpr double kFrozen_s = 0.5;
constexpr double kRateError = 0.01;  // worse than any crystal

}  // namespace

SampleClock::Finding SampleClock::add(std::span<const FrameSample> batch) {
  Finding out;
  const FrameSample& first = batch.front();
  const FrameSample& last = batch.back();
  if (!first.device_time_s || !last.device_time_s) return out;
  const double host = to_seconds(last.received.time_since_epoch());
  out.news = judge(host, *last.device_time_s);
  if (stands_since_s_) return out;  // a clock that stands gives no ages
  if (!has_window_ || host - window_begin_s_ > kWindow_s) {
    quickest_before_s_ = has_window_ ? quickest_s_ : host - *last.device_time_s;
    quickest_s_ = host - *last.device_time_s;
    window_begin_s_ = host;
    has_window_ = true;
  }
  quickest_s_ = std::min(quickest_s_, host - *last.device_time_s);
  const double fresh = std::min(quickest_s_, quickest_before_s_);
  out.age_s = host - *first.device_time_s - fresh;
  return out;
}

std::optional<SampleClock::News> SampleClock::judge(double host_s, double device_s) {
  const bool moved = !last_device_s_ || device_s != *last_device_s_;
  const bool back = last_device_s_ && device_s < *last_device_s_;
  last_device_s_ = device_s;
  if (back) {  // the link reports the jump itself
    first_host_s_.reset();
    has_window_ = false;
  }
  if (!moved) {
    if (!stands_since_s_) stands_since_s_ = host_s;
    if (host_s - *stands_since_s_ < kFrozen_s || std::exchange(frozen_told_, true)) return {};
    return News(
        EventKind::device_clock_frozen,
        fmt::format("the device's clock stands at {:.3f} s: nobody knows how old its samples are",
                    device_s));
  }
  if (stands_since_s_) has_window_ = false;
  stands_since_s_.reset();
  if (!first_host_s_) {
    first_host_s_ = host_s;
    first_device_s_ = device_s;
  }
  const double host = host_s - *first_host_s_, device = device_s - *first_device_s_;
  if (host < kWindow_s) return {};
  first_host_s_ = host_s;
  first_device_s_ = device_s;
  if (std::abs(device / host - 1) < kRateError || std::exchange(rate_told_, true)) return {};
  return News(
      EventKind::device_clock_rate,
      fmt::format("the device's clock went {:.3f} s in {:.3f} s: its rate is wrong", device, host));
}

}  // namespace lcrig
