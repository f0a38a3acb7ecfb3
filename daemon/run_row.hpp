// SPDX-License-Identifier: Apache-2.0
// Makes the row of a run: all that is known before its first reading. Session stores it.
#pragma once

#include "base/time.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/run_request.hpp"
#include "protocols/plan/limits.hpp"
#include "protocols/protocol.hpp"
#include "storage/runs.hpp"

namespace lcrig {

struct RowFacts {
  const RunRequest& request;
  const Protocol& protocol;
  const Environment& environment;
  const InstrumentsInfo& info;
  const Identity& meter;
  const Identity& frame;
  bool simulated;
  const FrameCapabilities& abilities;
  const BoundLimits& limits;
  SettingsEvent settings;  // as read back
};
// It begins now.
RunRow make_run_row(const RowFacts& facts, const Clock& clock);

}  // namespace lcrig
