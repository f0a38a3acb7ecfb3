// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/fault_bench.hpp"

#include <spdlog/spdlog.h>
#include <utility>

namespace lcrig::sim {

namespace {

void tell(const Result<>& plugged) {
  if (!plugged) spdlog::error("fault script: cannot be plugged in: {}", plugged.error().what);
}

}  // namespace

void PortBench::plug_meter(bool other_port) {
  tell(meter_.plug(other_port));
  spdlog::info("the meter is at {}", meter_.url());
}

void PortBench::plug_frame(bool /*other_port*/) {
  if (frame_ == nullptr) return;
  tell(frame_->plug());
  spdlog::info("the frame is at {}", frame_->url());
}

void PortBench::hook_frame(ZwickSimHooks hooks) {
  if (frame_ != nullptr) frame_->hook(std::move(hooks));
}
void PortBench::break_frame(const std::function<void(ZwickSimFaults&)>& change) {
  if (frame_ != nullptr) frame_->change(change);
}
void PortBench::stall_frame() {
  if (frame_ != nullptr && frame_->gateway() != nullptr) frame_->gateway()->stall();
}
void PortBench::restart_gateway(bool forgets_zero) {
  if (frame_ != nullptr) frame_->restart(forgets_zero);
}

}  // namespace lcrig::sim
