// SPDX-License-Identifier: Apache-2.0
// lcrig-sim: the simulated bench as a separate process, in real time (docs/simulator.md).
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <csignal>
#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/doc_page.hpp"
#include "base/log.hpp"
#include "base/option_completion.hpp"
#include "base/program_version.hpp"
#include "base/text.hpp"
#include "base/usage_error.hpp"
#include "base/whole_file.hpp"
#include "daemon/rig/bench.hpp"
#include "drivers/faults/player.hpp"
#include "drivers/zwick/codec.hpp"
#include "model/bench_world.hpp"
#include "model/specimen_file.hpp"
#include "tools/lcrig-sim/back_door.hpp"
#include "tools/lcrig-sim/fault_bench.hpp"
#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::sim {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

// How an earlier file of this program begins. Only such a file is replaced.
constexpr const char* kReadyBegin = R"({"control":)";
constexpr const char* kToldBegin = R"({"fixture":{"probe_diameter_mm":)";

struct Options {
  std::string bench = "paper", specimen = "paper-1", log_level = "info";
  std::string lcr_link, lcr_identity, ready_file, control, faults;
  std::string rig, told;
  std::uint16_t frame_port = 0;
  std::uint64_t seed = 1;
  double max_force_N = 5;
  bool frame_pty = false, weights = false, realistic = false;
};

Result<Specimen> find_specimen(const std::string& what) {
  if (names_a_file(what)) return load_specimen(what);
  std::string names;
  for (const ShippedSpecimen& s : shipped_specimens()) {
    if (s.name == what) return parse_specimen(s.text, what);
    names += (names.empty() ? "" : ", ") + std::string(s.name);
  }
  return fail(Errc::invalid_request, "no specimen `{}`; shipped: {}, or give a file", what, names);
}

// Everything on the bench. Must live until its tasks have ended.
class SimBench {
 public:
  SimBench(asio::io_context& io, Clock& clock, Options options)
      : io_(io), clock_(clock), options_(std::move(options)) {}

  Result<> start() {
    if (auto ok = require_earlier_output(options_.told, kToldBegin); !ok) return ok;
    if (auto ok = require_earlier_output(options_.ready_file, kReadyBegin); !ok) return ok;
    if (auto built = build(); !built) return built;
    if (auto plugged = meter_->plug(); !plugged) return plugged;
    if (frame_) {
      auto open = options_.frame_pty ? frame_->open_pty() : frame_->listen(options_.frame_port);
      if (!open) return open;
    }
    Bench bench{clock_, plant(), *meter_, frame_.get()};
    door_ = std::make_unique<BackDoor>(io_.get_executor(), tasks_, bench);
    if (!options_.control.empty()) {
      if (auto open = door_->listen(options_.control); !open) return open;
    }
    if (auto ready = prepare_faults(); !ready) return ready;
    if (auto told = announce(); !told) return told;
    if (player_) player_->begin();
    if (world_) tasks_.start(watch_model_end());
    return {};
  }

  Task<> close() {
    closes_ = true;
    if (player_) player_->stop();
    meter_->unplug();
    if (frame_) frame_->unplug();
    door_->close();
    const MonoTime limit = clock_.now() + 1s;
    co_await tasks_.all_ended(limit);
    if (player_) co_await player_->ended(limit);
  }

 private:
  // Warns when the specimen's force exceeds its table, because the model has no answer there. Each
  // time that happens, it tells the log and the client of the frame.
  Task<> watch_model_end() {
    const double solved_N = world_->response().max_force_N();
    bool is_beyond = false;
    while (!closes_) {
      const double peak_N = plant().peak_answered_N(clock_.now());
      if (peak_N > solved_N * (1 + 1e-6) && !std::exchange(is_beyond, true)) {
        say_beyond(peak_N, solved_N);
      }
      plant().forget_peak();
      is_beyond = plant().peak_answered_N(clock_.now()) > solved_N * (1 + 1e-6);
      co_await clock_.wait_for(100ms);
    }
  }

  void say_beyond(double peak_N, double solved_N) {
    const std::string text = fmt::format(
        "the bench goes to {:.4g} N and more, but its specimen is computed up to {:.4g} N only: "
        "from there on thickness and capacitance follow a straight line{}",
        peak_N, solved_N,
        solved_N < options_.max_force_N ? "" : "; --max-force-N says how far it is computed");
    spdlog::warn("{}", text);
    ZwickSim* gateway = frame_ ? frame_->gateway() : nullptr;
    if (gateway == nullptr) return;
    gateway->faults.say = frame_link::format_event("extrapolated", text);
    gateway->poke();
  }

  Result<> prepare_faults() {
    if (options_.faults.empty()) return {};
    auto script = load_fault_script(options_.faults);
    if (!script) return fail(script.error());
    const FaultStage stage{
        .has_frame = frame_ != nullptr, .knows_steps = false, .has_surroundings = false};
    if (auto fits = check_stage(*script, stage); !fits) return fits;
    ports_ = std::make_unique<PortBench>(*meter_, frame_.get());
    const auto logged_already = [](MonoTime, const std::string&) {};
    player_ = std::make_unique<FaultPlayer>(io_.get_executor(), clock_, *ports_, nullptr,
                                            std::move(*script), logged_already);
    return {};
  }

  // Builds a random machine and specimen, and what a config file says about them.
  Result<> build_random() {
    if (auto r = keep(parse_rig(options_.rig), rig_); !r) return fail(r.error());
    spdlog::info("{}", describe(*rig_));
    if (!options_.told.empty()) {
      if (auto told = write_whole_file(options_.told, told_json(*rig_) + "\n"); !told) return told;
    }
    rig_specimen_ = std::make_unique<CurvedSpecimen>(rig_->specimen());
    rig_plant_ = std::make_unique<Plant>(*rig_specimen_, rig_->plant);
    build_instruments(rig_->frame);
    return {};
  }
  Plant& plant() { return rig_plant_ ? *rig_plant_ : world_->plant(); }

  Result<> build() {
    if (!options_.rig.empty()) return build_random();
    auto bench = find_bench(options_.bench);
    if (!bench) return fail(bench.error());
    auto specimen = find_specimen(options_.specimen);
    if (!specimen) return fail(specimen.error());
    PlantConfig mounting = bench->plant;
    mounting.seed = options_.seed;
    if (options_.weights) mounting.contact_travel_m = 0;
    auto world =
        BenchWorld::make(*specimen, bench->fixture.probe_diameter_m, bench->error_tolerance,
                         Force::from_si(options_.max_force_N), mounting,
                         options_.realistic ? ErrorScope::everything : bench->errors);
    if (!world) return fail(world.error());
    world_ = std::move(*world);
    ZwickSimSettings frame;
    frame.seed = options_.seed + 1;
    frame.rate_max_Hz = bench->frame_rate_max_Hz;
    if (const auto& errors = world_->errors()) {
      spdlog::info("drawn: {}", errors->to_json().dump());
      frame.device_clock_ppm = errors->clock_ppm();
    }
    build_instruments(frame);
    return {};
  }

  void build_instruments(const ZwickSimSettings& frame) {
    const PlantConfig& mounting = plant().config();
    lcr6100::SimConfig meter;
    meter.conversion_s = mounting.conversion_s;
    meter.capacitance_noise_F = mounting.capacitance_noise_F;
    meter.gain_error = mounting.meter_gain_error;
    meter.offset_error = mounting.meter_offset_error;
    meter.seed = options_.seed;
    if (!options_.lcr_identity.empty()) meter.identity = options_.lcr_identity;
    const auto source = [this](MonoTime t) {
      return world_ ? world_->electrical(t) : rig_plant_->electrical(t);
    };
    meter_ = std::make_unique<MeterPort>(io_.get_executor(), clock_, tasks_, meter, source,
                                         options_.lcr_link);
    if (options_.weights) return;
    scene_ = std::make_unique<PlantScene>(plant());
    frame_ = std::make_unique<FramePort>(io_.get_executor(), clock_, tasks_, *scene_, frame);
  }

  Result<> announce() const {
    json ready{{"lcr", meter_->url()}, {"frame", nullptr}, {"control", nullptr}};
    if (frame_) ready["frame"] = frame_->url();
    if (!options_.control.empty()) ready["control"] = options_.control;
    const std::string line = ready.dump() + "\n";
    std::cout << line << std::flush;
    if (options_.ready_file.empty()) return {};
    return write_whole_file(options_.ready_file, line);
  }

  asio::io_context& io_;
  Clock& clock_;
  Tasks tasks_{io_.get_executor(), clock_};
  Options options_;
  std::unique_ptr<BenchWorld> world_;
  std::optional<RandomRig> rig_;  // used instead of world_
  std::unique_ptr<CurvedSpecimen> rig_specimen_;
  std::unique_ptr<Plant> rig_plant_;
  std::unique_ptr<PlantScene> scene_;
  std::unique_ptr<MeterPort> meter_;
  std::unique_ptr<FramePort> frame_;
  std::unique_ptr<BackDoor> door_;
  std::unique_ptr<PortBench> ports_;
  std::unique_ptr<FaultPlayer> player_;
  bool closes_ = false;
};

Task<> end_on_signal(asio::io_context& io, asio::signal_set& signals, SimBench& bench) {
  const int number = co_await signals.async_wait(asio::use_awaitable);
  spdlog::debug("signal {}", number);
  co_await bench.close();
  io.stop();
}

int serve(Options options) {
  RealClock clock;
  asio::io_context io(1);
  // Set up before the line is printed that says where it listens, because a reader of that line may
  // send a signal at once.
  asio::signal_set signals(io, SIGTERM, SIGINT);
  SimBench bench(io, clock, std::move(options));
  if (auto started = bench.start(); !started) {
    spdlog::error("{}", started.error().what);
    return started.error().code == Errc::invalid_request ? 2 : 1;
  }
  asio::co_spawn(io, end_on_signal(io, signals, bench), [](std::exception_ptr error) {
    if (error) std::rethrow_exception(error);
  });
  io.run();
  return 0;
}

void declare(CLI::App& cli, Options& o) {
  auto* bench =
      cli.add_option("--bench", o.bench, "Name or file of the bench")->capture_default_str();
  auto* specimen = cli.add_option("--specimen", o.specimen, "Name or file of the specimen")
                       ->capture_default_str();
  cli.add_option("--max-force-N", o.max_force_N, "Largest force that the specimen is tabulated for")
      ->check(CLI::Range(0.001, 1e4))
      ->capture_default_str();
  cli.add_option("--seed", o.seed, "Of all noise")
      ->check(CLI::NonNegativeNumber)  // otherwise CLI11 would accept -1 as 2^64 - 1
      ->capture_default_str();
  auto* realistic = cli.add_flag("--realistic", o.realistic, "Let the bench err as real ones do");
  cli.add_option("--lcr-link", o.lcr_link, "Symbolic link to the meter's pty");
  cli.add_option("--lcr-identity", o.lcr_identity, "What the meter answers to *IDN?");
  auto* port = cli.add_option("--frame-port", o.frame_port, "TCP port on 127.0.0.1 (0: any)")
                   ->check(CLI::Range(0, 65535));
  auto* pty = cli.add_flag("--frame-pty", o.frame_pty, "Frame link on a pty instead of TCP");
  port->excludes(pty);
  auto* weights =
      cli.add_flag("--weights", o.weights, "Dead weights on a rod, no frame; `load` on --control")
          ->excludes(port)
          ->excludes(pty);
  auto* rig =
      cli.add_option("--rig", o.rig, "random:SEED: a machine and a specimen that nobody built")
          ->excludes(bench)
          ->excludes(specimen)
          ->excludes(weights)
          ->excludes(realistic);
  cli.add_option("--told", o.told, "Gets what a config and a specimen file would say of --rig")
      ->needs(rig);
  cli.add_option("--control", o.control, "Unix socket for faults (" + doc_page("simulator") + ")");
  cli.add_option("--faults", o.faults,
                 "Let things go wrong as this script says (" + doc_page("faults") + ")");
  cli.add_option("--ready-file", o.ready_file, "Gets the line of standard output");
  cli.add_option("--log-level", o.log_level, kLogLevelWords)
      ->check(CLI::IsMember(std::vector<std::string>(kLogLevels.begin(), kLogLevels.end())));
  cli.set_version_flag("--version", std::string(program_version()));
  cli.footer("Example: lcrig-sim --specimen paper-1 --lcr-link /tmp/lcr --frame-port 4710");
}

std::optional<std::string> for_shell(const CLI::App& cli, int argc, char** argv) {
  OptionValues bench, specimen, json_file, any_file, levels, rigs;
  bench.files = specimen.files = json_file.files = "json";
  any_file.files = "file";
  for (const auto& one : shipped_benches()) bench.words.emplace_back(one.name);
  for (const auto& one : shipped_specimens()) specimen.words.emplace_back(one.name);
  levels.words.assign(kLogLevels.begin(), kLogLevels.end());
  rigs.words = {"random:"};
  const std::map<std::string, OptionValues> values{
      {"--bench", bench},      {"--specimen", specimen}, {"--faults", json_file},
      {"--log-level", levels}, {"--rig", rigs},          {"--lcr-link", any_file},
      {"--told", any_file},    {"--control", any_file},  {"--ready-file", any_file}};
  return completion_of(cli, values, {argv + 1, argv + argc});
}

}  // namespace
}  // namespace lcrig::sim

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a client that went away is reported as an error code instead
  lcrig::sim::Options options;
  CLI::App cli{"lcrig-sim: the simulated meter and load frame on a pty and TCP, in real time",
               "lcrig-sim"};
  lcrig::sim::declare(cli, options);
  if (const auto answer = lcrig::sim::for_shell(cli, argc, argv)) {
    std::cout << *answer;
    return lcrig::end_of_output(cli);
  }
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return lcrig::answer_parse(cli, e);
  }
  lcrig::set_up_logging(options.log_level);
  return lcrig::sim::serve(std::move(options));
}
