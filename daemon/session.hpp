// SPDX-License-Identifier: Apache-2.0
// One run from its request to its closed row, both in the daemon and in a rehearsal. Used by
// RunStarter.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "base/task.hpp"
#include "base/time.hpp"
#include "daemon/record/reading_counts.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/rig/known.hpp"
#include "daemon/run_request.hpp"
#include "drivers/lcr_meter.hpp"
#include "model/specimen.hpp"
#include "protocols/plan/plan.hpp"
#include "protocols/protocol.hpp"
#include "protocols/rig/forecast.hpp"
#include "protocols/run/point.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

class Instruments;
class Run;
struct InstrumentsRequest;
struct RunResult;
struct RunRow;
struct RunSetup;

// The capacitance that a specimen should show at rest.
struct ExpectedAtRest {
  double capacitance_F = 0, tolerance_F = 0;
  std::string source;  // "in run 12", "by its file"
};

// A request whose files are correct. No instrument has been asked yet.
struct PreparedRun {
  RunRequest request;
  Protocol protocol;
  Environment environment;
  std::optional<Specimen> specimen;
  bool places_weights = false;
  double max_force_N = 0;  // from the protocol's limits
  std::optional<Continuation> continues;  // the interrupted run that it continues
  std::optional<std::int64_t> queue_entry;  // the entry of the queue that it belongs to
  std::optional<ExpectedAtRest> at_rest;  // compared before anything moves; none: no comparison
};
// The force limit of the protocol; a small force if it has none.
double largest_force_N(const Protocol& protocol, const Environment& environment);
// Errors: invalid_request with file position and JSON pointer.
Result<PreparedRun> prepare_run(RunRequest request);
// The instruments that a run needs. `run` must outlive the result.
InstrumentsRequest instruments_for(const PreparedRun& run);

// The rig for a plan, from identified instruments and their specimen.
Rig describe_rig(Instruments& instruments);
// Adds the facts in the specimen's file if the rig has no model of it.
void add_specimen(Rig& rig, const PreparedRun& run);

class Session {
 public:
  Session(asio::any_io_executor executor, Clock& clock, Recorder& recorder,
          std::unique_ptr<Instruments> instruments, PreparedRun prepared);
  ~Session();

  // Identifies both instruments and looks at them, plans with their capabilities, takes command of
  // the frame, configures the meter, and writes the run row. Everything that can be refused is
  // refused here. If it fails, nothing has moved; and if the plan is refused, a frame that can be
  // observed was not commanded.
  Task<Result<std::int64_t>> open();
  // Does the first part of `open`, up to the plan. Commands nothing.
  Task<Result<Plan>> preview();
  // Runs to the end and closes the run row. Call `close` afterwards, and after a failed `open`.
  Task<RunResult> execute();
  // See Run. Afterwards the frame is known to stand, or to be in trouble.
  Task<bool> stop_until_it_stands(std::function<bool()> gives_up);
  Task<> close();

  // Sets where it reports what it learns about the instruments, and why they are asked. Call it
  // before `preview` and `open`; `known` must outlive it.
  void report_to(KnownRig& known, LearnedBy why);

  Instruments& instruments() { return *instruments_; }
  Run* run() { return run_.get(); }  // nullptr until `open` has succeeded
  const Run* run() const { return run_.get(); }
  // After `preview` or `open`: the instruments that answered, and the rig that the plan used.
  const Identity& meter_identity() const { return meter_identity_; }
  const Identity& frame_identity() const { return frame_identity_; }
  const Rig& rig() const { return rig_; }
  // After `open` failed: why the specimen on the rig seems to be another one than requested.
  const std::optional<std::string>& stranger() const { return stranger_; }
  // After `open` failed: the run that it was to continue, if that has become impossible.
  std::optional<std::int64_t> lost_run() const { return lost_run_; }
  // The plan, after `preview` or `open`.
  const Plan& planned() const { return plan_; }
  // For the watchdog: grows while the run, or the storing of its end, makes progress.
  std::optional<std::uint64_t> beats() const;
  // The status from stored rows only.
  RunStatus status() const;
  // After `execute`: the anchor of the closed run's chain as text; empty if it could not be closed.
  const std::string& anchor() const { return anchor_; }
  bool simulated() const;  // an instrument is simulated; valid after `preview` or `open`
  bool is_turn_of_queue() const { return prepared_.queue_entry.has_value(); }
  bool places_weights() const { return prepared_.places_weights; }
  const std::string& operator_name() const { return prepared_.request.operator_name; }
  // Calls to its owner; each may be empty.
  struct Listener {
    std::function<void(const RunProgress&)> step;  // a step begins
    std::function<void()> stop;  // the frame was stopped, or did not confirm it
    std::function<void(const std::vector<RunEvent>&)> events;  // events of a commit
    // Called between the parts of `open`. An error ends it before anything is commanded.
    std::function<Result<>()> goes_on;
  };
  // Call it before `open`.
  void set_listener(Listener listener) { listener_ = std::move(listener); }

 private:
  Task<Result<>> identify();
  Task<Result<>> look();
  Task<Result<>> plan();
  Task<Result<>> require_room_for_plan();
  Task<Result<>> set_up_meter();
  Task<Result<>> take_command();
  Task<Result<>> compare_at_rest();
  void learn(Instrument which, const Result<Identity>& answer);
  void learn_of_run(std::int64_t run);
  void on_loss(Instrument which, const Error* lost);
  Result<> compare_origin();
  Task<Result<>> check_at_contact(double start_travel_m, double contact_travel_m);
  Recorder::Listener recorder_listener();
  RunSetup make_setup(std::int64_t run);
  RunRow make_row() const;
  void tell_locked(Duration waited, std::size_t rows);
  std::string moved_words() const;
  void tell_moved();
  void note_extrapolation();
  void acknowledge(const Committed& committed);
  void take_counts();

  asio::any_io_executor executor_;
  Clock& clock_;
  Recorder& recorder_;
  std::unique_ptr<Instruments> instruments_;
  PreparedRun prepared_;
  KnownRig* known_ = nullptr;  // nullptr: no report is wanted
  Learned learned_;
  Identity meter_identity_, frame_identity_;
  bool commands_ = true;  // whether the protocol commands the frame
  bool commanded_ = false;  // the session has taken command of the frame
  bool ending_ = false;  // the run is over, and its end is being stored
  Rig rig_;
  std::optional<Forecast> forecast_;
  Plan plan_;
  LcrSettings settings_;  // as read back
  CorrectionsOn corrections_;
  std::optional<std::string> stranger_;
  std::optional<std::int64_t> lost_run_;
  RunRecord acknowledged_;
  ReadingCounts counts_;
  std::string anchor_;
  Listener listener_;
  std::unique_ptr<Run> run_;
};

}  // namespace lcrig
