// SPDX-License-Identifier: Apache-2.0
// Force and travel at any instant of a run, interpolated between the frame's samples; streaming.
// The alignment of readings and the export use it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "analysis/device_clock.hpp"
#include "analysis/frame_rows.hpp"

namespace lcrig {

struct FrameState {
  std::optional<double> force_N, travel_m;
  // Time between the two samples around it, ns; 0 when held (dead weights).
  std::int64_t spacing_ns = 0;
  double clock_s = 0;  // standard uncertainty of the samples' times, from the clocks
  double force_rate_N_s = 0;
};

// The frame was a rod with weights, by RunRow::frame_capabilities_json.
bool has_dead_weights(std::string_view frame_capabilities_json);

class FrameTrack {
 public:
  struct Sample {
    std::int64_t t_ns = 0;  // on the run's clock
    std::int64_t device_seq = 0;
    double clock_s = 0;
    bool of_arrival = false;  // the time is that of arrival: nothing better is known
    bool after_gap = false;  // told by the recorder, or a number is missing before it
    std::optional<double> force_N, travel_m;
  };

  // `hold`: a sample is valid until the next one (dead weights); else linear between samples.
  static Result<FrameTrack> open(const Database& db, std::int64_t run, bool hold,
                                 DeviceClock clock);
  // Instants must not run backwards. Empty values: before the first sample, after the last, across
  // a gap (device samples missing), or where a sample has none.
  Result<FrameState> at(std::int64_t mono_ns);
  // Called with every sample once, in order, as `at` and `drain` come to it.
  void set_listener(std::function<void(const Sample&)> listener) {
    listener_ = std::move(listener);
  }
  Result<> drain();  // reads the rest

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
