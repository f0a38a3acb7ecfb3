// SPDX-License-Identifier: Apache-2.0
// The instruments of one run, and who makes them: real.hpp opens ports, sim.hpp puts simulators at
// the other end of a wire, replay.hpp plays a recording there. The drivers are the same in all
// cases, and Session does not know which one it has.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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
  std::string bench_name, bench_text;  // bench file; "replay:DIR" for a recording; empty on a rig
  bool simulated = false;
  std::optional<std::int64_t> seed;
  std::optional<std::string> model_level, model_json;  // of a simulated specimen
  std::optional<double> solved_to_N;  // where the table of a simulated specimen ends
  FrameFacts frame;  // what a person has stated of it
  // Facts about the specimen, for the plan; empty: not known. See Rig.
  std::function<double(double force_N)> specimen_least_m, compression_m;
  std::optional<Length> expected_contact;
  bool tells_corrections = true;  // false: a recording does not know those of its meter
};

class Instruments {
 public:
  virtual ~Instruments() = default;
  virtual LcrMeter& meter() = 0;
  virtual LoadFrame& frame() = 0;
  virtual Operator& person() = 0;
  // Answers the questions of a protocol in the place of people; nullptr: people do.
  virtual Respondent* respondent() { return nullptr; }
  const InstrumentsInfo& info() const { return info_; }
  // Closes the ports; returns when every task of drivers and simulators has ended.
  virtual Task<> close() = 0;
  // For drills and tests; nullptr on a real rig.
  virtual BenchDoor* door() { return nullptr; }
  // The run row is stored; a step begins. A drill goes by them.
  virtual void begin_run(RunSink& /*sink*/) {}
  virtual void enter_step(const RunProgress& /*progress*/) {}

 protected:
  InstrumentsInfo info_;
};

// The meter alone, for what is no run.
class LoneMeter {
 public:
  virtual ~LoneMeter() = default;
  virtual LcrMeter& meter() = 0;
  // As that of Instruments.
  virtual Task<> close() = 0;
};

// The instruments that a run wants.
struct InstrumentsRequest {
  const Specimen* specimen = nullptr;  // nullptr: not known (a replay)
  bool weights = false;  // a rod with weights instead of a frame
  double max_force_N = 1;  // of the table of a simulated specimen
  LearnedBy why = LearnedBy::start;  // they are wanted: for what a port says to it
};

// App has one and asks it for the instruments of every run. What only some rigs can do has a
// default.
class InstrumentFactory {
 public:
  virtual ~InstrumentFactory() = default;
  // `request.specimen` outlives the task. Errors: what a port or a simulated specimen has to say.
  virtual Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) = 0;
  // Asks both who they are; nothing at the frame changes. What comes of it is known then.
  virtual Task<> ask() { co_return; }
  // Errors: as `open`; unsupported.
  virtual Task<Result<std::unique_ptr<LoneMeter>>> open_lone_meter() {
    co_return fail(Errc::unsupported, "this rig has no meter that could be used without a run");
  }
  // The instruments are there without this program, and stay as it leaves them. App looks after
  // them while no run does.
  virtual bool is_real() const { return false; }
  virtual Task<> ask_meter() { co_return; }  // an absent instrument is a state, not a failure
  // STOP comes first, whatever else is wrong, and also with a gateway that answers no greeting.
  // True: the frame confirmed standstill.
  virtual Task<bool> make_frame_safe() { co_return true; }
  // Looks whether the nodes of the serial ports are there, without opening them, on a thread of its
  // own. True: one came or went.
  virtual Task<bool> watch_ports() { co_return false; }
  // No run goes on, and the config in force is another one.
  virtual void config_changed() {}
  // For a process that is about to end. False: the disk did not take all within this time.
  virtual bool finish_wire_logs(Duration /*patience*/) { return true; }
  // A thread reckons a simulated specimen, which may take minutes.
  virtual bool is_reckoning() const { return false; }
};

}  // namespace lcrig
