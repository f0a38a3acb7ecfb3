// SPDX-License-Identifier: Apache-2.0
// The simulated bench as the instruments of a run: in real time for a daemon without a rig, in
// virtual time for rehearsals and tests.
#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "daemon/rig/answers.hpp"
#include "daemon/rig/instruments.hpp"
#include "drivers/memory_pipe.hpp"

namespace lcrig {

class BenchWorld;
class FaultDrill;

struct SimRequest {
  SimRequest() = default;
  SimRequest(Bench b, const InstrumentsRequest& wanted)
      : bench(std::move(b)), weights(wanted.weights), max_force_N(wanted.max_force_N) {
    if (wanted.specimen != nullptr) specimen = *wanted.specimen;
  }
  std::optional<std::string> replay;  // the folder of a recording that is played instead of a bench
  Bench bench;
  std::optional<Specimen> specimen;  // a bench needs one
  std::int64_t seed = 1;
  bool weights = false;  // the protocol places weights: a rod instead of a frame
  double max_force_N = 1;  // for the table of the specimen
  std::shared_ptr<BenchWorld> world;  // made by make_world for the same request; nullptr: made here
  // nullptr: a simulated person, who confirms and gives `answers`, each after the bench's reaction
  // time.
  Operator* person = nullptr;
  Answers answers;
  StatedFrame stated;  // about the frame, as a config file would
  FaultDrill* drill = nullptr;  // must outlive the instruments; nullptr: nothing goes wrong
  MakeWire wire;  // empty: memory in virtual time, a socketpair in real time
  // Wraps the drivers' ends of the wires ("sim:lcr", "sim:frame"), for tests. May be empty.
  std::function<std::unique_ptr<Transport>(std::unique_ptr<Transport>)> wrap;
};
// Errors: as bench_of.
Result<SimRequest> sim_request(const BenchChoice& choice, const InstrumentsRequest& wanted);
// Makes the specimen under the probe, from the request alone; nullptr: a recording has none. Takes
// seconds if it needs finite elements. Errors: no specimen is given, or no model level describes it
// within the bench's tolerance.
Result<std::shared_ptr<BenchWorld>> make_world(const SimRequest& request);
// Errors: as make_world and make_replay_instruments; the drill does not fit the bench.
Result<std::unique_ptr<Instruments>> make_sim_instruments(asio::any_io_executor executor,
                                                          Clock& clock, const SimRequest& request);

// The rig of a daemon whose config file names a bench, or "replay:DIR".
class SimulatedRig final : public InstrumentFactory {
 public:
  // `clock`, `known` and `person` must outlive it.
  SimulatedRig(asio::any_io_executor executor, Clock& clock, std::string bench, KnownRig& known,
               Operator& person);
  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) override;
  Task<> ask() override;  // checks that the bench or the recording can be read
  Task<Result<std::unique_ptr<LoneMeter>>> open_lone_meter() override;
  bool is_computing() const override { return is_computing_; }

 private:
  void failed(const Error& error, LearnedBy by);

  asio::any_io_executor executor_;
  Clock& clock_;
  std::string bench_;
  KnownRig& known_;
  Operator& person_;
  bool is_computing_ = false;
};

}  // namespace lcrig
