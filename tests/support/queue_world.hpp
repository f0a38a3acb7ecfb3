// SPDX-License-Identifier: Apache-2.0
// A daemon with a queue, in virtual time, on simulated instruments that may have a different
// trouble in each run. For scenario tests.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/rig/drill.hpp"
#include "daemon/rig/sim.hpp"
#include "tests/support/daemon_world.hpp"

namespace lcrig::support {

// The trouble at one opening of the instruments.
struct Trouble {
  std::string script;  // a fault script; empty: no faults
  std::function<void(Instruments&)> at_start;  // before they are identified; may be empty
  std::optional<Error> refuses;  // the ports do not open
  double stray_F = 0;  // added to the capacitance that the meter shows
};

class TroubledRig final : public InstrumentFactory {
 public:
  TroubledRig(asio::any_io_executor executor, VirtualClock& clock, std::map<int, Trouble>& troubles)
      : executor_(std::move(executor)), clock_(clock), troubles_(troubles) {}

  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) override {
    // Only starts count: plans are made on a rig without trouble.
    static const Trouble kNone;
    const bool starts = request.why == LearnedBy::start;
    const Trouble& trouble = starts ? troubles_[++starts_] : kNone;
    if (trouble.refuses) co_return fail(*trouble.refuses);
    SimRequest sim;
    sim.bench = *find_bench("paper");
    sim.bench.plant.contact_travel_m = 0.6e-3;
    sim.bench.plant.stray_capacitance_F = trouble.stray_F;
    sim.specimen = *request.specimen;
    sim.weights = request.weights;
    sim.max_force_N = request.max_force_N;
    if (!trouble.script.empty()) {
      auto drill = FaultDrill::make(clock_, trouble.script, "script");
      EXPECT_TRUE(drill) << drill.error().what;
      drills_.push_back(std::move(*drill));
      sim.drill = drills_.back().get();
    }
    auto made = make_sim_instruments(executor_, clock_, sim);
    if (made && trouble.at_start) trouble.at_start(**made);
    co_return made;
  }
  Task<> ask() override { co_return; }

 private:
  asio::any_io_executor executor_;
  VirtualClock& clock_;
  std::map<int, Trouble>& troubles_;
  int starts_ = 0;
  std::vector<std::unique_ptr<FaultDrill>> drills_;
};

// A protocol whose step ids are the phases of a run; "finally" is the step of `finally`.
inline constexpr const char* kPhasedProtocol =
    R"({ "format": "load-protocol/1", "name": "phased", "on_loss": "wait", "on_loss_timeout_s": 5,
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "near", "do": "ramp", "to": { "travel_mm": 0.57 }, "speed_mm_s": 0.65, "timeout_s": 6 },
    { "id": "approach", "do": "find_contact", "speed_mm_s": 0.05, "force_N": 0.02, "back_off_mm": 0.03, "timeout_s": 6 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.03, "timeout_s": 6 },
    { "id": "hold", "do": "hold", "hold": "force", "force_N": 0.5, "for_s": 1.5 },
    { "id": "measure", "do": "measure", "count": 6, "within_s": 1.5 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.1 }, "speed_mm_s": 0.1, "timeout_s": 4 } ],
  "finally": [ { "id": "finally", "do": "ramp", "to": { "travel_mm": 0 }, "speed_mm_s": 0.5, "timeout_s": 4 } ] })";

class QueueWorld : public DaemonWorld {
 protected:
  void SetUp() override {
    DaemonWorld::SetUp();
    client = std::make_unique<PlainClient>(socket_path());
  }
  void TearDown() override {
    client.reset();
    DaemonWorld::TearDown();
  }
  AppParts parts() override {
    AppParts out;
    out.rig = std::make_unique<TroubledRig>(io.get_executor(), clock, troubles);
    return out;
  }
  // Like a restart after a kill: what the daemon did not store is lost.
  void restart() {
    client.reset();
    stop();
    start("d.db");
    client = std::make_unique<PlainClient>(socket_path());
  }

  static json entry(const std::string& specimen, json more = json::object()) {
    json out{{"protocol", "phased"},
             {"protocol_text", kPhasedProtocol},
             {"specimen", specimen},
             {"specimen_text", std::string(shipped_specimens().front().text)}};
    out.update(more);
    return out;
  }
  json call(const std::string& method, const json& params = json::object()) {
    return answer(*client, method, params);
  }
  // Makes a call that must succeed.
  json ok(const std::string& method, const json& params = json::object()) {
    const json got = call(method, params);
    EXPECT_TRUE(got.contains("result")) << method << ": " << got;
    return got.value("result", json::object());
  }
  std::string refusal(const std::string& method, const json& params = json::object()) {
    const json got = call(method, params);
    EXPECT_TRUE(got.contains("error")) << method << ": " << got;
    return got.contains("error") ? got["error"]["message"].get<std::string>() : "";
  }
  // Queues these specimens, with `terms` for all.
  void queue_up(const std::vector<std::string>& specimens, const json& terms = json::object()) {
    for (const auto& specimen : specimens) ok("queue.add", entry(specimen, terms));
  }
  json queue() { return ok("status")["queue"]; }
  // Lets time pass until `holds` is true of the queue's status, and looks once in 1/3600 of
  // `patience`, which is 0.5 s for the half hour. False: not within this time.
  bool until(const std::function<bool(const json&)>& holds,
             Duration patience = std::chrono::minutes(30)) {
    const MonoTime end = clock.now() + patience;
    while (clock.now() < end) {
      if (holds(queue())) return true;
      clock.run_for(io, patience / 3600);
    }
    return false;
  }
  bool until_gate(const std::string& kind) {
    return until([&](const json& q) { return q["gate"] == kind; });
  }
  bool until_held() {
    return until([](const json& q) { return q["going"] == false; });
  }
  std::string state(std::int64_t number) {
    return ok("queue.show", {{"entry", number}})["state"].get<std::string>();
  }
  std::int64_t runs() { return count("SELECT count(*) FROM run"); }

  std::map<int, Trouble> troubles;  // by the number of the start of a run, from 1
  std::unique_ptr<PlainClient> client;
};

}  // namespace lcrig::support
