// SPDX-License-Identifier: Apache-2.0
// A random rig as the instruments of a run. One end of each wire has the drivers of a real rig, the
// other end the simulators. The run knows only what a config file would say. Used by RigWorld.
#pragma once

#include <boost/asio/co_spawn.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/rig/instruments.hpp"
#include "daemon/rig/sim_respondent.hpp"
#include "drivers/dead_weight/sim.hpp"
#include "drivers/lcr6100/driver.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/memory_pipe.hpp"
#include "drivers/reopening.hpp"
#include "drivers/zwick/driver.hpp"
#include "drivers/zwick/sim.hpp"
#include "tests/support/truth_scene.hpp"
#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig {

// Passes on every line that the driver sends and receives.
class TapTransport final : public Transport {
 public:
  using Heard = std::function<void(std::string_view line)>;
  TapTransport(std::unique_ptr<Transport> inner, Heard sent, Heard got)
      : inner_(std::move(inner)), sent_(std::move(sent)), got_(std::move(got)) {}
  Task<Result<std::size_t>> read_some(std::span<char> buffer, MonoTime deadline) override {
    auto n = co_await inner_->read_some(buffer, deadline);
    if (n) split(std::string_view(buffer.data(), *n), got_line_, got_);
    co_return n;
  }
  Task<Result<>> write_all(std::string_view bytes, MonoTime deadline) override {
    split(bytes, sent_line_, sent_);
    return inner_->write_all(bytes, deadline);
  }
  void close() override { inner_->close(); }
  const std::string& name() const override { return inner_->name(); }

 private:
  static void split(std::string_view bytes, std::string& line, const Heard& heard) {
    for (const char c : bytes) {
      if (c != '\n') {
        line += c;
      } else if (!line.empty()) {
        heard(std::exchange(line, {}));
      }
    }
  }

  std::unique_ptr<Transport> inner_;
  Heard sent_, got_;
  std::string sent_line_, got_line_;
};

class RigInstruments final : public Instruments, private BenchDoor {
 public:
  // `wire` makes a pair of transports. `sent` and `got` are called with every line of the frame
  // link.
  RigInstruments(asio::any_io_executor executor, Clock& clock, const sim::RandomRig& rig,
                 MakeWire wire, TapTransport::Heard sent, TapTransport::Heard got)
      : executor_(std::move(executor)),
        clock_(clock),
        rig_(rig),
        wire_(std::move(wire)),
        sent_(std::move(sent)),
        got_(std::move(got)),
        specimen_(rig.specimen()),
        plant_(specimen_, rig.plant),
        scene_(plant_),
        person_(clock, std::chrono::seconds(2)) {
    info_.fixture.probe_diameter_m = rig.probe_diameter_m;
    info_.frame.stiffness_N_m = rig.frame_stiffness_N_m;
    info_.frame.stated.force_class = ForceClass(rig.force_class_percent);
    info_.frame.stated.force_loop = rig.force_loop;
  }

  Result<> build() {
    auto meter = wire_(executor_, clock_, "sim:lcr");
    if (!meter) return fail(meter.error());
    auto frame = wire_(executor_, clock_, "sim:frame");
    if (!frame) return fail(frame.error());
    lcr6100::SimConfig config;
    config.seed = rig_.seed;
    const auto source = [this](MonoTime t) { return plant_.electrical(t); };
    meter_sim_ = std::make_unique<lcr6100::Lcr6100Sim>(std::move(meter->far), clock_, config,
                                                       lcr6100::Lcr6100Sim::Source(source));
    frame_sim_ = std::make_unique<ZwickSim>(std::move(frame->far), clock_, scene_, rig_.frame);
    meter_ = std::make_unique<ReopeningMeter>(
        std::make_unique<lcr6100::Lcr6100>(std::move(meter->near), clock_),
        [this] { return open_meter(); });
    frame_ = std::make_unique<ReopeningFrame>(
        link(std::move(frame->near)), [this] { return open_frame(); }, info_.frame.stated);
    start(meter_sim_->run(), meters_);
    start(frame_sim_->run(), frames_);
    return {};
  }

  LcrMeter& meter() override { return *meter_; }
  LoadFrame& frame() override { return *frame_; }
  Operator& person() override { return person_; }
  Respondent* respondent() override { return &respondent_; }
  BenchDoor* door() override { return this; }
  TruthScene& scene() { return scene_; }
  const Plant& truth() const { return plant_; }
  Task<> close() override {
    meter_->close();
    frame_->close();
    meter_sim_->close();
    frame_sim_->close();
    while (meters_ + frames_ > 0) co_await clock_.wait_for(std::chrono::milliseconds(1));
  }

 private:
  void start(Task<> task, int& count) {
    ++count;
    asio::co_spawn(executor_, std::move(task), [&count](std::exception_ptr error) {
      --count;
      if (error) std::rethrow_exception(error);
    });
  }
  std::unique_ptr<LoadFrame> link(std::unique_ptr<Transport> near) {
    auto tapped = std::make_unique<TapTransport>(std::move(near), sent_, got_);
    return std::make_unique<ZwickLink>(std::move(tapped), clock_, executor_);
  }
  Task<Result<std::unique_ptr<LcrMeter>>> open_meter() {
    if (!meter_plugged_) co_return fail(Errc::disconnected, "sim:lcr: no such port");
    meter_sim_->close();
    while (meters_ > 0) co_await clock_.wait_for(std::chrono::milliseconds(1));
    auto pair = wire_(executor_, clock_, "sim:lcr");
    if (!pair) co_return fail(pair.error());
    meter_sim_->attach(std::move(pair->far));
    start(meter_sim_->run(), meters_);
    co_return std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_);
  }
  Task<Result<std::unique_ptr<LoadFrame>>> open_frame() {
    if (!frame_plugged_) co_return fail(Errc::disconnected, "sim:frame: nobody listens");
    frame_sim_->close();
    while (frames_ > 0) co_await clock_.wait_for(std::chrono::milliseconds(1));
    auto pair = wire_(executor_, clock_, "sim:frame");
    if (!pair) co_return fail(pair.error());
    frame_sim_->attach(std::move(pair->far));
    start(frame_sim_->run(), frames_);
    co_return link(std::move(pair->near));
  }

  lcr6100::Lcr6100Sim& meter_sim() override { return *meter_sim_; }
  ZwickSim* frame_sim() override { return frame_sim_.get(); }
  const Plant* plant() override { return &plant_; }
  bool has_frame() const override { return true; }
  void unplug_meter() override {
    meter_plugged_ = false;
    meter_sim_->close();
  }
  void plug_meter(bool /*other_port*/) override { meter_plugged_ = true; }
  void unplug_frame() override {
    frame_plugged_ = false;
    frame_sim_->close();
  }
  void plug_frame(bool /*other_port*/) override { frame_plugged_ = true; }
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
  void hook_frame(ZwickSimHooks hooks) override { frame_sim_->hooks = std::move(hooks); }
  void break_frame(const std::function<void(ZwickSimFaults&)>& change) override {
    change(frame_sim_->faults);
    frame_sim_->poke();
  }
  void power_frame() override { frame_sim_->forget(); }
  void stall_frame() override { frame_sim_->stall(); }
  void restart_gateway(bool forgets_zero) override {
    if (forgets_zero) frame_sim_->forget();
    frame_sim_->restart();
  }
  void set_operator_absent(bool absent) override { person_.set_absent(absent); }

  asio::any_io_executor executor_;
  Clock& clock_;
  sim::RandomRig rig_;
  MakeWire wire_;
  TapTransport::Heard sent_, got_;
  int meters_ = 0, frames_ = 0;  // number of running simulators
  bool meter_plugged_ = true, frame_plugged_ = true;
  sim::CurvedSpecimen specimen_;
  Plant plant_;
  TruthScene scene_;
  SimOperator person_;
  SimRespondent respondent_{clock_, std::chrono::seconds(2), [this] { return person_.is_absent(); },
                            Answers()};
  std::unique_ptr<lcr6100::Lcr6100Sim> meter_sim_;
  std::unique_ptr<ZwickSim> frame_sim_;
  std::unique_ptr<LcrMeter> meter_;
  std::unique_ptr<LoadFrame> frame_;
};

}  // namespace lcrig
