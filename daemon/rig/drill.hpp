// SPDX-License-Identifier: Apache-2.0
// Plays a fault script on the simulated bench of a rehearsal, and on the computer around it. Each
// fault becomes an event of the run.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "drivers/faults/bench.hpp"
#include "drivers/faults/player.hpp"
#include "protocols/run/sink.hpp"
#include "storage/faulty_disk.hpp"

namespace lcrig {

// Disk, memory and wall clock of a run in virtual time. A drill changes them as its fault script
// says.
class VirtualSurroundings final : public FaultSurroundings {
 public:
  explicit VirtualSurroundings(VirtualClock& clock) : clock_(clock) {}
  ~VirtualSurroundings() override { set_memory_short(false); }
  // The disk that the recorder writes to. The recorder must be closed before this object is
  // destroyed.
  FaultyDisk& disk() { return disk_; }

  void set_disk_full(bool on) override { disk_.set_full(on); }
  void set_disk_read_only(bool on) override { disk_.set_read_only(on); }
  void set_disk_delay(Duration per_sync) override { disk_.set_sync_delay(per_sync); }
  void set_memory_short(bool on) override {
    if (on != memory_short_) set_sqlite_memory_short(on);
    memory_short_ = on;
  }
  void step_wall_clock(Duration by) override { clock_.step_wall_clock(by); }

 private:
  VirtualClock& clock_;
  FaultyDisk disk_;
  bool memory_short_ = false;
};

class FaultDrill {
 public:
  // Errors: invalid_request, with the position in the script.
  static Result<std::unique_ptr<FaultDrill>> make(VirtualClock& clock, const std::string& text,
                                                  const std::string& name);

  // The name of the disk that the recorder has to use.
  const std::string& disk() { return surroundings_.disk().name(); }
  // Sets the bench to play on; from now on counted faults happen. Errors: the script needs
  // something that the bench does not have.
  Result<> attach(asio::any_io_executor executor, FaultBench& bench);
  void begin(RunSink& sink);
  void enter_step(const RunProgress& progress);
  // Ends the faults that can be ended; returns when none is in progress.
  Task<> end();
  void detach();  // call it before the bench is destroyed
  std::int64_t happened() const;  // number of faults so far

 private:
  FaultDrill(VirtualClock& clock, FaultScript script)
      : clock_(clock), script_(std::move(script)), surroundings_(clock) {}
  void note(MonoTime at, const std::string& text);

  VirtualClock& clock_;
  FaultScript script_;
  VirtualSurroundings surroundings_;
  std::vector<RunEvent> early_;  // from before the run row existed
  RunSink* sink_ = nullptr;
  std::string step_;
  std::int64_t happened_ = 0;  // number of faults when the bench was destroyed
  std::unique_ptr<FaultPlayer> player_;
};

}  // namespace lcrig
