// SPDX-License-Identifier: Apache-2.0
// Input and result of a run. The daemon fills the input and stores the result.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/exit_status.hpp"
#include "base/quantity.hpp"
#include "base/time.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "protocols/protocol.hpp"
#include "protocols/rig/forecast.hpp"
#include "protocols/rig/limits.hpp"
#include "protocols/run/pace.hpp"
#include "protocols/run/point.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

class Respondent;

struct RunResult {
  ExitStatus exit_status = ExitStatus::fail;
  std::string reason;  // empty on success
  std::optional<Errc> code;  // why it was no success
  double peak_force_N = 0;
  bool stands = true;  // the frame confirmed it, or was never asked to move
};

// Everything referred to here must outlive the run.
struct RunSetup {
  RunSetup(Clock& c, LcrMeter& l, LoadFrame& f, RunSink& s, const Protocol& p)
      : clock(c), lcr(l), frame(f), sink(s), protocol(p) {}
  // Whether this run may make the frame move.
  bool moves() const { return commands && frame.capabilities().motion; }

  Clock& clock;
  LcrMeter& lcr;  // identified and configured
  LoadFrame& frame;  // identified
  RunSink& sink;
  const Protocol& protocol;
  Environment environment;  // parameters
  BoundLimits limits;  // of the protocol
  // False: the protocol asks nothing of the frame, which belongs to somebody else. The frame is
  // only observed, and never stopped.
  bool commands = true;
  double frame_rate_Hz = kFrameRate_Hz;  // of the samples
  ForceClass cell = kAssumedForceClass;  // of the load cell, as the plan has it
  std::optional<Forecast> forecast;  // bounds the force; set for a frame that moves
  std::optional<double> start_gap_m;  // as a person stated it
  std::string plan_json;  // figures and assumptions of the plan, stored with the run
  // Plans again when the place of contact is known, before anything is pressed. May be empty.
  std::function<Task<Result<>>(double start_travel_m, double contact_travel_m)> check_at_contact;
  LcrSettings lcr_settings;  // as read back
  CorrectionsOn corrections;  // which ones the meter applied before the run
  // Of the steps: what their pressures are over. Of stored levels: always the probe.
  PressureArea pressure;
  double gravity_m_s2 = kStandardGravity_m_s2;  // at the place of the rig
  PlannedTimes planned;  // for the progress that people see
  std::int64_t run = 0;
  std::string specimen;
  // The person whose confirmation `record until confirmed` waits for.
  Operator* person = nullptr;
  Respondent* respondent = nullptr;  // answers questions; nullptr: people answer through the socket
  // The run to continue, after a person confirmed the specimen, instead of beginning at the first
  // step.
  std::optional<Continuation> continues;
  std::function<void(const RunProgress&)> on_step;  // called when a step begins; may be empty
  // Called when an instrument is lost, with the reason, and when it is back (nullptr); may be
  // empty.
  std::function<void(Instrument, const Error* lost)> on_loss;
  std::function<void()> on_stop;  // called when `Run::stands` or `failed_stops` grew; may be empty
};

}  // namespace lcrig
