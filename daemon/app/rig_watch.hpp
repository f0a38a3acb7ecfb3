// SPDX-License-Identifier: Apache-2.0
// Looks after real instruments while no run uses them. It stops a frame that a crashed daemon may
// have left moving: before the database is opened, and again until the frame confirms standstill.
// It also asks the meter's identity again and again, and watches the device nodes of the ports.
// Owned by App.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/task.hpp"
#include "base/time.hpp"

namespace lcrig {

class Database;
class DatabaseWrites;
class InstrumentFactory;
class KnownRig;
class Recorder;
class RigUse;

// False when the protocol of the run does not command the frame. A protocol that cannot be read
// counts as commanding it.
bool commanded_frame(const Database& db, std::int64_t run);

// False when certainly nothing was left moving: there is no database, or every run without an end
// commanded no frame or is being recorded by another process. True also when this cannot be found
// out within `patience`.
bool may_have_left_motion(const std::string& database, Duration patience);

class RigWatch {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    const std::string& database;
    InstrumentFactory& rig;
    const KnownRig& known;
    RigUse& use;
    const std::unique_ptr<Recorder>& recorder;
    DatabaseWrites& writes;
  };
  RigWatch(Clock& clock, const Parts& parts) : clock_(clock), parts_(parts) {}

  // Both are for the time before the database is open, because opening it may have to wait for a
  // disk or another program. True: the frame is real, and a run without an end may have left it
  // moving, or the database did not answer within a second.
  bool may_be_left() const;
  Task<> stop_first();

  // Call when the database is open. Logs the runs that were found without an end. If one of them
  // commanded the frame, the frame has to be made safe.
  void look_at_orphans();
  // Stops the frame if it has to be made safe and stop_first has not done so, and notes it in those
  // runs. False: it did not confirm standstill.
  Task<bool> make_safe();

  // Makes the frame safe and asks the meter. Does not ask the frame, because other people may be
  // working with it. Returns when the daemon ends.
  Task<> ask();
  // Looks at the ports once a second until the daemon ends, except during a run, which notices the
  // loss of an instrument by itself. A look that hangs prevents neither feeding the watchdog nor
  // the end of the daemon.
  Task<> watch_ports();

 private:
  Clock& clock_;
  Parts parts_;
  bool is_due_ = false;
  bool stood_first_ = false;  // standstill was confirmed before the database was open
};

}  // namespace lcrig
