// SPDX-License-Identifier: Apache-2.0
// What a fault script acts on: the simulated instruments with their cables, and what surrounds a
// run. The simulated bench of a rehearsal and lcrig-sim implement the first in their own ways.
#pragma once

#include <functional>
#include <string>

#include "base/clock.hpp"

namespace lcrig {

namespace lcr6100 {
struct SimFaults;
struct SimHooks;
}  // namespace lcr6100
struct ZwickSimFaults;
struct ZwickSimHooks;

class FaultBench {
 public:
  virtual ~FaultBench() = default;
  virtual bool has_frame() const = 0;

  // The cables. The instruments keep their state; with the frame's cable the gateway stops.
  // `other_port`: it comes back as another device.
  virtual void unplug_meter() = 0;
  virtual void plug_meter(bool other_port = false) = 0;
  virtual void unplug_frame() = 0;
  virtual void plug_frame(bool other_port = false) = 0;

  // They outlive a connection.
  virtual void hook_meter(lcr6100::SimHooks hooks) = 0;
  virtual void break_meter(const std::function<void(lcr6100::SimFaults&)>& change) = 0;
  virtual std::string meter_identity() const = 0;
  // While unplugged: settings are lost; another identity is another meter.
  virtual void power_meter(const std::string& identity) = 0;
  virtual void say_unasked(std::string text) = 0;  // empty: its latest reading

  virtual void hook_frame(ZwickSimHooks hooks) = 0;
  virtual void break_frame(const std::function<void(ZwickSimFaults&)>& change) = 0;
  virtual void power_frame() = 0;  // while unplugged: zero, tare and clock are forgotten
  virtual void stall_frame() = 0;
  virtual void restart_gateway(bool forgets_zero) = 0;

  virtual void set_operator_absent(bool absent) = 0;
};

// Disk, clock and memory of the computer that records.
class FaultSurroundings {
 public:
  virtual ~FaultSurroundings() = default;
  virtual void set_disk_full(bool on) = 0;
  virtual void set_disk_read_only(bool on) = 0;
  virtual void set_disk_delay(Duration per_sync) = 0;  // of real time; 0: none
  virtual void set_memory_short(bool on) = 0;
  virtual void step_wall_clock(Duration by) = 0;
};

}  // namespace lcrig
