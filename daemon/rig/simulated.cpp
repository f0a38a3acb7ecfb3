// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/simulated.hpp"

#include <fmt/format.h>

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <utility>

#include "drivers/fd_transport.hpp"
#include "drivers/lcr6100/driver.hpp"
#include "drivers/memory_pipe.hpp"
#include "drivers/reopening.hpp"
#include "drivers/zwick/driver.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// In real time bytes go through the kernel, as a cable's do.
MakeWire wire_for(const Clock& clock) {
  if (dynamic_cast<const VirtualClock*>(&clock) != nullptr) return make_memory_pipe;
  return make_socketpair;
}

}  // namespace

SimulatedInstruments::SimulatedInstruments(asio::any_io_executor executor, Clock& clock)
    : executor_(std::move(executor)), clock_(clock), make_wire_(wire_for(clock)) {}

SimulatedInstruments::~SimulatedInstruments() {
  if (drill_ != nullptr) drill_->detach();
}

Task<> SimulatedInstruments::close() {
  if (drill_ != nullptr) co_await drill_->end();
  meter_->close();
  frame_->close();
  meter_sim_->close();
  if (frame_sim_) frame_sim_->close();
  while (meters_ + frames_ > 0) co_await clock_.wait_for(1ms);
}

void SimulatedInstruments::begin_run(RunSink& sink) {
  if (drill_ != nullptr) drill_->begin(sink);
}

void SimulatedInstruments::enter_step(const RunProgress& progress) {
  if (drill_ != nullptr) drill_->enter_step(progress);
}

void SimulatedInstruments::start(Task<> task, int& count) {
  ++count;
  asio::co_spawn(executor_, std::move(task), [&count](std::exception_ptr error) {
    --count;
    if (error) std::rethrow_exception(error);
  });
}

void SimulatedInstruments::unplug_meter() {
  meter_plugged_ = false;
  meter_sim_->close();
}

void SimulatedInstruments::plug_meter(bool other_port) {
  meter_plugged_ = true;
  if (other_port) meter_port_ = fmt::format("sim:lcr#{}", ++ports_);
}

void SimulatedInstruments::unplug_frame() {
  frame_plugged_ = false;
  if (frame_sim_) frame_sim_->close();
}

void SimulatedInstruments::plug_frame(bool other_port) {
  frame_plugged_ = true;
  if (other_port) frame_port_ = fmt::format("sim:frame#{}", ++ports_);
}

void SimulatedInstruments::say_unasked(std::string text) {
  if (meter_plugged_) start(meter_sim_->speak(std::move(text)), meters_);
}

void SimulatedInstruments::hook_frame(ZwickSimHooks hooks) {
  if (frame_sim_) frame_sim_->hooks = std::move(hooks);
}

void SimulatedInstruments::break_frame(const std::function<void(ZwickSimFaults&)>& change) {
  if (!frame_sim_) return;
  change(frame_sim_->faults);
  frame_sim_->poke();
}

void SimulatedInstruments::power_frame() {
  if (frame_sim_) frame_sim_->forget();
}

void SimulatedInstruments::stall_frame() {
  if (frame_sim_) frame_sim_->stall();
}

void SimulatedInstruments::restart_gateway(bool forgets_zero) {
  if (!frame_sim_) return;
  if (forgets_zero) frame_sim_->forget();
  frame_sim_->restart();
}

void SimulatedInstruments::set_operator_absent(bool absent) {
  if (simulated_person_) simulated_person_->set_absent(absent);
}

Task<Result<std::unique_ptr<LcrMeter>>> SimulatedInstruments::open_meter() {
  if (!meter_plugged_) co_return fail(Errc::disconnected, "sim:lcr: no such port");
  meter_sim_->close();
  while (meters_ > 0) co_await clock_.wait_for(1ms);
  auto pair = wire(meter_port_);
  if (!pair) co_return fail(pair.error());
  meter_sim_->attach(std::move(pair->far));
  start(meter_sim_->run(), meters_);
  co_return std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_);
}

Task<Result<std::unique_ptr<LoadFrame>>> SimulatedInstruments::open_frame() {
  if (!frame_plugged_) co_return fail(Errc::disconnected, "sim:frame: nobody listens");
  frame_sim_->close();
  while (frames_ > 0) co_await clock_.wait_for(1ms);
  auto pair = wire(frame_port_);
  if (!pair) co_return fail(pair.error());
  frame_sim_->attach(std::move(pair->far));
  start(frame_sim_->run(), frames_);
  co_return std::make_unique<ZwickLink>(std::move(pair->near), clock_, executor_);
}

void SimulatedInstruments::use_meter(std::unique_ptr<LcrMeter> meter) {
  meter_ = std::make_unique<ReopeningMeter>(std::move(meter), [this] { return open_meter(); });
  start(meter_sim_->run(), meters_);
}

void SimulatedInstruments::use_frame(std::unique_ptr<LoadFrame> frame) {
  frame_ = std::make_unique<ReopeningFrame>(std::move(frame), [this] { return open_frame(); });
  start(frame_sim_->run(), frames_);
}

Result<TransportPair> SimulatedInstruments::wire(const std::string& name) {
  auto pair = make_wire_(executor_, clock_, name);
  if (pair && wrap_) pair->near = wrap_(std::move(pair->near));
  return pair;
}

}  // namespace lcrig
