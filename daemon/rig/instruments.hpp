// SPDX-License-Identifier: Apache-2.0
// The instruments of one run, and their factories: real.hpp opens ports, sim.hpp puts simulators at
// the other end of a wire, replay.hpp plays a recording there. The drivers are the same in all
// cases, and Session does not know which one it has.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/time.hpp"
#include "daemon/config.hpp"
#include "daemon/rig/bench.hpp"
#include "daemon/rig/bench_door.hpp"
#include "daemon/rig/known.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "model/specimen.hpp"
#include "protocols/run/questions.hpp"
#include "protocols/run/sink.hpp"

namespace lcrig {

// Facts about the instruments for the plan and the run row.
struct InstrumentsInfo {
  Fixture fixture;
  std::string bench_name, bench_text;  // bench file; "replay:DIR" for a recording; empty for a real
                                       // rig
  bool simulated = false;
  std::optional<std::int64_t> seed;
  std::optional<std::string> model_level, model_json;  // of a simulated specimen
  std::optional<double> solved_to_N;  // largest force in the table of a simulated specimen
  FrameFacts frame;  // as a person stated it
  // Facts about the specimen for the plan; empty: unknown. See Rig.
  std::function<double(double force_N)> specimen_least_m, specimen_free_m, compression_m;
  std::optional<Length> expected_contact;
  bool tells_corrections = true;  // false: a recording does not contain its meter's corrections
};

class Instruments {
 public:
  virtual ~Instruments() = default;
  virtual LcrMeter& meter() = 0;
  virtual LoadFrame& frame() = 0;
  virtual Operator& person() = 0;
  // Answers the questions of a protocol; nullptr: people do.
  virtual Respondent* respondent() { return nullptr; }
  const InstrumentsInfo& info() const { return info_; }
  // Closes the ports; returns when every task of drivers and simulators has ended.
  virtual Task<> close() = 0;
  // Access for drills and tests; nullptr on a real rig.
  virtual BenchDoor* door() { return nullptr; }
  // Called when the run row is stored, and when a step begins. A drill needs both.
  virtual void begin_run(RunSink& /*sink*/) {}
  virtual void enter_step(const RunProgress& /*progress*/) {}

 protected:
  InstrumentsInfo info_;
};

// The meter alone, for use without a run.
class LoneMeter {
 public:
  virtual ~LoneMeter() = default;
  virtual LcrMeter& meter() = 0;
  // As in Instruments.
  virtual Task<> close() = 0;
};

// What a run needs.
struct InstrumentsRequest {
  const Specimen* specimen = nullptr;  // nullptr: unknown (in a replay)
  bool weights = false;  // a rod with weights instead of a frame
  double max_force_N = 1;  // for the table of a simulated specimen
  LearnedBy why = LearnedBy::start;  // why they are opened; stored with what they answer
};

// Makes the instruments of every run; App has one. Functions that only some rigs support have a
// default.
class InstrumentFactory {
 public:
  virtual ~InstrumentFactory() = default;
  // `request.specimen` must outlive the task. Errors: those of a port or a simulated specimen.
  virtual Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) = 0;
  // Asks both for their identity; nothing at the frame changes. KnownRig gets the result.
  virtual Task<> ask() { co_return; }
  // Errors: as `open`; unsupported.
  virtual Task<Result<std::unique_ptr<LoneMeter>>> open_lone_meter() {
    co_return fail(Errc::unsupported, "this rig has no meter that could be used without a run");
  }
  // True for instruments that exist without this program and stay as it leaves them. App looks
  // after them while no run does.
  virtual bool is_real() const { return false; }
  virtual Task<> ask_meter() { co_return; }  // an absent instrument is a state, not an error
  // Sends STOP first, whatever else is wrong, even to a gateway that answers no greeting. True: the
  // frame confirmed standstill.
  virtual Task<bool> make_frame_safe() { co_return true; }
  // Checks on a thread of its own, without opening them, whether the device nodes of the serial
  // ports exist. True: one came or went.
  virtual Task<bool> watch_ports() { co_return false; }
  // The configuration has changed while no run goes on.
  virtual void config_changed() {}
  // For a process that is about to end. False: the disk did not take everything within this time.
  virtual bool finish_wire_logs(Duration /*patience*/) { return true; }
  // A thread computes a simulated specimen, which may take minutes.
  virtual bool is_computing() const { return false; }
};

}  // namespace lcrig
