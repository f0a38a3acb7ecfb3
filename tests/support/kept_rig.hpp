// SPDX-License-Identifier: Apache-2.0
// Simulated instruments that outlive their session, so that the truth can be read to the end. For
// scenario tests.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "daemon/rig/operator.hpp"
#include "daemon/rig/sim.hpp"
#include "tests/support/daemon_world.hpp"

namespace lcrig::support {

inline constexpr double kFarContact_m = 5e-3;  // far from all motions in the air

// Instruments that outlive their session, so that the truth can be read to the end.
class KeptInstruments final : public Instruments {
 public:
  explicit KeptInstruments(std::shared_ptr<Instruments> inner) : inner_(std::move(inner)) {
    info_ = inner_->info();
  }
  LcrMeter& meter() override { return inner_->meter(); }
  LoadFrame& frame() override { return inner_->frame(); }
  Operator& person() override { return inner_->person(); }
  Task<> close() override { return inner_->close(); }
  BenchDoor* door() override { return inner_->door(); }

 private:
  std::shared_ptr<Instruments> inner_;
};

class KeptRig final : public InstrumentFactory {
 public:
  KeptRig(asio::any_io_executor executor, VirtualClock& clock,
          std::function<void(std::shared_ptr<Instruments>)> opened)
      : executor_(executor), clock_(clock), opened_(std::move(opened)), person_(executor) {}

  Task<Result<std::unique_ptr<Instruments>>> open(InstrumentsRequest request) override {
    SimRequest sim;
    sim.bench = *find_bench("paper");
    sim.bench.plant.contact_travel_m = kFarContact_m;
    sim.specimen = *request.specimen;
    sim.weights = request.weights;
    sim.max_force_N = request.max_force_N;
    sim.person = &person_;
    auto made = make_sim_instruments(executor_, clock_, sim);
    if (!made) co_return fail(made.error());
    const std::shared_ptr<Instruments> inner = std::move(*made);
    if (request.why == LearnedBy::start) opened_(inner);
    co_return std::unique_ptr<Instruments>(std::make_unique<KeptInstruments>(inner));
  }

 private:
  asio::any_io_executor executor_;
  VirtualClock& clock_;
  std::function<void(std::shared_ptr<Instruments>)> opened_;
  RemoteOperator person_;  // who never comes
};

// A daemon on such a rig, and a client of it.
class KeptRigWorld : public DaemonWorld {
 protected:
  virtual void opened() {}  // the instruments of a run were opened

  AppParts parts() override {
    AppParts out;
    out.rig = std::make_unique<KeptRig>(io.get_executor(), clock, [this](auto instruments) {
      instruments_ = std::move(instruments);
      opened();
    });
    return out;
  }
  void SetUp() override {
    DaemonWorld::SetUp();
    client_ = std::make_unique<PlainClient>(socket_path());
  }
  void TearDown() override {
    client_.reset();
    DaemonWorld::TearDown();
    instruments_.reset();
  }

  std::shared_ptr<Instruments> instruments_;  // of the last run
  std::unique_ptr<PlainClient> client_;
};

}  // namespace lcrig::support
