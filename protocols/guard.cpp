// SPDX-License-Identifier: Apache-2.0
#include "protocols/guard.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lcrig {

namespace {

struct Side {
  double low, high;
};

// The window, widened while a tripped run finds its way back.
Side widened(double low, double high, bool returning) {
  const double slack = returning ? 0.1 * (high - low) : 0;
  return {low - slack, high + slack};
}

}  // namespace

std::optional<std::string> Guard::check(const FrameSample& sample) {
  if ((sample.flags & frame_flag::kForceOverload) != 0) {
    return "the force is beyond the load cell";
  }
  if (sample.force_N) {
    last_ = sample.received;  // a sample without a force guards nothing
    peak_force_N_ = std::max(peak_force_N_, *sample.force_N);
    if (auto why = check_force(*sample.force_N)) return why;
  }
  return sample.travel_m ? check_travel(*sample.travel_m) : std::nullopt;
}

std::optional<std::string> Guard::check_force(double force_N) {
  const Side side = widened(limits_.force_min_N, limits_.force_max_N, returning_);
  if (force_N >= side.low && force_N <= side.high) return std::nullopt;
  return fmt::format("force {:.4f} N is outside the limits {:.4f} to {:.4f} N", force_N,
                     limits_.force_min_N, limits_.force_max_N);
}

std::optional<std::string> Guard::check_travel(double travel_m) {
  constexpr double kUnbounded = 1e9;
  const Side side = widened(limits_.travel_min_m.value_or(-kUnbounded),
                            limits_.travel_max_m.value_or(kUnbounded), returning_);
  if (travel_m >= side.low && travel_m <= side.high) return std::nullopt;
  return fmt::format("travel {:.4f} mm is outside the limits {:.4f} to {:.4f} mm", travel_m * 1e3,
                     limits_.travel_min_m.value_or(-kUnbounded) * 1e3,
                     limits_.travel_max_m.value_or(kUnbounded) * 1e3);
}

std::optional<std::string> Guard::check_age(MonoTime now) const {
  if (!watch_age_ || !last_ || now - *last_ <= stale_after_) return std::nullopt;
  return fmt::format("no force sample for {:.2f} s", to_seconds(now - *last_));
}

void Guard::allow_return() {
  returning_ = true;
}

}  // namespace lcrig
