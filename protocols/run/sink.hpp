// SPDX-License-Identifier: Apache-2.0
// Output of a run: rows to store and a status to show. The recorder implements RunSink.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/pressure_area.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "events/payloads.hpp"
#include "protocols/load_level.hpp"
#include "protocols/question.hpp"
#include "protocols/run/standstill.hpp"

namespace lcrig {

struct ReadingTag {
  std::string step_id;
  std::int64_t repeat = 0;
  std::int64_t level = 0;  // 0: not part of a `measure` step
  std::int64_t index = 0;  // within the level, from 1; 0: a repeated (not fresh) value
  std::optional<MonoTime> planned;  // when it was due
};

class RunSink {
 public:
  virtual ~RunSink() = default;
  // Queue a row and never block. A sink that can take no more rows reports this through its `fault`
  // hook.
  virtual void reading(const LcrReading& reading, const ReadingTag& tag) = 0;
  virtual void samples(std::span<const FrameSample> samples) = 0;
  virtual void level(const LoadLevel& level) = 0;
  virtual void event(const RunEvent& event) = 0;
  // Returns when everything queued so far is committed, or with the error that prevented it.
  virtual Task<Result<>> flush() = 0;
};

enum class Instrument { lcr, frame };
template <>
inline constexpr EnumWords<2> kWordsOf<Instrument>{"lcr", "frame"};

enum class RunState {
  preparing,
  running,
  stopping,  // it is about to wait, and standstill is not confirmed yet
  holding_force,  // the meter is away, and the frame moves to hold its force
  paused,
  waiting_for_operator,
  waiting_for_instrument,
  finishing,
  ended
};
template <>
inline constexpr EnumWords<9> kWordsOf<RunState>{"preparing",
                                                 "running",
                                                 "stopping",
                                                 "holding_force",
                                                 "paused",
                                                 "waiting_for_operator",
                                                 "waiting_for_instrument",
                                                 "finishing",
                                                 "ended"};
// Whether the run waits in this state, so that a person may reach to the rig. Such a state is
// entered only with the proof that the frame stands (ProgressKeeper).
constexpr bool waits(RunState state) {
  switch (state) {
    case RunState::paused:
    case RunState::waiting_for_operator:
    case RunState::waiting_for_instrument: return true;
    case RunState::preparing:
    case RunState::running:
    case RunState::stopping:
    case RunState::holding_force:
    case RunState::finishing:
    case RunState::ended: break;
  }
  return false;
}

// The progress of a run. Only the runner writes it.
struct RunProgress {
  std::int64_t run = 0;
  std::string protocol, specimen;
  RunState state = RunState::preparing;
  Standstill standstill = Standstill::not_asked;
  std::string step_id, step_kind;
  std::int64_t repeat = 0, repeats = 0;
  double elapsed_s = 0, planned_s = 0;
  double left_s = 0;  // planned time left
  // The current step takes longer than planned, or the run waits: `left_s` follows after that, and
  // stands still.
  bool overdue = false;
  std::int64_t steps_done = 0;  // leaf steps, in the order of execution
  // The part at whose end it stops or pauses, on request: "level"; empty: no such request.
  std::string stops_after, pauses_at;
};

// Figures from the recorder: the numbers of stored rows, and the newest stored values. Readings
// that are not proven (docs/database.md) count only as such.
struct RunRecord {
  std::int64_t lcr_readings = 0, measure_readings = 0, unproven_readings = 0;
  std::int64_t frame_samples = 0;
  std::optional<double> capacitance_F, secondary, force_N, travel_m, pressure_Pa;
  PressureOn pressure_on = PressureOn::probe;  // of pressure_Pa
};

// Everything that a live line, `lcrig status` or a page shows.
struct RunStatus : RunProgress, RunRecord {
  RunStatus() = default;
  RunStatus(RunProgress progress, RunRecord record)
      : RunProgress(std::move(progress)), RunRecord(record) {}
  bool simulated = false;  // a simulator or a recording stands for at least one instrument
  std::string prompt;  // what the operator has to do
  std::optional<OpenQuestion> question;  // the open question, which the prompt puts into words
  std::optional<double> question_left_s;  // until its time-out
  std::optional<double> gap_m;
};

}  // namespace lcrig
