// SPDX-License-Identifier: Apache-2.0
// Limits the time and memory that clients may take from the thread of the instruments. The control
// sessions ask before they read on or accept a call; dispatch.cpp limits the structure of a line.
#pragma once

#include <cstddef>

#include "base/time.hpp"

namespace lcrig {

// Limits for one message. The largest legitimate one is a run.start with its parameters.
inline constexpr std::size_t kControlDepthMax = 16, kControlValuesMax = 5000;

// Shared by all clients of one server.
class ControlAllowance {
 public:
  ControlAllowance(double bytes_per_s, std::size_t max_call_bytes, MonoTime now)
      : bytes_per_s_(bytes_per_s), max_call_bytes_(max_call_bytes), refilled_(now) {}

  // How long the reader of a line of this size must wait before it reads on. A line of ordinary
  // length never waits because of other clients' long lines, because it may be an abort.
  Duration charge(std::size_t bytes, MonoTime now);

  // The share of its rate and burst that each client gets: all of it for up to eight clients.
  double share() const;
  void come() { ++clients_; }
  void go() { --clients_; }

  bool take_call(std::size_t bytes);  // false: the calls in progress already take too many bytes
  void end_call(std::size_t bytes) { call_bytes_ -= bytes; }

 private:
  double bytes_per_s_, tokens_ = 1 << 20U;  // bytes; tokens for at most one line of the largest
                                            // size
  std::size_t max_call_bytes_, call_bytes_ = 0, clients_ = 0;
  MonoTime refilled_;
};

}  // namespace lcrig
