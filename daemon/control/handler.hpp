// SPDX-License-Identifier: Apache-2.0
// The interfaces between the control socket and the daemon. App and its parts implement them;
// called on the io_context thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "base/task.hpp"
#include "daemon/control/config_view.hpp"
#include "daemon/control/messages.hpp"
#include "protocols/plan/plan.hpp"
#include "storage/corrections.hpp"

namespace lcrig {

class QueueHandler;

// Calls of several clients, and several of one client, may overlap: a stop is never queued behind
// a start that is still preparing. A task is not cancelled when its client goes away.

// Runs that begin or go on, and the instruments before them.
class RunHandler {
 public:
  virtual ~RunHandler() = default;
  // Returns when the run row exists and the run goes on by itself. The operator, when the request
  // names none, is the peer. Errors: busy, invalid_request (protocol, parameters, specimen),
  // whatever the instruments said.
  virtual Task<Result<RunStarted>> start_run(RunRequest request, PeerCredentials peer) = 0;
  // Goes on after a pause, or (with `run`) continues an interrupted run at its step, in a new run:
  // `confirmed` says that a person found the specimen untouched; without it the run asks first.
  // Returns the run that goes on.
  virtual Task<Result<RunStarted>> resume(std::optional<std::int64_t> run, bool confirmed,
                                          PeerCredentials peer) = 0;
  // The plan that a start with the same request would make on this rig. Looks, and commands
  // nothing.
  virtual Task<Result<Plan>> plan_run(RunRequest request, PeerCredentials peer) = 0;
  // Asks both instruments who they are; nothing at the frame changes. Errors: busy.
  virtual Task<Result<>> ask_instruments(PeerCredentials peer) = 0;
};

// The run that goes on: its stops, and what it waits for from a person.
class SteeringHandler {
 public:
  virtual ~SteeringHandler() = default;
  virtual Task<Result<>> pause(PeerCredentials peer) = 0;
  // The same, and a stop, at the end of what is under way. Return at once, with when that will be.
  // Errors: invalid_request.
  virtual Task<Result<StopAnswer>> pause_at(StopPlace place, PeerCredentials peer) = 0;
  virtual Task<Result<StopAnswer>> stop_after(StopPlace place, std::string why,
                                              PeerCredentials peer) = 0;
  // Return when the frame confirmed standstill after this request, or when it is known what happens
  // instead: `finally` goes on, a run that was being prepared does not begin. Errors: not_standing.
  virtual Task<Result<StopAnswer>> abort(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<StopAnswer>> freeze(std::string why, PeerCredentials peer) = 0;
  virtual Task<Result<>> confirm(PeerCredentials peer) = 0;
  // Answers the question that waits; returns when the answer is stored. Errors: invalid_request (it
  // does not fit, nothing waits, another question does), io.
  virtual Task<Result<Answered>> answer(AnswerRequest request, PeerCredentials peer) = 0;
};

// What people add to the database.
class StoreHandler {
 public:
  virtual ~StoreHandler() = default;
  // Adds a note to a run that has ended, in the name of the peer. Errors: invalid_request, busy.
  virtual Task<Result<>> note_run(std::int64_t run, std::string text, PeerCredentials peer) = 0;
  // Puts tags on a run or takes them off; returns those that it has then. Errors: invalid_request,
  // busy.
  virtual Task<Result<std::vector<std::string>>> tag_run(TagRequest request,
                                                         PeerCredentials peer) = 0;
  // Stores a specimen; returns its name. Errors: invalid_request with the JSON pointer.
  virtual Task<Result<std::string>> add_specimen(std::string text, PeerCredentials peer) = 0;
};

// The meter without a run.
class MeterHandler {
 public:
  virtual ~MeterHandler() = default;
  // Makes the open or the short correction of the meter, whose probes a person has prepared. Takes
  // minutes. Errors: busy (a run, or a queue that goes), refused (the meter's verdict), whatever
  // the meter said.
  virtual Task<Result<MeterCorrections>> correct(CorrectionKind kind, PeerCredentials peer) = 0;
  // Asks the meter which corrections it applies. Errors: busy, whatever the meter said.
  virtual Task<Result<MeterCorrections>> look() = 0;
};

class ControlHandler {
 public:
  virtual ~ControlHandler() = default;
  virtual RunHandler& runs() = 0;
  virtual SteeringHandler& steering() = 0;
  virtual StoreHandler& store() = 0;
  virtual MeterHandler& meter() = 0;
  virtual QueueHandler* queue() { return nullptr; }  // nullptr: it has none
  virtual DaemonStatus status() const = 0;
  virtual ConfigView config_view() const = 0;
  // Text for Prometheus. Errors: busy.
  virtual Task<Result<std::string>> metrics() = 0;
};

}  // namespace lcrig
