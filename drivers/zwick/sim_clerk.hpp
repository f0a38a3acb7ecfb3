// SPDX-License-Identifier: Apache-2.0
// Between the words of the simulated gateway and its machine: passes orders on and tells of their
// ends, at once and truly, or late, early, or without having done anything.
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
  Order() = default;
  std::int64_t number = 0;
  std::optional<double> travel_m, force_N;  // where it leads, as the samples show it
  std::function<Verdict(MonoTime t)> carry_out;
};

// The machine must outlive it. Events as those of the machine, which it includes.
class SimClerk {
 public:
  explicit SimClerk(SimMachine& machine) : machine_(machine) {}

  void set_lies(MonoTime t, const ZwickSimLies& lies);
  Verdict take(MonoTime t, Order order);
  void stop(MonoTime t);  // before the machine is halted
  void end_session();  // nobody is told of anything any more

  std::optional<MonoTime> next_event() const;
  void advance();
  std::optional<FinishedMotion> take_finished();

 private:
  struct Waiting {
    MonoTime due;
    Order order;
    bool is_wanted = true;  // no STOP came since
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
