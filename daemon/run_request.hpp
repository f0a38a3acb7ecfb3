// SPDX-License-Identifier: Apache-2.0
// A run as somebody asks for it, and how it ended: the same for the control socket, the daemon and
// a rehearsal.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/exit_status.hpp"
#include "base/result.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {

struct RunRequest {
  std::string protocol_name, protocol_text;
  ParameterValues parameters;
  // Without a text the daemon looks the name up in its database; a replay needs neither.
  std::string specimen_name, specimen_text;
  std::string operator_name, note;  // no operator: the user at the other end of the socket
};

struct RunOutcome {
  std::int64_t run = 0;
  ExitStatus exit_status = ExitStatus::fail;
  std::optional<Errc> code;  // why, when it was not a success
  std::string reason;
  bool stands = true;  // as far as the frame was asked to move, it confirmed that it stands
  bool simulated = false;  // a simulator or a recording stood for at least one instrument
  std::int64_t lcr_readings = 0, measure_readings = 0, frame_samples = 0;
  double duration_s = 0;  // of the rig
  double wall_s = 0;  // of this computer
  std::string anchor;  // of the run's hash chain (storage/anchor.hpp); empty: its end is not stored
};

}  // namespace lcrig
