// SPDX-License-Identifier: Apache-2.0
// The instruments of one run. App alone chooses between a serial port (app_real.cpp) and a
// simulator (app_sim.cpp); the drivers are the same in both cases.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "daemon/config.hpp"
#include "daemon/rig/bench.hpp"
#include "daemon/rig/bench_door.hpp"
#include "drivers/lcr_meter.hpp"
#include "drivers/load_frame.hpp"
#include "drivers/transport.hpp"
#include "model/specimen.hpp"

namespace lcrig {

// What plan and run row say about them.
struct InstrumentsInfo {
  InstrumentsInfo() = default;
  Fixture fixture;
  std::string bench_name, bench_text;  // bench file; "replay:DIR" for a recording; empty on a rig
  bool simulated = false;
  std::optional<std::int64_t> seed;
  std::optional<std::string> model_level, model_json;  // of a simulated specimen
  FrameFacts frame;  // what a person has stated of it
  // Of the specimen, for the plan; empty: not known. See Rig.
  std::function<double(double force_N)> specimen_least_m, compression_m;
  std::optional<Length> expected_contact;
};

class Instruments {
 public:
  virtual ~Instruments() = default;
  virtual LcrMeter& meter() = 0;
  virtual LoadFrame& frame() = 0;
  virtual Operator& person() = 0;
  const InstrumentsInfo& info() const { return info_; }
  // Closes the ports; returns when every task of drivers and simulators has ended.
  virtual Task<> close() = 0;
  // For drills and tests; nullptr on a real rig.
  virtual BenchDoor* door() { return nullptr; }

 protected:
  InstrumentsInfo info_;
};

// A person who acts through `lcrig confirm`, Enter, or a button of the page.
class RemoteOperator final : public Operator {
 public:
  explicit RemoteOperator(asio::any_io_executor executor) : confirmations_(executor, 1) {}
  Task<Result<>> confirm(std::string prompt) override;
  bool confirmed();  // false: nothing waits for a confirmation
  const std::string& prompt() const override { return prompt_; }

 private:
  asio::experimental::channel<void(boost::system::error_code)> confirmations_;
  std::string prompt_;
};

// Opens the ports of the config file, which must outlive them: a port that goes away is opened
// again by it. Errors: as open_port.
Task<Result<std::unique_ptr<Instruments>>> open_real_instruments(asio::any_io_executor executor,
                                                                 Clock& clock, const Config& config,
                                                                 RemoteOperator& person);

// One of them alone.
Task<Result<std::unique_ptr<LcrMeter>>> open_real_meter(Clock& clock, const Config& config);
Task<Result<std::unique_ptr<LoadFrame>>> open_real_frame(asio::any_io_executor executor,
                                                         Clock& clock, const Config& config,
                                                         RemoteOperator& person);

class BenchWorld;

struct SimRequest {
  SimRequest() = default;
  Bench bench;
  Specimen specimen;
  std::int64_t seed = 1;
  bool weights = false;  // the protocol places weights: a rod instead of a frame
  double max_force_N = 1;  // of the table of the specimen
  std::shared_ptr<BenchWorld> world;  // of make_world for this very request; nullptr: made here
  Operator* person = nullptr;  // nullptr: one who confirms after the bench's reaction time
  MakeWire wire;  // empty: memory in virtual time, a socketpair in real time
  // Around the drivers' ends of the wires ("sim:lcr", "sim:frame"); for tests. May be empty.
  std::function<std::unique_ptr<Transport>(std::unique_ptr<Transport>)> wrap;
};
// The specimen under the probe. It takes seconds for one that needs finite elements, and uses
// nothing but the request. Errors: no model level describes it within the bench's tolerance.
Result<std::shared_ptr<BenchWorld>> make_world(const SimRequest& request);
// Errors: no model level describes the specimen within the bench's tolerance.
Result<std::unique_ptr<Instruments>> make_sim_instruments(asio::any_io_executor executor,
                                                          Clock& clock, const SimRequest& request);

// Plays lcr.csv and frame.csv of a directory through the simulated instruments' wires.
Result<std::unique_ptr<Instruments>> make_replay_instruments(asio::any_io_executor executor,
                                                             Clock& clock,
                                                             const std::string& directory);

// "replay:DIR" -> DIR.
std::optional<std::string> replay_directory(const std::string& bench);

}  // namespace lcrig
