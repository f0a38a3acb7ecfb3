// SPDX-License-Identifier: Apache-2.0
// Connects the fault script of lcrig-sim (`FaultPlayer`) to its two ports.
#pragma once

#include <string>

#include "drivers/faults/bench.hpp"
#include "tools/lcrig-sim/frame_port.hpp"
#include "tools/lcrig-sim/meter_port.hpp"

namespace lcrig::sim {

// `frame` is nullptr with dead weights. Both must outlive this.
class PortBench final : public FaultBench {
 public:
  PortBench(MeterPort& meter, FramePort* frame) : meter_(meter), frame_(frame) {}

  bool has_frame() const override { return frame_ != nullptr; }
  void unplug_meter() override { meter_.unplug(); }
  void plug_meter(bool other_port) override;
  void unplug_frame() override {
    if (frame_ != nullptr) frame_->unplug();
  }
  void plug_frame(bool other_port) override;  // over TCP it always keeps its port

  void hook_meter(lcr6100::SimHooks hooks) override { meter_.hook(std::move(hooks)); }
  void break_meter(const std::function<void(lcr6100::SimFaults&)>& change) override {
    meter_.change(change);
  }
  std::string meter_identity() const override { return meter_.identity(); }
  void power_meter(const std::string& identity) override { meter_.power_on(identity); }
  void turn_meter(PanelKey key, const std::string& to) override { meter_.turn(key, to); }
  void say_unasked(std::string text) override { meter_.say_unasked(std::move(text)); }

  void hook_frame(ZwickSimHooks hooks) override;
  void break_frame(const std::function<void(ZwickSimFaults&)>& change) override;
  void power_frame() override {
    if (frame_ != nullptr) frame_->forget();
  }
  void stall_frame() override;
  void restart_gateway(bool forgets_zero) override;

  // lcrig-sim has no operator, so check_stage refuses this fault.
  void set_operator_absent(bool /*absent*/) override {}

 private:
  MeterPort& meter_;
  FramePort* frame_;
};

}  // namespace lcrig::sim
