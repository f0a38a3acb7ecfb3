// SPDX-License-Identifier: Apache-2.0
// Disk, memory and wall clock of a run in virtual time. A drill changes them as its fault script
// says.
#pragma once

#include "base/clock.hpp"
#include "drivers/faults/bench.hpp"
#include "storage/faulty_disk.hpp"

namespace lcrig {

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

}  // namespace lcrig
