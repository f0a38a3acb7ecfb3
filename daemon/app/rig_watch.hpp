// SPDX-License-Identifier: Apache-2.0
// Looks after real instruments while no run uses them: makes the frame safe after a crash, asks the
// meter now and then who it is, watches the nodes of the ports. App owns it.
#pragma once

#include "daemon/app/frame_rescue.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/rig/known.hpp"

namespace lcrig {

class RigWatch {
 public:
  RigWatch(Clock& clock, InstrumentFactory& rig, const KnownRig& known, RigUse& use,
           FrameRescue& rescue)
      : clock_(clock), rig_(rig), known_(known), use_(use), rescue_(rescue) {}

  // Both return when the daemon ends. The frame is not asked, because other people may be working
  // with it.
  Task<> ask();
  // Not in a run, which notices by itself. A look that never ends keeps neither the watchdog from
  // being fed nor the daemon from ending.
  Task<> watch_ports();

 private:
  Clock& clock_;
  InstrumentFactory& rig_;
  const KnownRig& known_;
  RigUse& use_;
  FrameRescue& rescue_;
};

}  // namespace lcrig
