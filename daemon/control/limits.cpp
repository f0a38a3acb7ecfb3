// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/limits.hpp"

#include <algorithm>

namespace lcrig {

namespace {

constexpr std::size_t kLongLine = 4096;
constexpr double kBurst = 1 << 20U;  // bytes: one line of the largest size

}  // namespace

Duration ControlAllowance::charge(std::size_t bytes, MonoTime now) {
  if (bytes <= kLongLine) return {};
  tokens_ = std::min(kBurst, tokens_ + to_seconds(now - refilled_) * bytes_per_s_);
  refilled_ = now;
  tokens_ -= static_cast<double>(bytes);
  return tokens_ >= 0 ? Duration() : from_seconds(-tokens_ / bytes_per_s_);
}

double ControlAllowance::share() const {
  constexpr double kFullShares = 8;
  return std::min(1.0, kFullShares / static_cast<double>(std::max<std::size_t>(clients_, 1)));
}

bool ControlAllowance::take_call(std::size_t bytes) {
  if (call_bytes_ + bytes > max_call_bytes_) return false;
  call_bytes_ += bytes;
  return true;
}

}  // namespace lcrig
