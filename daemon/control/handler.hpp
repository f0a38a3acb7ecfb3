// SPDX-License-Identifier: Apache-2.0
// The interfaces between the control socket and the daemon. App and its parts implement them. They
// are called on the io_context thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/config_view.hpp"
#include "daemon/control/messages.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

class QueueHandler;
struct Plan;

// Calls of one or several clients may overlap: a stop never waits for a start that is still
// preparing. A task is not cancelled when its client disconnects.

// Starts and continues runs, and asks the instruments before them.
class RunHandler {
 public:
  virtual ~RunHandler() = default;
  // Returns when the run row exists and the run goes on by itself. If the request names no
  // operator, the peer is the operator. Errors: busy, invalid_request (protocol, parameters,
  // specimen), any error of the instruments.
  virtual Task<Result<RunStarted>> start_run(RunRequest request, PeerCredentials peer) = 0;
  // Ends a pause, or (with `run`) continues an interrupted run at its step, in a new run.
  // `confirmed` says that a person found the specimen untouched; without it the run asks first.
  // Returns the run that goes on.
  virtual Task<Result<RunStarted>> resume(std::optional<std::int64_t> run, bool confirmed,
                                          PeerCredentials peer) = 0;
  // The plan that a start with the same request would make on this rig. It looks at the rig, but
  // commands nothing.
  virtual Task<Result<Plan>> plan_run(RunRequest request, PeerCredentials peer) = 0;
  // Asks both instruments for their identity; nothing at the frame changes. Errors: busy.
  virtual Task<Result<>> ask_instruments(PeerCredentials peer) = 0;
};

// Stops the current run, and answers what it waits for.
class SteeringHandler {
 public:
  virtual ~SteeringHandler() = default;
  // Returns when the frame stands and the run is paused, or will be once an instrument is back.
  // Errors: not_standing; invalid_request (no run, or `finally` runs).
  virtual Task<Result<StopAnswer>> pause(PeerCredentials peer) = 0;
  // A pause or a stop at the end of a part. Return at once, with the time until then. Errors:
  // invalid_request.
  virtual Task<Result<StopAnswer>> pause_at(StopPlace place, PeerCredentials peer) = 0;
  virtual Task<Result<StopAnswer>> stop_after(StopPlace place, std::string why,
                                              PeerCredentials peer) = 0;
  // Return when the frame has confirmed standstill after this request, or when it is clear what
  // happens instead: `finally` goes on, or a run that was being prepared does not begin. Errors:
  // not_standing, a second after the request at the latest, plus the time of braking.
  virtual Task<Result<StopAnswer>> abort(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> confirm(PeerCredentials peer) = 0;
  // Answers the open question; returns when the answer is stored. Errors: invalid_request (the
  // answer does not fit, no question or another one is open), io.
  virtual Task<Result<Answered>> answer(AnswerRequest request, PeerCredentials peer) = 0;
};

// Stores what people add to the database.
class StoreHandler {
 public:
  virtual ~StoreHandler() = default;
  // Adds a note to a run that has ended, in the peer's name. Errors: invalid_request, busy.
  virtual Task<Result<>> note_run(std::int64_t run, std::string text, PeerCredentials peer) = 0;
  // Adds or removes tags of a run; returns its tags afterwards. Errors: invalid_request, busy.
  virtual Task<Result<std::vector<std::string>>> tag_run(TagRequest request,
                                                         PeerCredentials peer) = 0;
  // Stores a specimen; returns its name. Errors: invalid_request with the JSON pointer.
  virtual Task<Result<std::string>> add_specimen(SpecimenToAdd specimen, PeerCredentials peer) = 0;
};

// Uses the meter without a run.
class MeterHandler {
 public:
  virtual ~MeterHandler() = default;
  // Makes the open or the short correction of the meter after a person has prepared its probes.
  // Takes minutes. Errors: busy (a run, or a queue that goes), refused (the meter's verdict), any
  // error of the meter.
  virtual Task<Result<MeterCorrections>> correct(CorrectionKind kind, PeerCredentials peer) = 0;
  // Asks the meter which corrections it applies. Errors: busy, any error of the meter.
  virtual Task<Result<MeterCorrections>> look() = 0;
};

class ControlHandler {
 public:
  virtual ~ControlHandler() = default;
  virtual RunHandler& runs() = 0;
  virtual SteeringHandler& steering() = 0;
  virtual StoreHandler& store() = 0;
  virtual MeterHandler& meter() = 0;
  virtual QueueHandler* queue() { return nullptr; }  // nullptr: there is no queue
  virtual DaemonStatus status() const = 0;
  virtual ConfigView config_view() const = 0;
  // Metrics as text for Prometheus. Errors: busy.
  virtual Task<Result<std::string>> metrics() = 0;
};

}  // namespace lcrig
