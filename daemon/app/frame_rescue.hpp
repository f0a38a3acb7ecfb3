// SPDX-License-Identifier: Apache-2.0
// Stops a frame that a daemon which died may have left moving: before the database is opened, and
// again until the frame confirms that it stands. App owns it; RigWatch tries again.
#pragma once

#include <memory>
#include <string>

#include "daemon/app/database_writes.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/instruments.hpp"

namespace lcrig {

class FrameRescue {
 public:
  FrameRescue(const std::string& database, InstrumentFactory& rig,
              const std::unique_ptr<Recorder>& recorder, DatabaseWrites& writes)
      : database_(database), rig_(rig), recorder_(recorder), writes_(writes) {}

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

 private:
  const std::string& database_;
  InstrumentFactory& rig_;
  const std::unique_ptr<Recorder>& recorder_;
  DatabaseWrites& writes_;
  bool is_due_ = false;
  bool stood_first_ = false;  // confirmed before the database was open
};

}  // namespace lcrig
