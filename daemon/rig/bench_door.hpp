// SPDX-License-Identifier: Apache-2.0
// Access to the inside of a simulated bench: for fault scripts to the instruments and cables, and
// for tests to the simulators and the simulated world.
#pragma once

#include "drivers/faults/bench.hpp"

namespace lcrig {

namespace lcr6100 {
class Lcr6100Sim;
}
class Plant;
class ZwickSim;

class BenchDoor : public FaultBench {
 public:
  virtual lcr6100::Lcr6100Sim& meter_sim() = 0;
  virtual ZwickSim* frame_sim() = 0;  // nullptr: a rod with weights
  virtual const Plant* plant() = 0;  // nullptr: a recording is played
};

}  // namespace lcrig
