// SPDX-License-Identifier: Apache-2.0
// Measures the frame of a run at rest, and waits for its samples. The run passes it every sample;
// what they show is in the state of the rig.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "drivers/load_frame.hpp"

namespace lcrig {

class EventLog;
class RestMeasurement;
class RigState;
struct RunSetup;

class RestMeter {
 public:
  static constexpr Duration kRestTime = std::chrono::milliseconds(500);  // of a measurement at rest

  // All must outlive it.
  RestMeter(const RunSetup& setup, const EventLog& log, const RigState& rig);
  ~RestMeter();

  void add(std::span<const FrameSample> samples);
  // Errors: no_reply when the last known force is too old to tell in which direction the force
  // falls.
  Result<double> present_force_N() const;
  double noise_N() const { return noise_N_; }  // of the last measurement

  // Measures force and travel at rest for at least this long. Errors: no_reply.
  Task<Result<RestMeasurement>> measure(Duration at_least);
  // The same, but longer if the digits of the load cell do not change. Errors: refused if they
  // never do.
  Task<Result<RestMeasurement>> measure_alive();
  // Waits for samples, with a force if `feels`. Errors: no_reply.
  Task<Result<>> await_samples(bool feels);

 private:
  std::string_view no_force() const;  // why there is none
  const RunSetup& setup_;
  const EventLog& log_;
  const RigState& rig_;
  std::int64_t samples_ = 0;
  std::unique_ptr<RestMeasurement> open_;  // filled while `measure` waits
  double noise_N_ = 0;
};

}  // namespace lcrig
