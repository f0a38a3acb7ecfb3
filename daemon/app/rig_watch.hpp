// SPDX-License-Identifier: Apache-2.0
// Looks after real instruments while no run uses them. It stops a frame that a daemon which died
// may have left moving: before the database is opened, and again until the frame confirms that it
// stands. It asks the meter again and again who it is, and watches the nodes of the ports. App owns
// it.
#pragma once

#include <memory>
#include <string>

#include "daemon/app/database_writes.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/known.hpp"

namespace lcrig {

// False when the protocol of the run commands no frame. What cannot be read counts as one that
// does.
bool commanded_frame(const Database& db, std::int64_t run);

// False when it is known that nothing was left: there was no database, or every run without an end
// commanded no frame or is being recorded by another process. True also when nobody can tell within
// `patience`.
bool may_have_left_motion(const std::string& database, Duration patience);

class RigWatch {
 public:
  // What App shares with it; all outlive it.
  struct Parts {
    const std::string& database;
    InstrumentFactory& rig;
    const KnownRig& known;
    RigUse& use;
    const std::unique_ptr<Recorder>& recorder;
    DatabaseWrites& writes;
  };
  RigWatch(Clock& clock, const Parts& parts) : clock_(clock), parts_(parts) {}

  // Both are for the time before the database is open: to open it may mean to wait for a disk or
  // for another program. True: the frame is real, and a run without an end may have left it moving,
  // or the database did not tell within a second.
  bool may_be_left() const;
  Task<> stop_first();

  // The database is open: logs the runs that were found without an end. After one that commanded
  // the frame, the frame is due.
  void look_at_orphans();
  // Stops the frame if it is due, unless that was done first, and notes it in those runs. False: it
  // did not confirm that it stands.
  Task<bool> make_safe();

  // Makes the frame safe and asks the meter. The frame is not asked, because other people may be
  // working with it. Returns when the daemon ends.
  Task<> ask();
  // Looks at the ports once a second until the daemon ends; not in a run, which notices by itself
  // that an instrument is gone. A look that never ends keeps neither the watchdog from
  // being fed nor the daemon from ending.
  Task<> watch_ports();

 private:
  Clock& clock_;
  Parts parts_;
  bool is_due_ = false;
  bool stood_first_ = false;  // confirmed before the database was open
};

}  // namespace lcrig
