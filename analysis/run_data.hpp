// SPDX-License-Identifier: Apache-2.0
// Loads a run in compact rows that every metric and picture can use.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "analysis/meter_accuracy.hpp"
#include "base/pressure_area.hpp"
#include "events/payloads.hpp"
#include "storage/runs.hpp"

namespace lcrig {

// One fresh reading with a capacitance. It has 48 bytes, because a run has millions. Force and
// travel are those in the middle of the measuring window. They are absent before the first frame
// sample, after the last, and across a gap.
struct RunReading {
  double t_s = 0;  // middle of the measuring window, since the run's start
  double capacitance_F = 0;
  float force_N = 0, travel_m = 0;  // valid only if has_force(), has_travel()
  float alignment_s = 0;  // standard uncertainty of the instant (window, spacing of the samples)
  float force_rate_N_s = 0;  // between the frame's samples around it
  std::int32_t level = 0;  // 0: it does not belong to a `measure` step
  std::int32_t index = 0;  // within the level, from 1; 0: it was not counted
  std::int32_t repeat = 0;  // of the outermost repeat, from 1; 0: none
  std::uint16_t step = 0;  // index into RunData::steps
  std::uint8_t flags = 0;  // low bits of storage/flags.hpp
  std::uint8_t present = 0;  // bits: 1 force, 2 travel

  bool has_force() const { return (present & 1) != 0; }
  bool has_travel() const { return (present & 2) != 0; }
  // Standard uncertainty of the force that follows from the uncertainty of the instant.
  double alignment_N() const;
  double half_window_s() const;  // includes half the spacing of the samples around it
};

// A frame sample. A long run keeps only some of them (RunData::frame_stride): from each stretch the
// samples of least and of largest force, in the order of time, so that no peak is lost.
struct FramePoint {
  double t_s = 0;  // since the run's start
  float force_N = std::numeric_limits<float>::quiet_NaN();  // NaN: the sample had none
  float travel_m = std::numeric_limits<float>::quiet_NaN();  // NaN: the sample had none
  bool after_gap = false;  // samples are missing before it: draw no line to the point before
};

// A `measure` step as it was executed.
struct LevelRow {
  std::int32_t level = 0, repeat = 0, index = 0;  // from 1; index: within the repeat
  std::string step_id;
  std::optional<double> target_force_N, target_pressure_Pa;
  std::int32_t planned_readings = 0;
  double begin_s = 0;
  bool abandoned = false;  // an instrument was lost during the level, so none of its readings count
};

struct EventRow {
  double t_s = 0;
  EventName kind;
  std::string step_id, detail;
};

// A step from its begin to its end.
struct StepSpan {
  double begin_s = 0, end_s = 0;  // of a run that broke off: the run's last row
};

struct RunData {
  std::int64_t run = 0;
  RunRow row;
  RunListing listing;
  // Pressures are force over this area: of `pressure`. Absent: there are no pressures.
  std::optional<double> area_m2;
  PressureArea pressure;
  std::optional<double> probe_diameter_m;
  bool dead_weights = false;
  std::optional<double> force_class_percent;  // of the load cell; absent: not stated
  std::optional<MeterCorrections> corrections;  // of the meter; absent: not recorded
  bool replayed = false;  // a recording was played back through simulated instruments
  std::string function;  // function of the meter for these readings, as "Cp-D"
  // A setting of the meter and the time from which it is valid. Empty: not known.
  struct Settings {
    double since_s = 0;
    MeterSetting meter;
  };
  std::vector<Settings> settings;

  std::vector<RunReading> readings;  // by time; proven ones only, where the proof is known
  bool proof_known = false;  // false: an older lcrig recorded the run and read no settings back
  std::int64_t unproven_readings = 0;  // fresh ones, not used (storage/proof.hpp)
  std::int64_t fresh_readings = 0;  // including those without a capacitance
  std::int64_t repeated_readings = 0;  // the meter repeated its last value
  std::int64_t overloads = 0;  // fresh readings without a capacitance
  std::int64_t impossible = 0;  // values too large to be a capacitance; not used
  std::int64_t other_function = 0;  // taken under functions that do not measure a capacitance
  std::int64_t frame_samples = 0, frame_gaps = 0;
  std::int64_t times_of_arrival = 0;  // samples with only a time of arrival
  std::vector<FramePoint> frame;  // all samples, or some of them
  std::int64_t frame_stride = 1;  // samples in a stretch of which two were kept; 1: all are here
  std::vector<LevelRow> levels;  // indexed by level number - 1
  std::vector<EventRow> events;
  std::vector<StepSpan> spans;
  std::vector<std::string> steps;  // names for RunReading::step
  double duration_s = 0;  // time from the start to the last row
  std::optional<double> contact_s;  // a second before the first recorded touch
  std::optional<double> rest_force_N;  // force that was read while nothing touched

  bool has_frame() const { return frame_samples > 0; }
};

struct LoadOptions {
  std::int64_t frame_points = 20000;  // keep about this many frame samples at most
};

// Reads one run and changes nothing. Errors: no such run; the run is still going on; no readings;
// only readings of functions that do not measure a capacitance; no proven reading. A run without a
// frame or one that was aborted is loaded; the missing data are absent.
Result<RunData> load_run_data(const Database& db, std::int64_t run,
                              const LoadOptions& options = {});

}  // namespace lcrig
