// SPDX-License-Identifier: Apache-2.0
// Plays a fault script on the simulated bench of a rehearsal, and on the computer around it. Each
// fault becomes an event of the run.
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
  // Errors: invalid_request, with the position in the script.
  static Result<std::unique_ptr<FaultDrill>> make(VirtualClock& clock, const std::string& text,
                                                  const std::string& name);

  // The name of the disk that the recorder has to use.
  const std::string& disk() { return surroundings_.disk().name(); }
  // Sets the bench to play on; from now on counted faults happen. Errors: the script needs
  // something that the bench does not have.
  Result<> attach(asio::any_io_executor executor, FaultBench& bench);
  void begin(RunSink& sink);
  void enter_step(const RunProgress& progress);
  // Ends the faults that can be ended; returns when none is in progress.
  Task<> end();
  void detach();  // call it before the bench is destroyed
  std::int64_t happened() const;  // number of faults so far

 private:
  FaultDrill(VirtualClock& clock, FaultScript script)
      : clock_(clock), script_(std::move(script)), surroundings_(clock) {}
  void note(MonoTime at, const std::string& text);

  VirtualClock& clock_;
  FaultScript script_;
  VirtualSurroundings surroundings_;
  std::vector<RunEvent> early_;  // from before the run row existed
  RunSink* sink_ = nullptr;
  std::string step_;
  std::int64_t happened_ = 0;  // number of faults when the bench was destroyed
  std::unique_ptr<FaultPlayer> player_;
};

}  // namespace lcrig
