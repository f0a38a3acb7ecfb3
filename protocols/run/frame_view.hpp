// SPDX-License-Identifier: Apache-2.0
// The frame as a run sees it: its newest force and travel, and measurements of it at rest. The run
// passes it every sample; steps, motions and the recovery read it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "protocols/run/event_log.hpp"
#include "protocols/run/frame_memory.hpp"
#include "protocols/run/frame_truth.hpp"
#include "protocols/run/setup.hpp"
#include "protocols/watch/rest.hpp"

namespace lcrig {

class FrameView {
 public:
  static constexpr Duration kRestTime = std::chrono::milliseconds(500);  // of a measurement at rest

  FrameView(const RunSetup& setup, const EventLog& log) : setup_(setup), log_(log) {}

  void add(std::span<const FrameSample> samples);
  // Takes the end of a motion from the frame's report. At ten samples per second the last sample
  // still belongs to the motion, and a step that relied on it might begin in the wrong direction.
  void take_standstill(const MotionOutcome& outcome);

  std::optional<double> force_N() const { return force_N_; }  // the last known one
  MonoTime force_known() const { return force_known_; }  // when it was known
  // Errors: no_reply when the last known force is too old to tell in which direction the force
  // falls.
  Result<double> present_force_N() const;
  std::optional<double> travel_m() const { return memory_.travel_m; }
  // Whether the last known force is the present one. It is older while the cell is overloaded, and
  // when samples come without a force.
  bool shows_force() const;
  // From the samples alone. The report at the end of a motion changes force_N() and travel_m(), but
  // not these.
  std::optional<double> shown_force_N() const { return shown_force_N_; }
  std::optional<double> shown_travel_m() const { return shown_travel_m_; }
  // The force where the last motion ended.
  std::optional<double> done_force_N() const { return done_force_N_; }
  ShownForce shown_force() const { return {force_N_, shows_force(), wavers_N_}; }
  std::optional<MonoTime> last_sample() const { return last_sample_; }

  // What is compared when the frame comes back after a loss.
  const FrameMemory& memory() const { return memory_; }
  void forget(bool zeroed);  // everything except whether the run zeroed the frame
  void zeroed(bool yes) { memory_.zeroed = yes; }
  // Sum of all force zeros of this run: how far they have moved the origin.
  std::optional<double> zeros_N() const { return zeros_N_; }
  void sum_zeros(std::optional<double> sum_N) { zeros_N_ = sum_N; }

  // Measures force and travel at rest for at least this long. Errors: no_reply.
  Task<Result<Rest>> watch_rest(Duration at_least);
  // The same, but longer if the digits of the load cell do not change. Errors: refused if they
  // never do.
  Task<Result<Rest>> living_rest();
  // Waits for samples, with a force if `feels`. Errors: no_reply.
  Task<Result<>> await_samples(bool feels);

 private:
  std::string_view no_force() const;  // why there is none
  const RunSetup& setup_;
  const EventLog& log_;
  FrameMemory memory_;
  std::int64_t samples_ = 0;
  std::optional<MonoTime> last_sample_;
  std::optional<double> force_N_;
  MonoTime force_known_;
  bool overloaded_ = false;  // state of the cell in the last sample
  std::optional<double> shown_force_N_, shown_travel_m_, done_force_N_;
  std::optional<Rest> watched_;  // filled while watch_rest waits
  double wavers_N_ = 0;
  std::optional<double> zeros_N_;
};

}  // namespace lcrig
