// SPDX-License-Identifier: Apache-2.0
// The request for a run, and its outcome. Used by the control socket, the daemon and rehearsals.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/exit_status.hpp"
#include "base/pressure_area.hpp"
#include "base/result.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {

struct RunRequest {
  std::string protocol_name, protocol_text;
  ParameterValues parameters;
  // Without a text, the daemon looks the name up in its database; a replay needs neither.
  std::string specimen_name, specimen_text;
  std::string operator_name, note;  // without an operator: the user at the other end of the socket
};

struct RunOutcome {
  std::int64_t run = 0;
  ExitStatus exit_status = ExitStatus::fail;
  std::optional<Errc> code;  // why it was not a success
  std::string reason;
  bool stands = true;  // the frame confirmed standstill, or was never asked to move
  std::optional<double> stood_after_s;  // when it did so only after the end of the run
  bool simulated = false;  // a simulator or a recording stood for at least one instrument
  std::int64_t lcr_readings = 0, measure_readings = 0, unproven_readings = 0;  // as in RunRecord
  std::int64_t frame_samples = 0;
  double duration_s = 0;  // by the clock of the rig
  double wall_s = 0;  // by the clock of this computer
  std::string anchor;  // of the run's hash chain (storage/anchor.hpp); empty: the end was not
                       // stored
  std::optional<PressureArea> pressure;  // what its pressures are over; absent: an older daemon
};

}  // namespace lcrig
