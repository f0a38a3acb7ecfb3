// SPDX-License-Identifier: Apache-2.0
// Passes orders from ZwickSim to its SimMachine, and reports the ends of motions back. Normally at
// once and truthfully; as a fault late, early, or without any motion. Used by ZwickSim.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "drivers/zwick/sim.hpp"
#include "drivers/zwick/sim_machine.hpp"

namespace lcrig::frame_link {

// A command that ends with DONE.
struct Order {
  std::int64_t number = 0;
  std::optional<double> travel_m, force_N;  // target, as the samples show it
  std::function<Verdict(MonoTime t)> carry_out;
};

// Delays or falsifies orders and reports. The machine must outlive it. next_event() and advance()
// include the machine's events.
class SimClerk {
 public:
  explicit SimClerk(SimMachine& machine) : machine_(machine) {}

  void set_lies(MonoTime t, const ZwickSimLies& lies);
  Verdict take(MonoTime t, Order order);
  void stop(MonoTime t);  // call before the machine is halted
  void end_session();  // drops all reports that are still due

  std::optional<MonoTime> next_event() const;
  void advance();
  std::optional<FinishedMotion> take_finished();

 private:
  struct Waiting {
    MonoTime due;
    Order order;
    bool is_wanted = true;  // false once a STOP has cancelled it
  };
  struct Claim {
    MonoTime due;
    Order order;
    bool moves = true;
  };
  struct Told {
    MonoTime due;
    FinishedMotion motion;
  };
  void claim(MonoTime t);
  void obey_late(MonoTime t);
  void hear_machine(MonoTime t);
  void tell(std::int64_t number, MonoTime t, MotionEnd reason);

  SimMachine& machine_;
  ZwickSimLies lies_;
  std::optional<Order> latest_;
  std::optional<Claim> claim_;
  std::deque<Waiting> waiting_;
  std::deque<Told> late_;
  std::deque<FinishedMotion> finished_;
};

}  // namespace lcrig::frame_link
