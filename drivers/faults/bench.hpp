// SPDX-License-Identifier: Apache-2.0
// The interfaces that the FaultPlayer acts on: the simulated instruments with their cables
// (FaultBench), and the recording computer (FaultSurroundings). Simulated runs implement both;
// lcrig-sim implements FaultBench only.
#pragma once

#include <functional>
#include <string>

#include "base/time.hpp"
#include "drivers/panel_key.hpp"

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

  // The cables. The instruments keep their state, but unplugging the frame stops the gateway. With
  // `other_port` the instrument comes back under another device name.
  virtual void unplug_meter() = 0;
  virtual void plug_meter(bool other_port = false) = 0;
  virtual void unplug_frame() = 0;
  virtual void plug_frame(bool other_port = false) = 0;

  // Hooks and faults stay in force when the connection changes.
  virtual void hook_meter(lcr6100::SimHooks hooks) = 0;
  virtual void break_meter(const std::function<void(lcr6100::SimFaults&)>& change) = 0;
  virtual std::string meter_identity() const = 0;
  // Power-cycles the meter, which loses its settings. With another identity it is another meter.
  virtual void power_meter(const std::string& identity) = 0;
  // A hand at its panel; an empty text: back to what it was.
  virtual void turn_meter(PanelKey key, const std::string& to) = 0;
  virtual void say_unasked(std::string text) = 0;  // empty: the latest reading again

  virtual void hook_frame(ZwickSimHooks hooks) = 0;
  virtual void break_frame(const std::function<void(ZwickSimFaults&)>& change) = 0;
  virtual void power_frame() = 0;  // while unplugged: loses zero, tare and clock
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
  virtual void set_disk_delay(Duration per_sync) = 0;  // in real time; 0: none
  virtual void set_memory_short(bool on) = 0;
  virtual void step_wall_clock(Duration by) = 0;
};

}  // namespace lcrig
