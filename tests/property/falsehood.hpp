// SPDX-License-Identifier: Apache-2.0
// A lie of the simulated frame, named as in docs/faults.md: when it begins and how large it is.
// Used by the cases of the property tests.
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
  force_gain,  // factor
  force_reversed,
  force_drift,  // N/s
  force_scatter,  // factor
  tare_lost,  // 1: the frame reports it
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
  clock_rate,  // factor; 0: frozen
  clock_jump,  // s
  samples_late,  // s
  restart_untared,
  caps_changed,
};
constexpr int kFrameLies = 23;
std::string_view to_string(FrameLie lie);
FrameLie lie_of(std::string_view name);  // throws

// The part of the rig that is no longer believed once the lie is noticed (docs/testing.md).
enum class Distrust { force, drive, gateway, nobody };
Distrust distrust_of(FrameLie lie);
// The reason of the run must contain one of these.
const std::vector<std::string_view>& words_of(FrameLie lie);

struct Falsehood : Instant {
  Falsehood() = default;
  FrameLie what = FrameLie::force_frozen;
  double value = 1;  // in the unit given at FrameLie
};

Falsehood draw_falsehood(Dice& dice, FrameLie what, const sim::RandomRig& rig);
void begin_lie(RigWorld& world, const Falsehood& lie);
void end_lie(RigWorld& world, const Falsehood& lie);

}  // namespace lcrig::property
