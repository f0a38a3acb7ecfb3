// SPDX-License-Identifier: Apache-2.0
// Shows the frame to a run: the newest force and travel, and looks at it while it stands. The run
// feeds it with every sample; steps, motions and the recovery read it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_memory.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

class FrameView {
 public:
  static constexpr Duration kRestTime = std::chrono::milliseconds(500);  // of a look at rest

  FrameView(const RunSetup& setup, const EventLog& log) : setup_(setup), log_(log) {}

  void add(std::span<const FrameSample> samples);
  // Where a motion ended, as the frame reports it. At ten samples per second the last sample is
  // still one of the motion; a step that went by it might begin in the wrong direction.
  void take_standstill(const MotionOutcome& outcome);

  std::optional<double> force_N() const { return force_N_; }  // the last one that was known
  MonoTime force_known() const { return force_known_; }  // when that was
  // Errors: no_reply when the last known force is too old to tell which way leads to less.
  Result<double> present_force_N() const;
  std::optional<double> travel_m() const { return memory_.travel_m; }
  // Whether the last known force is that of now: it is older in an overload of the cell, and when
  // samples come without it.
  bool shows_force() const;
  // From the last samples alone. The place that the frame reports at the end of a motion changes
  // force_N() and travel_m(), not these.
  std::optional<double> shown_force_N() const { return shown_force_N_; }
  std::optional<double> shown_travel_m() const { return shown_travel_m_; }
  // Where the last motion ended.
  std::optional<double> done_force_N() const { return done_force_N_; }
  double wavers_N() const { return wavers_N_; }  // scatter of the force at the last look at rest
  std::optional<MonoTime> last_sample() const { return last_sample_; }

  // Facts that are compared when the frame comes back after a loss.
  const FrameMemory& memory() const { return memory_; }
  void forget(bool zeroed);  // all but whether the run has zeroed the frame
  void zeroed(bool yes) { memory_.zeroed = yes; }
  // Sum of all zeros of the force of this run: how far they moved its origin.
  std::optional<double> zeros_N() const { return zeros_N_; }
  void sum_zeros(std::optional<double> sum_N) { zeros_N_ = sum_N; }

  // Looks at it at least so long while it stands. Errors: no_reply.
  Task<Result<Rest>> watch_rest(Duration at_least);
  // As watch_rest, and longer while the digits of the load cell have not changed. Errors: refused
  // when they never do.
  Task<Result<Rest>> living_rest();
  // Waits until samples come, with a force if `feels`. Errors: no_reply.
  Task<Result<>> await_samples(bool feels);

 private:
  const RunSetup& setup_;
  const EventLog& log_;
  FrameMemory memory_;
  std::int64_t samples_ = 0;
  std::optional<MonoTime> last_sample_;
  std::optional<double> force_N_;
  MonoTime force_known_;
  bool overloaded_ = false;  // the cell, at the last sample
  std::optional<double> shown_force_N_, shown_travel_m_, done_force_N_;
  std::optional<Rest> watched_;  // fed while somebody watches
  double wavers_N_ = 0;
  std::optional<double> zeros_N_;
};

}  // namespace lcrig
