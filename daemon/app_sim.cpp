// SPDX-License-Identifier: Apache-2.0
// The simulated and the replayed bench: drivers on one end of a wire, simulators on the other.
#include <fmt/format.h>

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/rig/instruments.hpp"
#include "daemon/rig/recording.hpp"
#include "drivers/dead_weight/driver.hpp"
#include "drivers/dead_weight/sim.hpp"
#include "drivers/fd_transport.hpp"
#include "drivers/lcr6100/driver.hpp"
#include "drivers/lcr6100/sim.hpp"
#include "drivers/memory_pipe.hpp"
#include "drivers/reopening.hpp"
#include "drivers/zwick/driver.hpp"
#include "drivers/zwick/sim.hpp"
#include "model/bench_world.hpp"
#include "model/specimen_stiffness.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

// Confirms as another operator does, and then does what the prompt said.
class ActingOperator final : public Operator {
 public:
  ActingOperator(Operator& inner, std::function<void()> act)
      : inner_(inner), act_(std::move(act)) {}
  Task<Result<>> confirm(std::string prompt) override {
    auto done = co_await inner_.confirm(std::move(prompt));
    if (done) act_();
    co_return done;
  }
  const std::string& prompt() const override { return inner_.prompt(); }

 private:
  Operator& inner_;
  std::function<void()> act_;
};

// In real time bytes go through the kernel, as a cable's do.
MakeWire wire_for(const Clock& clock) {
  if (dynamic_cast<const VirtualClock*>(&clock) != nullptr) return make_memory_pipe;
  return make_socketpair;
}

// Drivers and simulators, joined by wires.
class SimulatedInstruments : public Instruments, private BenchDoor {
 public:
  SimulatedInstruments(asio::any_io_executor executor, Clock& clock)
      : executor_(std::move(executor)), clock_(clock), make_wire_(wire_for(clock)) {}
  LcrMeter& meter() override { return *meter_; }
  LoadFrame& frame() override { return *frame_; }
  Operator& person() override { return *person_; }
  Task<> close() override {
    meter_->close();
    frame_->close();
    meter_sim_->close();
    if (frame_sim_) frame_sim_->close();
    while (meters_ + frames_ > 0) co_await clock_.wait_for(1ms);
  }
  BenchDoor* door() override { return this; }

 protected:
  // A simulator's task is counted, so that nothing it uses is destroyed under it.
  void start(Task<> task, int& count) {
    ++count;
    asio::co_spawn(executor_, std::move(task), [&count](std::exception_ptr error) {
      --count;
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

  // The simulated instruments again, on a new wire, as a port is opened again after an unplug.
  Task<Result<std::unique_ptr<LcrMeter>>> open_meter() {
    if (!meter_plugged_) co_return fail(Errc::disconnected, "sim:lcr: no such port");
    meter_sim_->close();
    while (meters_ > 0) co_await clock_.wait_for(1ms);
    auto pair = wire(meter_port_);
    if (!pair) co_return fail(pair.error());
    meter_sim_->attach(std::move(pair->far));
    start(meter_sim_->run(), meters_);
    co_return std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_);
  }
  Task<Result<std::unique_ptr<LoadFrame>>> open_frame() {
    if (!frame_plugged_) co_return fail(Errc::disconnected, "sim:frame: nobody listens");
    frame_sim_->close();
    while (frames_ > 0) co_await clock_.wait_for(1ms);
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
    frame_ = std::make_unique<ReopeningFrame>(std::move(frame), [this] { return open_frame(); });
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
};

class BenchInstruments final : public SimulatedInstruments {
 public:
  using SimulatedInstruments::SimulatedInstruments;

  Result<> build(const SimRequest& request) {
    if (request.wire) make_wire_ = request.wire;
    wrap_ = request.wrap;
    if (auto built = build_world(request); !built) return built;
    simulated_person_ = std::make_unique<SimOperator>(clock_, request.bench.operator_reaction);
    person_ = request.person != nullptr ? request.person : simulated_person_.get();
    if (auto built = build_meter(request); !built) return built;
    return request.weights ? build_rod(request) : build_frame(request);
  }

 private:
  const Plant* plant() override { return &world_->plant(); }

  Result<> build_world(const SimRequest& request) {
    world_ = request.world;
    if (!world_) {
      auto world = make_world(request);
      if (!world) return fail(world.error());
      world_ = std::move(*world);
    }
    info_.fixture = request.bench.fixture;
    info_.bench_name = request.bench.name;
    info_.bench_text = request.bench.text;
    info_.simulated = true;
    info_.seed = request.seed;
    info_.model_level = std::string(to_string(world_->level().settings.level));
    info_.model_json = to_json(world_->level()).dump();
    // The plan knows what a plan of a real rig knows: where contact is, is only expected.
    info_.frame.stiffness_N_m = request.bench.plant.frame_stiffness_N_m;
    info_.specimen_least_m = least_shortening(request.specimen);
    info_.compression_m = world_->compression_m();
    info_.expected_contact = Length::from_si(world_->plant().config().contact_travel_m);
    return {};
  }

  Result<> build_meter(const SimRequest& request) {
    auto pair = wire(meter_port_);
    if (!pair) return fail(pair.error());
    lcr6100::SimConfig config;
    config.conversion_s = request.bench.plant.conversion_s;
    config.capacitance_noise_F = request.bench.plant.capacitance_noise_F;
    config.seed = static_cast<std::uint64_t>(request.seed);
    const auto source = [this](MonoTime t) { return world_->plant().electrical(t); };
    meter_sim_ = std::make_unique<lcr6100::Lcr6100Sim>(std::move(pair->far), clock_, config,
                                                       lcr6100::Lcr6100Sim::Source(source));
    use_meter(std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_));
    return {};
  }

  Result<> build_frame(const SimRequest& request) {
    auto pair = wire(frame_port_);
    if (!pair) return fail(pair.error());
    scene_ = std::make_unique<PlantScene>(world_->plant());
    ZwickSimSettings settings;
    settings.seed = static_cast<std::uint64_t>(request.seed) + 1;
    frame_sim_ = std::make_unique<ZwickSim>(std::move(pair->far), clock_, *scene_, settings);
    use_frame(std::make_unique<ZwickLink>(std::move(pair->near), clock_, executor_));
    return {};
  }

  Result<> build_rod(const SimRequest& request) {
    acting_person_ = std::make_unique<ActingOperator>(
        *person_, [this] { world_->plant().put_load(clock_.now(), rod_->pending_force().si()); });
    person_ = acting_person_.get();
    DeadWeightSettings settings;
    settings.g_m_s2 = request.bench.fixture.local_gravity_m_s2;
    if (const auto area_m2 = request.bench.fixture.probe_area_m2()) {
      settings.probe_area = Area::from_si(*area_m2);
    }
    auto rod = std::make_unique<DeadWeightFrame>(*person_, clock_, executor_, settings);
    rod_ = rod.get();
    frame_ = std::move(rod);
    return {};
  }

  std::shared_ptr<BenchWorld> world_;
  std::unique_ptr<PlantScene> scene_;
  DeadWeightFrame* rod_ = nullptr;
};

class ReplayInstruments final : public SimulatedInstruments {
 public:
  using SimulatedInstruments::SimulatedInstruments;

  Result<> build(const std::string& directory) {
    auto recording = load_recording(directory);
    if (!recording) return fail(recording.error());
    recording_ = std::move(*recording);
    info_.bench_name = "replay:" + directory;
    info_.simulated = true;
    // Whoever has to confirm the end of a recording does so when it is over.
    simulated_person_ =
        std::make_unique<SimOperator>(clock_, from_seconds(recording_.duration_s() + 1));
    person_ = simulated_person_.get();
    if (auto built = build_meter(); !built) return built;
    return build_frame();
  }

 private:
  Result<> build_meter() {
    auto pair = wire("replay:lcr");
    if (!pair) return fail(pair.error());
    const auto play = [this](Duration t) { return reading_at(to_seconds(t)); };
    meter_sim_ = std::make_unique<lcr6100::Lcr6100Sim>(
        std::move(pair->far), clock_, lcr6100::SimConfig(), lcr6100::Lcr6100Sim::Recording(play));
    meter_ = std::make_unique<lcr6100::Lcr6100>(std::move(pair->near), clock_);
    start(meter_sim_->run(), meters_);
    return {};
  }

  Result<> build_frame() {
    auto pair = wire("replay:frame");
    if (!pair) return fail(pair.error());
    std::vector<RecordedRow> rows;
    rows.reserve(recording_.samples.size());
    for (const RecordedSample& s : recording_.samples) {
      RecordedRow row;
      row.t_s = s.t_s;
      row.travel_m = s.travel_m;
      row.force_N = s.force_N;
      rows.push_back(row);
    }
    frame_sim_ = std::make_unique<ZwickSim>(std::move(pair->far), clock_, std::move(rows));
    frame_ = std::make_unique<ZwickLink>(std::move(pair->near), clock_, executor_);
    start(frame_sim_->run(), frames_);
    return {};
  }

  // The newest reading at this time, with the meter's own format; the first question starts both
  // instruments.
  std::optional<std::string> reading_at(double t_s) {
    if (!playing_) frame_sim_->start_recording();
    playing_ = true;
    const auto& rows = recording_.readings;
    while (next_ < rows.size() && rows[next_].t_s <= t_s) ++next_;
    if (next_ == 0) return std::nullopt;
    return fmt::format("{:+.5e},{:+.5e}", rows[next_ - 1].primary, rows[next_ - 1].secondary);
  }

  Recording recording_;
  std::size_t next_ = 0;  // first reading that is not due yet
  bool playing_ = false;
};

}  // namespace

Result<std::shared_ptr<BenchWorld>> make_world(const SimRequest& request) {
  PlantConfig mounting = request.bench.plant;
  mounting.seed = static_cast<std::uint64_t>(request.seed);
  if (request.weights) mounting.contact_travel_m = 0;
  auto world = BenchWorld::make(request.specimen, request.bench.error_tolerance,
                                Force::from_si(request.max_force_N), mounting);
  if (!world) return fail(world.error());
  return std::shared_ptr<BenchWorld>(std::move(*world));
}

Result<std::unique_ptr<Instruments>> make_sim_instruments(asio::any_io_executor executor,
                                                          Clock& clock, const SimRequest& request) {
  auto bench = std::make_unique<BenchInstruments>(executor, clock);
  if (auto built = bench->build(request); !built) return fail(built.error());
  return std::unique_ptr<Instruments>(std::move(bench));
}

Result<std::unique_ptr<Instruments>> make_replay_instruments(asio::any_io_executor executor,
                                                             Clock& clock,
                                                             const std::string& directory) {
  auto replay = std::make_unique<ReplayInstruments>(executor, clock);
  if (auto built = replay->build(directory); !built) return fail(built.error());
  return std::unique_ptr<Instruments>(std::move(replay));
}

std::optional<std::string> replay_directory(const std::string& bench) {
  constexpr std::string_view kPrefix = "replay:";
  if (!bench.starts_with(kPrefix)) return std::nullopt;
  return bench.substr(kPrefix.size());
}

}  // namespace lcrig
