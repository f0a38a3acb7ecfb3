// SPDX-License-Identifier: Apache-2.0
// The back door of a simulated bench: cables and plugs, and the simulators' own faults.
#pragma once

#include <string>

namespace lcrig {

namespace lcr6100 {
class Lcr6100Sim;
}
class ZwickSim;

class BenchDoor {
 public:
  virtual ~BenchDoor() = default;
  virtual lcr6100::Lcr6100Sim& meter_sim() = 0;
  virtual ZwickSim* frame_sim() = 0;  // nullptr: a rod with weights
  // The cable. The instruments keep their state; with the frame's cable the gateway stops.
  virtual void unplug_meter() = 0;
  virtual void plug_meter() = 0;
  virtual void unplug_frame() = 0;
  virtual void plug_frame() = 0;
};

}  // namespace lcrig
