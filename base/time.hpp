// SPDX-License-Identifier: Apache-2.0
// Durations and points of monotonic time, for code that stores times or computes with them. Code
// that waits includes base/clock.hpp, which brings Asio.
#pragma once

#include <chrono>
#include <cstdint>

namespace lcrig {

using Duration = std::chrono::nanoseconds;
// Monotonic time of the run's clock, ns; in the database as `_mono_ns`.
struct MonoTag {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
};
using MonoTime = std::chrono::time_point<MonoTag, Duration>;

constexpr Duration from_seconds(double s) {
  return Duration(static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5)));
}
constexpr double to_seconds(Duration d) {
  return static_cast<double>(d.count()) * 1e-9;
}

}  // namespace lcrig
