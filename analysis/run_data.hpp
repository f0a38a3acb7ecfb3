// SPDX-License-Identifier: Apache-2.0
// A run loaded for analysis: what every metric and every picture needs, in compact rows.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "analysis/meter_accuracy.hpp"
#include "events/payloads.hpp"
#include "storage/runs.hpp"

namespace lcrig {

// One fresh reading that has a capacitance. 48 bytes: a run has millions. The load is that of the
// middle of the measuring window; it is absent before the first frame sample, after the last, and
// across a gap.
struct RunReading {
  double t_s = 0;  // middle of the measuring window, since the run's start
  double capacitance_F = 0;
  float force_N = 0, travel_m = 0;  // look at has_force(), has_travel()
  float alignment_s = 0;  // standard uncertainty of the instant (window, spacing of the samples)
  float force_rate_N_s = 0;  // between the samples around it
  std::int32_t level = 0;  // 0: not one of a `measure` step
  std::int32_t index = 0;  // within the level, from 1; 0: not counted
  std::int32_t repeat = 0;  // of the outermost repeat, from 1; 0: none
  std::uint16_t step = 0;  // index into RunData::steps
  std::uint8_t flags = 0;  // storage/flags.hpp, low bits
  std::uint8_t present = 0;  // 1: force, 2: travel

  bool has_force() const { return (present & 1) != 0; }
  bool has_travel() const { return (present & 2) != 0; }
  // Standard uncertainty of the force that comes from that of the instant.
  double alignment_N() const;
  double half_window_s() const;  // and half the spacing of the samples around it
};

// A frame sample. A long run keeps only some (RunData::frame_stride): in each stretch the one of
// least and the one of largest force, in the order of time, so that no peak is lost.
struct FramePoint {
  double t_s = 0;  // since the run's start
  float force_N = std::numeric_limits<float>::quiet_NaN();  // NaN: the sample had none
  float travel_m = std::numeric_limits<float>::quiet_NaN();  // travel; likewise
  bool after_gap = false;  // samples are missing before it: do not join it to the point before
};

// A `measure` step as it was executed.
struct LevelRow {
  std::int32_t level = 0, repeat = 0, index = 0;  // from 1; index: within the repeat
  std::string step_id;
  std::optional<double> target_force_N, target_pressure_Pa;
  std::int32_t planned_readings = 0;
  double begin_s = 0;
  bool abandoned = false;  // an instrument was lost in it; none of its readings counts
};

struct EventRow {
  double t_s = 0;
  EventName kind;
  std::string step_id, detail;
};

// A step from its begin to its end.
struct StepSpan {
  double begin_s = 0, end_s = 0;  // a run that broke off ends its last step with its last row
};

struct RunData {
  std::int64_t run = 0;
  RunRow row;
  RunListing listing;
  std::optional<double> area_m2;  // of the probe; absent: no pressures
  std::optional<double> probe_diameter_m;
  bool dead_weights = false;
  bool replayed = false;  // a recording was played back through simulated instruments
  std::string function;  // of the readings that are here, "Cp-D"
  // The settings of the meter and since when; the first since the start. Empty: not known.
  struct Settings {
    double since_s = 0;
    MeterSetting meter;
  };
  std::vector<Settings> settings;

  std::vector<RunReading> readings;  // by time
  std::int64_t fresh_readings = 0;  // with and without a capacitance
  std::int64_t repeated_readings = 0;  // the meter showed its last value again
  std::int64_t overloads = 0;  // fresh, no capacitance
  std::int64_t impossible = 0;  // a number that is no capacitance; not used
  std::int64_t other_function = 0;  // of functions that do not measure a capacitance
  std::int64_t frame_samples = 0, frame_gaps = 0;
  std::int64_t times_of_arrival = 0;  // samples whose own time is not known
  std::vector<FramePoint> frame;  // all, or thinned
  std::int64_t frame_stride = 1;  // samples in a stretch of which two were kept; 1: all are there
  std::vector<LevelRow> levels;  // by level, which is level row - 1
  std::vector<EventRow> events;
  std::vector<StepSpan> spans;
  std::vector<std::string> steps;  // names for RunReading::step
  double duration_s = 0;  // of the rows
  std::optional<double> contact_s;  // a second before the first touch that the run tells of
  std::optional<double> rest_force_N;  // as read while nothing touched

  bool has_frame() const { return frame_samples > 0; }
};

struct LoadOptions {
  std::int64_t frame_points = 20000;  // keep no more frame samples than about this
};

// Reads one run, without changing anything. Errors: no such run; the run is still going on; no
// readings; readings of functions that do not measure a capacitance only. A run without a frame, or
// one that was aborted, is loaded: what is missing is missing.
Result<RunData> load_run_data(const Database& db, std::int64_t run,
                              const LoadOptions& options = {});

}  // namespace lcrig
