// SPDX-License-Identifier: Apache-2.0
// Drivers and simulators, connected by wires. Base class of the simulated bench (sim.cpp) and of a
// recording that is played (replay.cpp). Only these two include it.
#pragma once

#include <fmt/format.h>

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/condition.hpp"
#include "daemon/rig/drill.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/rig/sim_respondent.hpp"
#include "drivers/dead_weight/sim.hpp"
#include "drivers/fd_transport.hpp"
#include "drivers/lcr6100/driver.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/memory_pipe.hpp"
#include "drivers/reopening.hpp"
#include "drivers/zwick/driver.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig {

// In real time bytes go through the kernel, like those of a cable.
inline MakeWire wire_for(const Clock& clock) {
  if (dynamic_cast<const VirtualClock*>(&clock) != nullptr) return make_memory_pipe;
  return make_socketpair;
}

class SimulatedInstruments : public Instruments, protected BenchDoor {
 public:
  SimulatedInstruments(asio::any_io_executor executor, Clock& clock)
      : executor_(std::move(executor)), clock_(clock), ended_(clock), make_wire_(wire_for(clock)) {}
  LcrMeter& meter() override { return *meter_; }
  LoadFrame& frame() override { return *frame_; }
  Operator& person() override { return *person_; }
  Respondent* respondent() override { return respondent_.get(); }
  ~SimulatedInstruments() override {
    if (drill_ != nullptr) drill_->detach();
  }
  SimulatedInstruments(const SimulatedInstruments&) = delete;
  SimulatedInstruments& operator=(const SimulatedInstruments&) = delete;
  Task<> close() override {
    if (drill_ != nullptr) co_await drill_->end();
    meter_->close();
    frame_->close();
    meter_sim_->close();
    if (frame_sim_) frame_sim_->close();
    const auto all_ended = [this] { return meters_ + frames_ == 0; };
    co_await ended_.wait(all_ended);
  }
  BenchDoor* door() override { return this; }
  void begin_run(RunSink& sink) override {
    if (drill_ != nullptr) drill_->begin(sink);
  }
  void enter_step(const RunProgress& progress) override {
    if (drill_ != nullptr) drill_->enter_step(progress);
  }

 protected:
  // Counts the running tasks of simulators, so that nothing is destroyed while a task uses it.
  void start(Task<> task, int& count) {
    ++count;
    asio::co_spawn(executor_, std::move(task), [this, &count](std::exception_ptr error) {
      --count;
      ended_.notify_all();
      if (error) std::rethrow_exception(error);
    });
  }
  lcr6100::Lcr6100Sim& meter_sim() override { return *meter_sim_; }
  ZwickSim* frame_sim() override { return frame_sim_.get(); }
  const Plant* plant() override { return nullptr; }
  bool has_frame() const override { return frame_sim_ != nullptr; }
  void unplug_meter() override {
    meter_plugged_ = false;
    meter_sim_->close();
  }
  void plug_meter(bool other_port) override {
    meter_plugged_ = true;
    if (other_port) meter_port_ = fmt::format("sim:lcr#{}", ++ports_);
  }
  void unplug_frame() override {
    frame_plugged_ = false;
    if (frame_sim_) frame_sim_->close();
  }
  void plug_frame(bool other_port) override {
    frame_plugged_ = true;
    if (other_port) frame_port_ = fmt::format("sim:frame#{}", ++ports_);
  }

  void hook_meter(lcr6100::SimHooks hooks) override { meter_sim_->set_hooks(std::move(hooks)); }
  void break_meter(const std::function<void(lcr6100::SimFaults&)>& change) override {
    change(meter_sim_->faults());
  }
  std::string meter_identity() const override { return meter_sim_->identity(); }
  void power_meter(const std::string& identity) override { meter_sim_->power_on(identity); }
  void turn_meter(PanelKey key, const std::string& to) override { meter_sim_->turn(key, to); }
  void say_unasked(std::string text) override {
    if (meter_plugged_) start(meter_sim_->speak(std::move(text)), meters_);
  }
  void hook_frame(ZwickSimHooks hooks) override {
    if (frame_sim_) frame_sim_->hooks = std::move(hooks);
  }
  void break_frame(const std::function<void(ZwickSimFaults&)>& change) override {
    if (!frame_sim_) return;
    change(frame_sim_->faults);
    frame_sim_->poke();
  }
  void power_frame() override {
    if (frame_sim_) frame_sim_->forget();
  }
  void stall_frame() override {
    if (frame_sim_) frame_sim_->stall();
  }
  void restart_gateway(bool forgets_zero) override {
    if (!frame_sim_) return;
    if (forgets_zero) frame_sim_->forget();
    frame_sim_->restart();
  }
  void set_operator_absent(bool absent) override {
    if (simulated_person_) simulated_person_->set_absent(absent);
  }

  // Open the simulated instruments again on a new wire, as a port is opened again after an unplug.
  Task<Result<std::unique_ptr<LcrMeter>>> open_meter() {
    if (!meter_plugged_) co_return fail(Errc::disconnected, "sim:lcr: no such port");
    meter_sim_->close();
    const auto ended = [this] { return meters_ == 0; };
    co_await ended_.wait(ended);
    auto pair = wire(meter_port_);
    if (!pair) co_return fail(pair.error());
    meter_sim_->attach(std::move(pair->far));
    start(meter_sim_->run(), meters_);
    co_return std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_);
  }
  Task<Result<std::unique_ptr<LoadFrame>>> open_frame() {
    if (!frame_plugged_) co_return fail(Errc::disconnected, "sim:frame: nobody listens");
    frame_sim_->close();
    const auto ended = [this] { return frames_ == 0; };
    co_await ended_.wait(ended);
    auto pair = wire(frame_port_);
    if (!pair) co_return fail(pair.error());
    frame_sim_->attach(std::move(pair->far));
    start(frame_sim_->run(), frames_);
    co_return std::make_unique<ZwickLink>(std::move(pair->near), clock_, executor_);
  }
  void use_meter(std::unique_ptr<LcrMeter> meter) {
    meter_ = std::make_unique<ReopeningMeter>(std::move(meter), [this] { return open_meter(); });
    start(meter_sim_->run(), meters_);
  }
  void use_frame(std::unique_ptr<LoadFrame> frame) {
    frame_ = std::make_unique<ReopeningFrame>(
        std::move(frame), [this] { return open_frame(); }, info_.frame.stated);
    start(frame_sim_->run(), frames_);
  }
  Result<TransportPair> wire(const std::string& name) {
    auto pair = make_wire_(executor_, clock_, name);
    if (pair && wrap_) pair->near = wrap_(std::move(pair->near));
    return pair;
  }

  asio::any_io_executor executor_;
  Clock& clock_;
  int meters_ = 0, frames_ = 0;  // running simulators
  Condition ended_;  // notified when a simulator ends
  bool meter_plugged_ = true, frame_plugged_ = true;
  std::string meter_port_ = "sim:lcr", frame_port_ = "sim:frame";
  int ports_ = 1;  // number of device names so far
  MakeWire make_wire_;
  std::function<std::unique_ptr<Transport>(std::unique_ptr<Transport>)> wrap_;
  std::unique_ptr<SimOperator> simulated_person_;
  std::unique_ptr<Operator> acting_person_;
  std::unique_ptr<SimRespondent> respondent_;  // nullptr: people answer
  Operator* person_ = nullptr;
  std::unique_ptr<lcr6100::Lcr6100Sim> meter_sim_;
  std::unique_ptr<ZwickSim> frame_sim_;
  std::unique_ptr<LcrMeter> meter_;
  std::unique_ptr<LoadFrame> frame_;
  FaultDrill* drill_ = nullptr;
};

}  // namespace lcrig
