// SPDX-License-Identifier: Apache-2.0
// Plays a fault script on the simulated bench of a rehearsal, and on the computer around it. What
// happens becomes an event of the run.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/rig/surroundings.hpp"
#include "drivers/faults/player.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

class FaultDrill {
 public:
  // Errors: invalid_request, with the place in the script.
  static Result<std::unique_ptr<FaultDrill>> make(VirtualClock& clock, const std::string& text,
                                                  const std::string& name);

  // The recorder writes to this disk.
  const std::string& disk() { return surroundings_.disk().name(); }
  // The bench on which it is played; counted faults happen from here on. Errors: the script asks
  // for what the bench does not have.
  Result<> attach(asio::any_io_executor executor, FaultBench& bench);
  void begin(RunSink& sink);
  void enter_step(const RunProgress& progress);
  // Mends what can be mended; returns when nothing of it is under way.
  Task<> end();
  void detach();  // before the bench goes
  std::int64_t happened() const;  // faults so far

 private:
  FaultDrill(VirtualClock& clock, FaultScript script)
      : clock_(clock), script_(std::move(script)), surroundings_(clock) {}
  void note(MonoTime at, const std::string& text);

  VirtualClock& clock_;
  FaultScript script_;
  VirtualSurroundings surroundings_;
  std::vector<RunEvent> early_;  // of before the run row
  RunSink* sink_ = nullptr;
  std::string step_;
  std::int64_t happened_ = 0;  // when the bench went
  std::unique_ptr<FaultPlayer> player_;
};

}  // namespace lcrig
