// SPDX-License-Identifier: Apache-2.0
// Gives force and travel at any instant of a run, interpolated between the frame's samples as they
// stream past. The alignment of readings and the export use it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "analysis/device_clock.hpp"
#include "analysis/frame_rows.hpp"

namespace lcrig {

struct FrameState {
  std::optional<double> force_N, travel_m;
  // Time between the two samples around the instant, ns. 0 when a sample is held (dead weights).
  std::int64_t spacing_ns = 0;
  double clock_s = 0;  // standard uncertainty of the samples' times, from the clocks
  double force_rate_N_s = 0;
};

class FrameTrack {
 public:
  struct Sample {
    std::int64_t t_ns = 0;  // on the run's clock
    std::int64_t device_seq = 0;
    double clock_s = 0;
    bool of_arrival = false;  // true: only the time of arrival is known
    bool after_gap = false;  // the recorder reported a gap, or a sample number is missing before it
    std::optional<double> force_N, travel_m;
  };

  // `hold`: a sample is valid until the next (dead weights). Otherwise values are interpolated.
  static Result<FrameTrack> open(const Database& db, std::int64_t run, bool hold,
                                 DeviceClock clock);
  // Instants must not decrease. Values are absent before the first sample, after the last, across a
  // gap (samples of the device are missing), and where a sample has none.
  Result<FrameState> at(std::int64_t mono_ns);
  // The listener is called once with every sample, in order, as `at` and `drain` reach it.
  void set_listener(std::function<void(const Sample&)> listener) {
    listener_ = std::move(listener);
  }
  Result<> drain();  // reads all samples that are left

 private:
  FrameTrack(FrameRows rows, bool hold, DeviceClock clock)
      : rows_(std::move(rows)), hold_(hold), clock_(std::move(clock)) {}
  Result<> advance();

  FrameRows rows_;
  bool hold_;
  DeviceClock clock_;
  bool exhausted_ = false;
  std::function<void(const Sample&)> listener_;
  std::optional<Sample> before_, after_;
};

}  // namespace lcrig
