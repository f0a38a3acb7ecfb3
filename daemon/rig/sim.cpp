// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/sim.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/aside.hpp"
#include "daemon/rig/recording.hpp"
#include "daemon/rig/replay.hpp"
#include "daemon/rig/simulated.hpp"
#include "drivers/dead_weight/driver.hpp"
#include "model/bench_world.hpp"
#include "model/specimen_stiffness.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

// Waits for the confirmation of another operator, and then does what the prompt asked for.
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

class BenchInstruments final : public SimulatedInstruments {
 public:
  using SimulatedInstruments::SimulatedInstruments;

  Result<> build(const SimRequest& request) {
    if (request.wire) make_wire_ = request.wire;
    wrap_ = request.wrap;
    if (auto built = build_world(request); !built) return built;
    simulated_person_ = std::make_unique<SimOperator>(clock_, request.bench.operator_reaction);
    person_ = request.person != nullptr ? request.person : simulated_person_.get();
    if (request.person == nullptr) {
      respondent_ = std::make_unique<SimRespondent>(
          clock_, request.bench.operator_reaction,
          [this] { return simulated_person_->is_absent(); }, request.answers);
    }
    if (auto built = build_meter(request); !built) return built;
    if (auto built = request.weights ? build_rod(request) : build_frame(request); !built) {
      return built;
    }
    drill_ = request.drill;
    return drill_ != nullptr ? drill_->attach(executor_, *this) : Result<>();
  }

 private:
  const Plant* plant() override { return &world_->plant(); }

  Result<> build_world(const SimRequest& request) {
    world_ = request.world;
    if (!world_) {
      if (auto made = keep(make_world(request), world_); !made) return made;
    }
    info_.fixture = request.bench.fixture;
    info_.bench_name = request.bench.name;
    info_.bench_text = request.bench.text;
    info_.simulated = true;
    info_.seed = request.seed;
    info_.model_level = std::string(to_string(world_->level().settings.level));
    info_.solved_to_N = world_->response().max_force_N();
    nlohmann::json model = to_json(world_->level());
    if (world_->errors()) {
      model["drawn"] = world_->errors()->to_json();
      // Lasting errors are drawn from it, so that runs with the same seed are of one rig.
      model["rig_seed"] = request.bench.rig_seed.value_or(static_cast<std::uint64_t>(request.seed));
    }
    info_.model_json = model.dump();
    // The plan gets only what it would know of a real rig; the place of contact is only an
    // expectation.
    info_.frame.stiffness_N_m = request.bench.plant.frame_stiffness_N_m;
    info_.frame.cell_serial = request.bench.cell_serial;
    info_.frame.stated = request.stated;
    info_.specimen_least_m = least_shortening(*request.specimen);
    info_.specimen_free_m = free_shortening(*request.specimen);
    info_.compression_m = world_->compression_m();
    info_.expected_contact = Length::from_si(world_->plant().config().contact_travel_m);
    return {};
  }

  Result<> build_meter(const SimRequest& request) {
    auto pair = wire(meter_port_);
    if (!pair) return fail(pair.error());
    lcr6100::SimConfig config;
    const PlantConfig& plant = world_->plant().config();
    config.conversion_s = plant.conversion_s;
    config.capacitance_noise_F = plant.capacitance_noise_F;
    config.gain_error = plant.meter_gain_error;
    config.offset_error = plant.meter_offset_error;
    config.seed = static_cast<std::uint64_t>(request.seed);
    config.corrected = true;
    const auto source = [this](MonoTime t) { return world_->electrical(t); };
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
    settings.rate_max_Hz = request.bench.frame_rate_max_Hz;
    if (world_->errors()) settings.device_clock_ppm = world_->errors()->clock_ppm();
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
    auto rod = std::make_unique<DeadWeightFrame>(*person_, clock_, executor_, settings);
    rod_ = rod.get();
    frame_ = std::move(rod);
    return {};
  }

  std::shared_ptr<BenchWorld> world_;
  std::unique_ptr<PlantScene> scene_;
  DeadWeightFrame* rod_ = nullptr;
};

// A bench's meter with nothing between its probes.
class BenchMeter final : public LoneMeter {
 public:
  BenchMeter(asio::any_io_executor executor, Clock& clock, TransportPair wire) : ended_(clock) {
    lcr6100::SimConfig config;
    config.corrected = true;
    const auto nothing = [](MonoTime) {
      Electrical stray;
      stray.capacitance_F = 1e-13;
      return stray;
    };
    sim_ = std::make_unique<lcr6100::Lcr6100Sim>(std::move(wire.far), clock, config,
                                                 lcr6100::Lcr6100Sim::Source(nothing));
    meter_ = std::make_unique<lcr6100::Lcr6100>(std::move(wire.near), clock);
    asio::co_spawn(executor, sim_->run(), [this](std::exception_ptr error) {
      runs_ = false;
      ended_.notify_all();
      if (error) std::rethrow_exception(error);
    });
  }
  LcrMeter& meter() override { return *meter_; }
  Task<> close() override {
    meter_->close();
    sim_->close();
    const auto ended = [this] { return !runs_; };
    co_await ended_.wait(ended);
  }

 private:
  bool runs_ = true;
  Condition ended_;  // notified when the simulator ends
  std::unique_ptr<lcr6100::Lcr6100Sim> sim_;
  std::unique_ptr<lcr6100::Lcr6100> meter_;
};

}  // namespace

Result<SimRequest> sim_request(const BenchChoice& choice, const InstrumentsRequest& wanted) {
  SimRequest out(Bench(), wanted);
  out.replay = replay_directory(choice.bench);
  if (out.replay) return out;
  if (auto read = keep(bench_of(choice), out.bench); !read) return fail(read.error());
  if (choice.seed) out.seed = static_cast<std::int64_t>(*choice.seed);
  return out;
}

Result<std::shared_ptr<BenchWorld>> make_world(const SimRequest& request) {
  if (request.replay) return std::shared_ptr<BenchWorld>();
  if (!request.specimen) {
    return fail(Errc::invalid_request, "a simulated bench needs a specimen: --specimen S");
  }
  PlantConfig mounting = request.bench.plant;
  mounting.seed = static_cast<std::uint64_t>(request.seed);
  if (request.weights) mounting.contact_travel_m = 0;
  auto world = BenchWorld::make(*request.specimen, request.bench.fixture.probe_diameter_m,
                                request.bench.error_tolerance, Force::from_si(request.max_force_N),
                                mounting, request.bench.errors, request.bench.rig_seed);
  if (!world) return fail(world.error());
  return std::shared_ptr<BenchWorld>(std::move(*world));
}

Result<std::unique_ptr<Instruments>> make_sim_instruments(asio::any_io_executor executor,
                                                          Clock& clock, const SimRequest& request) {
  if (request.replay) return make_replay_instruments(executor, clock, *request.replay);
  auto bench = std::make_unique<BenchInstruments>(executor, clock);
  if (auto built = bench->build(request); !built) return fail(built.error());
  return std::unique_ptr<Instruments>(std::move(bench));
}

SimulatedRig::SimulatedRig(asio::any_io_executor executor, Clock& clock, std::string bench,
                           KnownRig& known, Operator& person)
    : executor_(std::move(executor)),
      clock_(clock),
      bench_(std::move(bench)),
      known_(known),
      person_(person) {
  for (const Instrument which : {Instrument::lcr, Instrument::frame}) {
    known_.declare(which, "sim", "a simulated rig is built when a run begins", true);
  }
}

void SimulatedRig::failed(const Error& error, LearnedBy by) {
  known_.failed(Instrument::lcr, error, Learned(by));
  known_.failed(Instrument::frame, error, Learned(by));
}

// A simulated instrument has no identity before its specimen is known, so only the files are
// checked.
Task<> SimulatedRig::ask() {
  const auto read = [this]() -> Result<> {
    if (const auto directory = replay_directory(bench_)) {
      const auto recording = load_recording(*directory);
      if (!recording) return fail(recording.error());
    } else if (const auto bench = find_bench(bench_); !bench) {
      return fail(bench.error());
    }
    return {};
  };
  auto good = co_await run_aside(executor_, clock_, read);
  if (!good) {
    failed(good.error(), LearnedBy::look);
    co_return;
  }
  for (const Instrument which : {Instrument::lcr, Instrument::frame}) {
    known_.answered(which, Identity(), Learned(LearnedBy::look));
  }
}

Task<Result<std::unique_ptr<LoneMeter>>> SimulatedRig::open_lone_meter() {
  if (replay_directory(bench_)) {
    co_return fail(Errc::unsupported, "a recording is played here: it has no meter to ask");
  }
  auto wire = wire_for(clock_)(executor_, clock_, "sim:lcr");
  if (!wire) co_return fail(wire.error());
  std::unique_ptr<LoneMeter> out =
      std::make_unique<BenchMeter>(executor_, clock_, std::move(*wire));
  co_return out;
}

Task<Result<std::unique_ptr<Instruments>>> SimulatedRig::open(InstrumentsRequest request) {
  BenchChoice choice;
  choice.bench = bench_;
  auto sim = sim_request(choice, request);
  if (!sim) {
    failed(sim.error(), request.why);
    co_return fail(sim.error());
  }
  sim->person = &person_;
  const auto build = [&sim] { return make_world(*sim); };
  is_computing_ = true;
  auto world = co_await run_aside(executor_, clock_, build);
  is_computing_ = false;
  if (!world) co_return fail(world.error());
  sim->world = std::move(*world);
  auto made = make_sim_instruments(executor_, clock_, *sim);
  if (!made) failed(made.error(), request.why);
  co_return made;
}

}  // namespace lcrig
