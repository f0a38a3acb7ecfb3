// SPDX-License-Identifier: Apache-2.0
// What a run ordered over the wire: its motions and its STOPs, read from what was witnessed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/rig_witness.hpp"
#include "tests/support/rig_world.hpp"

namespace lcrig::property {

// A motion that was ordered, as it went over the wire.
struct Ordered {
  Ordered() = default;
  std::int64_t number = 0;
  std::string word;  // MOVE, MOVEF, RAMPF
  MonoTime sent, over;  // by DONE, ERR, a STOP of ours, a new session, or the end
  bool is_done = false;  // DONE said that it reached its target
  bool is_stopped = false;  // by a STOP of ours
  bool is_limited = false;  // by the device, at a limit of force
  std::optional<double> travel_m, force_N;
  double speed_m_s = 0, rate_N_s = 0;
  double from_m = 0;  // shown when it was sent
  int direction = 0;  // +1 towards the specimen; 0: nobody knows
};
std::vector<Ordered> ordered_motions(const RigWitness& witness);
std::vector<MonoTime> stops_sent(const RigWitness& witness);

// As the run printed it, of a contact whose place is still told from the same zero.
struct PrintedContact {
  PrintedContact() = default;
  double travel_m = 0, stiffness_N_m = 0;  // the latter at least
};
std::optional<PrintedContact> printed_contact(const RigWorld& world, MonoTime before);

// Of what was shown until then: the furthest travel, the last force.
double deepest_m(const std::vector<RigWitness::Seen>& seen, MonoTime until);
double shown_N(const std::vector<RigWitness::Seen>& seen, MonoTime until);

}  // namespace lcrig::property
