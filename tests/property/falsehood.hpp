// SPDX-License-Identifier: Apache-2.0
// A lie of the simulated frame, as docs/faults.md names it: when it begins, and how big it is.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tests/property/dice.hpp"
#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::property {

enum class FrameLie {
  force_frozen,
  force_held,
  force_gain,  // times
  force_reversed,
  force_drift,  // N/s
  force_scatter,  // times
  tare_lost,  // 1: and told
  stall,
  drive_reversed,
  creep,  // m/s
  estop,
  done_early,
  done_unmoved,
  done_late,  // s
  order_late,  // s
  stop_late,  // s
  stop_unconfirmed,
  stop_ignored,
  clock_rate,  // 0: frozen
  clock_jump,  // s
  samples_late,  // s
  restart_untared,
  caps_changed,
};
constexpr int kFrameLies = 23;
std::string_view to_string(FrameLie lie);
FrameLie lie_of(std::string_view name);  // throws

// Who is not believed any more when it came out (docs/testing.md).
enum class Distrust { force, drive, gateway, nobody };
Distrust distrust_of(FrameLie lie);
// What the reason of the run then says, one of these.
const std::vector<std::string_view>& words_of(FrameLie lie);

struct Falsehood : Instant {
  Falsehood() = default;
  FrameLie what = FrameLie::force_frozen;
  double value = 1;  // in the unit above
};

Falsehood draw_falsehood(Dice& dice, FrameLie what, const sim::RandomRig& rig);
void begin_lie(RigWorld& world, const Falsehood& lie);
void end_lie(RigWorld& world, const Falsehood& lie);

}  // namespace lcrig::property
