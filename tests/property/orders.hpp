// SPDX-License-Identifier: Apache-2.0
// The orders of a run over the wire, as RigWitness recorded them: motions and STOPs. Used to find
// contradictions and to judge lies.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/rig_witness.hpp"
#include "tests/support/rig_world.hpp"

namespace lcrig::property {

// A motion as it was ordered over the wire.
struct Ordered {
  Ordered() = default;
  std::int64_t number = 0;
  std::string word;  // MOVE, MOVEF, RAMPF
  MonoTime sent, over;  // over: at DONE, ERR, our STOP, a new session or the end
  bool is_done = false;  // DONE said that it reached its target
  bool is_stopped = false;  // by our STOP
  bool is_limited = false;  // by the device at a force limit
  std::optional<double> travel_m, force_N;
  double speed_m_s = 0, rate_N_s = 0;
  double from_m = 0;  // travel shown when it was sent
  int direction = 0;  // +1 towards the specimen; 0: not known
};
std::vector<Ordered> ordered_motions(const RigWitness& witness);
std::vector<MonoTime> stops_sent(const RigWitness& witness);

// The contact as the run printed it, as long as it refers to the same zero.
struct PrintedContact {
  PrintedContact() = default;
  double travel_m = 0, stiffness_N_m = 0;  // stiffness: a lower bound
};
std::optional<PrintedContact> printed_contact(const RigWorld& world, MonoTime before);

// From the samples up to an instant: the deepest travel, and the last force.
double deepest_m(const std::vector<RigWitness::Seen>& seen, MonoTime until);
double shown_N(const std::vector<RigWitness::Seen>& seen, MonoTime until);

}  // namespace lcrig::property
