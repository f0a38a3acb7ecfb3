// SPDX-License-Identifier: Apache-2.0
// Requests of people to the current run: stop or pause it, at once or at the end of a part, and
// confirm or answer what it waits for. A confirmation also opens a gate of the queue. Owned by App;
// called by the control socket.
#pragma once

#include <memory>
#include <string>

#include "daemon/control/handler.hpp"
#include "protocols/run/planned_stops.hpp"

namespace lcrig {

class Callers;
class QueueTurns;
class Recorder;
class RemoteOperator;
class RigUse;
class Run;
enum class Interrupt;

class RunSteering final : public SteeringHandler {
 public:
  // References to App's members; all must outlive it.
  struct Parts {
    RigUse& use;
    Callers& callers;
    RemoteOperator& person;
    const QueueTurns& queue;
    const std::unique_ptr<Recorder>& recorder;
  };
  RunSteering(Clock& clock, const Parts& parts) : clock_(clock), parts_(parts) {}

  Task<Result<StopAnswer>> pause(PeerCredentials peer) override;
  Task<Result<StopAnswer>> pause_at(StopPlace place, PeerCredentials peer) override;
  Task<Result<StopAnswer>> stop_after(StopPlace place, std::string why,
                                      PeerCredentials peer) override;
  Task<Result<StopAnswer>> abort(std::string why, PeerCredentials peer) override;
  Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials peer) override;

  Task<Result<>> confirm(PeerCredentials peer) override;
  Task<Result<Answered>> answer(AnswerRequest request, PeerCredentials peer) override;

 private:
  Task<Result<StopAnswer>> stop_run(Interrupt kind, std::string why, PeerCredentials peer);
  Task<Result<StopAnswer>> ask_at(PlannedStops::Kind kind, StopPlace place, std::string why,
                                  PeerCredentials peer);
  Task<Result<StopAnswer>> confirm_stop(Run& run, std::uint64_t stands, std::uint64_t failures);
  Task<Result<StopAnswer>> confirm_pause(Run& run);
  template <class Known>
  Task<> await_stop(const Run& run, Known is_known);
  std::optional<Error> alarm_of(const Run& run) const;
  Error end_of(const Run& run) const;

  Clock& clock_;
  Parts parts_;
};

}  // namespace lcrig
