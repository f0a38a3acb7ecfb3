// SPDX-License-Identifier: Apache-2.0
// Drivers and simulators, joined by wires: what the simulated bench (sim.cpp) and a recording that
// is played (replay.cpp) have in common. Nobody else includes this.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <string>

#include "daemon/rig/drill.hpp"
#include "daemon/rig/instruments.hpp"
#include "drivers/dead_weight/sim.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig {

class SimulatedInstruments : public Instruments, protected BenchDoor {
 public:
  SimulatedInstruments(asio::any_io_executor executor, Clock& clock);
  ~SimulatedInstruments() override;
  SimulatedInstruments(const SimulatedInstruments&) = delete;
  SimulatedInstruments& operator=(const SimulatedInstruments&) = delete;
  LcrMeter& meter() override { return *meter_; }
  LoadFrame& frame() override { return *frame_; }
  Operator& person() override { return *person_; }
  Task<> close() override;
  BenchDoor* door() override { return this; }
  void begin_run(RunSink& sink) override;
  void enter_step(const RunProgress& progress) override;

 protected:
  lcr6100::Lcr6100Sim& meter_sim() override { return *meter_sim_; }
  ZwickSim* frame_sim() override { return frame_sim_.get(); }
  const Plant* plant() override { return nullptr; }
  bool has_frame() const override { return frame_sim_ != nullptr; }
  void unplug_meter() override;
  void plug_meter(bool other_port) override;
  void unplug_frame() override;
  void plug_frame(bool other_port) override;
  void hook_meter(lcr6100::SimHooks hooks) override { meter_sim_->set_hooks(std::move(hooks)); }
  void break_meter(const std::function<void(lcr6100::SimFaults&)>& change) override {
    change(meter_sim_->faults());
  }
  std::string meter_identity() const override { return meter_sim_->identity(); }
  void power_meter(const std::string& identity) override { meter_sim_->power_on(identity); }
  void say_unasked(std::string text) override;
  void hook_frame(ZwickSimHooks hooks) override;
  void break_frame(const std::function<void(ZwickSimFaults&)>& change) override;
  void power_frame() override;
  void stall_frame() override;
  void restart_gateway(bool forgets_zero) override;
  void set_operator_absent(bool absent) override;

  // A simulator's task is counted, so that nothing it uses is destroyed under it.
  void start(Task<> task, int& count);
  // Both run the simulator; a port that goes away is opened again.
  void use_meter(std::unique_ptr<LcrMeter> meter);
  void use_frame(std::unique_ptr<LoadFrame> frame);
  Result<TransportPair> wire(const std::string& name);

  asio::any_io_executor executor_;
  Clock& clock_;
  int meters_ = 0, frames_ = 0;  // running simulators
  bool meter_plugged_ = true, frame_plugged_ = true;
  std::string meter_port_ = "sim:lcr", frame_port_ = "sim:frame";
  int ports_ = 1;  // devices named so far
  MakeWire make_wire_;
  std::function<std::unique_ptr<Transport>(std::unique_ptr<Transport>)> wrap_;
  std::unique_ptr<SimOperator> simulated_person_;
  std::unique_ptr<Operator> acting_person_;
  Operator* person_ = nullptr;
  std::unique_ptr<lcr6100::Lcr6100Sim> meter_sim_;
  std::unique_ptr<ZwickSim> frame_sim_;
  std::unique_ptr<LcrMeter> meter_;
  std::unique_ptr<LoadFrame> frame_;
  FaultDrill* drill_ = nullptr;

 private:
  // The simulated instruments again, on a new wire.
  Task<Result<std::unique_ptr<LcrMeter>>> open_meter();
  Task<Result<std::unique_ptr<LoadFrame>>> open_frame();
};

}  // namespace lcrig
