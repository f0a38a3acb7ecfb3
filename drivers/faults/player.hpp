// SPDX-License-Identifier: Apache-2.0
// Plays a fault script on a simulated bench. Its random numbers are seeded: in virtual time the
// same script does the same to the same run. Used by rehearsals and lcrig-sim.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "base/condition.hpp"
#include "drivers/faults/bench.hpp"
#include "drivers/faults/script.hpp"
#include "drivers/line_fault.hpp"

namespace lcrig {

class FaultPlayer {
 public:
  // Called when a fault happens and when it ends; the text is one line.
  using Told = std::function<void(MonoTime at, const std::string& text)>;
  // All references must outlive the player. `surroundings` may be nullptr; check_stage must then
  // have refused the faults that need them.
  FaultPlayer(asio::any_io_executor executor, Clock& clock, FaultBench& bench,
              FaultSurroundings* surroundings, FaultScript script, Told told);
  ~FaultPlayer();
  FaultPlayer(const FaultPlayer&) = delete;
  FaultPlayer& operator=(const FaultPlayer&) = delete;

  // Sets the zero of `at_s`. Counted faults without at_s and in_step can happen from construction
  // on.
  void begin();
  void enter_step(std::string_view id, std::string_view kind, bool finishing);
  // Ends the faults that can be ended (plugs, disk, memory) and the player's task. Idempotent.
  void stop();
  bool is_idle() const { return !running_; }
  // After `stop`, waits until the task has ended. False: it had not ended at `limit`.
  Task<bool> ended(MonoTime limit = MonoTime::max());
  // How often each fault of the script has happened.
  std::vector<std::int64_t> happened() const;
  const FaultScript& script() const { return script_; }

 private:
  struct State {
    explicit State(const Fault& f) : fault(&f) {}
    const Fault* fault;
    bool open = false;  // its time or its step has come
    std::int64_t opened = 0;  // how often; an end that was scheduled for an earlier opening is
                              // ignored
    std::int64_t seen = 0;  // events of a counted fault
    std::int64_t fired = 0;
  };
  using Act = std::function<void()>;

  void attach();
  void schedule(MonoTime at, Act act);
  Task<> run();
  void open(State& s);
  void close(State& s);
  bool is_due(State& s);
  const Fault* counted_event(FaultOccasion occasion);
  void happen(State& s);
  LineFault next_line(FaultOccasion occasion);
  void act(const Fault& fault, bool on);

  asio::any_io_executor executor_;
  Clock& clock_;
  FaultBench& bench_;
  FaultSurroundings* surroundings_;
  FaultScript script_;
  Told told_;
  std::vector<State> states_;
  std::mt19937_64 random_;
  std::string first_identity_;  // identity of the bench's first meter
  std::multimap<MonoTime, Act> agenda_;
  Wakeup wakeup_;
  Condition changed_;
  std::uint64_t step_ = 0;  // number of steps entered
  bool running_ = false, stopped_ = false;
};

}  // namespace lcrig
