// SPDX-License-Identifier: Apache-2.0
// Requests of people to stop or pause the run that goes on, at once or at the end of what is under
// way. App owns it; the control socket calls it.
#pragma once

#include <string>

#include "daemon/app/callers.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/control/handler.hpp"

namespace lcrig {

class Stops final : public StopHandler {
 public:
  Stops(Clock& clock, RigUse& use, Callers& callers)
      : clock_(clock), use_(use), callers_(callers) {}

  Task<Result<>> pause(PeerCredentials peer) override;
  Task<Result<StopAnswer>> pause_at(StopPlace place, PeerCredentials peer) override;
  Task<Result<StopAnswer>> stop_after(StopPlace place, std::string why,
                                      PeerCredentials peer) override;
  Task<Result<StopAnswer>> abort(std::string why, PeerCredentials peer) override;
  Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials peer) override;

 private:
  Task<Result<StopAnswer>> stop_run(Interrupt kind, std::string why, PeerCredentials peer);
  Task<Result<StopAnswer>> ask_at(PlannedStops::Kind kind, StopPlace place, std::string why,
                                  PeerCredentials peer);
  Task<Result<StopAnswer>> confirm_stop(Run& run, std::uint64_t stands, std::uint64_t failures);

  Clock& clock_;
  RigUse& use_;
  Callers& callers_;
};

}  // namespace lcrig
