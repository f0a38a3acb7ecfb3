// SPDX-License-Identifier: Apache-2.0
// lcrigd: the daemon.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "base/log.hpp"
#include "base/text.hpp"
#include "daemon/app.hpp"
#include "daemon/service.hpp"

namespace {

using namespace lcrig;

constexpr const char* kDefaultConfig = "/etc/lcrig/lcrigd.json";

struct Options {
  std::string config = kDefaultConfig;
  std::string database, socket, log_level;
  bool only_check = false;
};

// Command line over config file.
Result<Config> effective_config(const Options& options) {
  if (!std::filesystem::exists(options.config)) {
    return fail(Errc::invalid_request,
                "{}: there is no config file; copy lcrigd.example.json (share/doc/lcrig/examples) "
                "there and say in it which instruments you have",
                options.config);
  }
  auto config = load_config(options.config);
  if (!config) return config;
  if (!options.database.empty()) config->database = options.database;
  if (!options.socket.empty()) config->socket = options.socket;
  if (!options.log_level.empty()) config->log_level = options.log_level;
  if (!set_up_logging(config->log_level)) {
    return fail(Errc::invalid_request,
                "log level {}: expected trace, debug, info, warn, error or off",
                printable(config->log_level));
  }
  return config;
}

// A signal aborts the run (`finally` runs) and ends the daemon. A second one changes nothing:
// systemd's TimeoutStopSec is what ends a daemon that hangs.
Task<> end_on_signal(asio::io_context& io, App& app) {
  asio::signal_set signals(io, SIGTERM, SIGINT);
  const int number = co_await signals.async_wait(asio::use_awaitable);
  spdlog::info("signal {}: stopping", number);
  const std::string why = number == SIGTERM ? "SIGTERM" : "SIGINT";
  const bool all_ended = co_await app.shut_down(why);
  if (!all_ended) {
    spdlog::warn("ended without the simulated specimen, which is still being reckoned");
    spdlog::shutdown();
    std::_Exit(0);
  }
  io.stop();
}

void abort_on_bug(std::exception_ptr error) {
  if (!error) return;
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& e) {
    spdlog::critical("bug: an exception escaped: {}", e.what());
  }
  std::_Exit(1);
}

std::string summary(const std::string& file, const Config& config) {
  std::string rig = fmt::format("simulated bench {}", config.bench.value_or(""));
  if (!config.bench) {
    const bool weights = config.frame_driver == FrameDriver::dead_weight;
    rig = fmt::format("meter at {}, {}", config.meter_port,
                      weights ? "dead weights" : fmt::format("frame at {}", config.frame_port));
  }
  return fmt::format("{}: in order ({}; database {}; socket {})", file, rig, config.database,
                     config.socket);
}

int serve(const Config& config) {
  if (!lock_memory()) {
    spdlog::info(
        "memory is not locked: when the computer runs short of it a stop may wait for the "
        "disk (allow it with LimitMEMLOCK=infinity, or ulimit -l unlimited)");
  }
  asio::io_context io(1);
  RealClock clock;
  AppParts parts;
  parts.notifier = ServiceNotifier::from_environment();
  App app(io, clock, config, std::move(parts));
  if (auto started = app.start(); !started) {
    spdlog::error("{}", started.error().what);
    return 1;
  }
  asio::co_spawn(io, end_on_signal(io, app), abort_on_bug);
  io.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a client or an instrument that went away is an error code
  Options options;
  CLI::App cli{"lcrigd: runs a characterization rig for capacitive tactile sensors"};
  cli.add_option("--config", options.config, "Config file")->capture_default_str();
  cli.add_option("--db", options.database, "Database file (overrides the config file)");
  cli.add_option("--socket", options.socket, "Control socket (overrides the config file)");
  cli.add_option("--log-level", options.log_level, "trace, debug, info, warn, error, off");
  cli.add_flag("--check-config", options.only_check,
               "Check the config file, say what it means, end");
  cli.set_version_flag("--version", LCRIG_VERSION);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return cli.exit(e) == 0 ? 0 : 2;
  }
  lcrig::set_up_logging("info");
  auto config = effective_config(options);
  if (!config) {
    spdlog::error("{}", config.error().what);
    return 2;
  }
  if (options.only_check) {
    fmt::print("{}\n", summary(options.config, *config));
    return 0;
  }
  return serve(*config);
}
