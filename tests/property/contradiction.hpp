// SPDX-License-Identifier: Apache-2.0
// When what a simulated frame showed first contradicted the truth, what was ordered, or itself: by
// our own eyes, from what was witnessed. The only numbers of the product in it are those that its
// plan prints (`watch`), and they are what is judged.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/property/trial.hpp"

namespace lcrig::property {

// As the plan prints it, and the run again whenever it knows the cell better (event `watch`).
struct PrintedWatch {
  PrintedWatch() = default;
  std::optional<double> frozen_force_s;
  double stall_s = 0, against_m = 0, standing_m = 0, order_travel_m = 0, order_force_N = 0;
  double reply_s = 0;
};
std::optional<PrintedWatch> printed_watch(const RigWorld& world, MonoTime at);

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

struct Contradiction {
  Contradiction() = default;
  MonoTime taken, first;  // the first sample that is not true: when it was taken, when it arrived
  MonoTime due;  // by then STOP must be on its way
  double true_N = 0;  // when it was taken
  double speed_m_s = 0, rate_N_s = 0;  // in force
};
// nullopt: it showed nowhere, or not for long enough; docs/testing.md
std::optional<Contradiction> contradiction_of(const Trial& t, const PrintedWatch& w,
                                              std::size_t lie);

}  // namespace lcrig::property
