// SPDX-License-Identifier: Apache-2.0
// Two loops that look after real instruments while no run uses them. One makes the frame safe after
// a crash, and asks the meter again and again who it is. The other watches the nodes of the ports.
// App owns it.
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

  // Asks the meter. The frame is not asked, because other people may be working with it. Returns
  // when the daemon ends.
  Task<> ask();
  // Looks at the ports once a second until the daemon ends; not in a run, which notices by itself
  // that an instrument is gone. A look that never ends keeps neither the watchdog from
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
