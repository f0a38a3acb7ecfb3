// SPDX-License-Identifier: Apache-2.0
// Limits of the time and memory that clients may cost the thread that runs the instruments. The
// control sessions ask before they read on or take a call; dispatch.cpp limits the structure of a
// line.
#pragma once

#include <cstddef>

#include "base/time.hpp"

namespace lcrig {

// Limits for one message. The largest honest one is a run.start with its parameters.
inline constexpr std::size_t kControlDepthMax = 16, kControlValuesMax = 5000;

// Shared by all clients of one server.
class ControlAllowance {
 public:
  ControlAllowance(double bytes_per_s, std::size_t max_call_bytes, MonoTime now)
      : bytes_per_s_(bytes_per_s), max_call_bytes_(max_call_bytes), refilled_(now) {}

  // How long the reader of a line of this size has to wait before it reads on. A line of ordinary
  // length never waits for other clients' long ones: it may be an abort.
  Duration charge(std::size_t bytes, MonoTime now);

  // Share of its own rate and burst that each client may have: all of it among up to eight clients.
  double share() const;
  void come() { ++clients_; }
  void go() { --clients_; }

  bool take_call(std::size_t bytes);  // false: too many bytes of calls are under way
  void end_call(std::size_t bytes) { call_bytes_ -= bytes; }

 private:
  double bytes_per_s_, tokens_ = 1 << 20U;  // bytes; at most one of the largest lines
  std::size_t max_call_bytes_, call_bytes_ = 0, clients_ = 0;
  MonoTime refilled_;
};

}  // namespace lcrig
