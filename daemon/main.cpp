// SPDX-License-Identifier: Apache-2.0
// lcrigd: the program of the daemon.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>

#include "base/log.hpp"
#include "base/option_completion.hpp"
#include "base/program_version.hpp"
#include "base/spawn.hpp"
#include "base/text.hpp"
#include "base/usage_error.hpp"
#include "daemon/app.hpp"
#include "daemon/config_check.hpp"
#include "daemon/service.hpp"

namespace {

using namespace lcrig;

constexpr const char* kDefaultConfig = "/etc/lcrig/lcrigd.json";

struct Options {
  std::string config = kDefaultConfig;
  std::string database, socket, log_level;
  bool only_check = false;
};

std::optional<std::string> for_shell(const CLI::App& cli, int argc, char** argv) {
  OptionValues json_file, any_file, levels;
  json_file.files = "json";
  any_file.files = "file";
  levels.words.assign(kLogLevels.begin(), kLogLevels.end());
  const std::map<std::string, OptionValues> values{
      {"--config", json_file}, {"--db", any_file}, {"--socket", any_file}, {"--log-level", levels}};
  return completion_of(cli, values, {argv + 1, argv + argc});
}

// Applies options of the command line over the config file.
void override_by(const Options& options, Config& config) {
  const auto one = [&config](const std::string& given, const char* key, std::string& out) {
    if (given.empty()) return;
    out = given;
    config.of_command_line.emplace_back(key);
  };
  one(options.database, "database", config.database);
  one(options.socket, "socket", config.socket);
  one(options.log_level, "log_level", config.log_level);
}

Result<Config> effective_config(const Options& options) {
  // If the status cannot be read, reading the file will report the reason.
  std::error_code unreachable;
  const auto there = std::filesystem::status(options.config, unreachable);
  if (there.type() == std::filesystem::file_type::not_found) {
    return fail(Errc::invalid_request,
                "{}: there is no config file; copy lcrigd.example.json (share/doc/lcrig/examples) "
                "there and say in it which instruments you have",
                options.config);
  }
  auto config = load_config(options.config);
  if (!config) return config;
  override_by(options, *config);
  std::error_code no_folder;  // the folder in which a relative path begins
  const auto database = std::filesystem::absolute(config->database, no_folder);
  if (no_folder) {
    return fail(Errc::invalid_request,
                "{}: `database` is {}, and the folder that it begins in cannot be told ({}); name "
                "the database from / on",
                options.config, config->database, no_folder.message());
  }
  config->database = database;  // clients are told the absolute path
  return config;
}

Result<Config> checked_config(const Options& options) {
  auto config = effective_config(options);
  if (!config) return config;
  if (auto good = check_surroundings(*config, options.config); !good) return fail(good.error());
  return config;
}

// Ends the process without destructors. Saves wire logs and log messages, as far as the disks
// answer.
[[noreturn]] void leave(int code, App& app, std::optional<LogThread>& log) {
  app.save_wire_logs();
  log.reset();
  std::_Exit(code);
}

// A signal aborts the run (`finally` runs) and ends the daemon. A second one changes nothing;
// systemd's TimeoutStopSec ends a daemon that hangs.
Task<> end_on_signal(asio::io_context& io, asio::signal_set& signals, App& app,
                     std::optional<LogThread>& log) {
  const int number = co_await signals.async_wait(asio::use_awaitable);
  spdlog::info("signal {}: stopping", number);
  const std::string why = number == SIGTERM ? "SIGTERM" : "SIGINT";
  const bool all_ended = co_await app.shut_down(why);
  if (!all_ended) {
    spdlog::warn("ended without the simulated specimen, which is still being computed");
    leave(0, app, log);
  }
  io.stop();
}

// SIGHUP normally ends a program whose terminal closes. The daemon has no terminal, so the signal
// means: read the config file again.
Task<> reload_on_hangup(asio::signal_set& hangups, App& app) {
  for (;;) {
    co_await hangups.async_wait(asio::use_awaitable);
    spdlog::info("signal {}: the config file is read again", SIGHUP);
    co_await app.config_taker().reload();
  }
}

// Prints an error as `lcrig` does: what is wrong, the line of the file, and what to type next.
void tell(const Error& error, const Options& options) {
  spdlog::error("{}", error.what);
  if (!error.detail.empty()) fmt::print(stderr, "{}\n", error.detail);
  fmt::print(stderr, "  next: correct it, then lcrigd --check-config --config {}\n",
             options.config);
}

void make_frame_safe(asio::io_context& io, App& app) {
  bool over = false;
  asio::co_spawn(io, app.rig_watch().stop_first(), [&over](std::exception_ptr bug) {
    if (bug) std::rethrow_exception(bug);
    over = true;
  });
  while (!over && io.run_one() > 0) {
  }
  io.restart();
}

int serve(const Options& options, const Config& config) {
  if (!lock_memory()) {
    spdlog::info(
        "memory is not locked: when the computer runs short of it a stop may wait for the "
        "disk (allow it with LimitMEMLOCK=infinity, or ulimit -l unlimited)");
  }
  std::optional<LogThread> log(std::in_place);
  asio::io_context io(1);
  // Set up before a database is open: from here on the loop handles these signals, and they no
  // longer kill the process.
  asio::signal_set signals(io, SIGTERM, SIGINT), hangups(io, SIGHUP);
  RealClock clock;
  AppParts parts;
  parts.notifier = ServiceNotifier::from_environment();
  parts.load_config = [options] { return checked_config(options); };
  App app(io, clock, config, std::move(parts));
  if (app.rig_watch().may_be_left()) make_frame_safe(io, app);
  if (auto good = check_surroundings(config, options.config); !good) {
    log.reset();
    tell(good.error(), options);
    return 2;
  }
  // The unit restarts lcrigd after status 1, but not after 2. `busy` may mean the previous daemon,
  // which is about to end. Any other error would come again after a second.
  if (auto started = app.start(); !started) {
    spdlog::error("{}", started.error().what);
    return started.error().code == Errc::busy ? 1 : 2;
  }
  spawn(io.get_executor(), end_on_signal(io, signals, app, log));
  spawn(io.get_executor(), reload_on_hangup(hangups, app));
  try {
    io.run();
  } catch (const std::exception& e) {
    spdlog::critical("bug: an exception escaped: {}", e.what());
    leave(1, app, log);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGHUP, SIG_IGN);  // until the loop handles it; the file is read at the start anyway
  std::signal(SIGPIPE, SIG_IGN);  // writing to a client or instrument that is gone returns an error
                                  // code
  Options options;
  CLI::App cli{"lcrigd: runs a characterization rig for capacitive tactile sensors", "lcrigd"};
  cli.add_option("--config", options.config, "Config file")->capture_default_str();
  cli.add_option("--db", options.database, "Database file (overrides the config file)");
  cli.add_option("--socket", options.socket, "Control socket (overrides the config file)");
  cli.add_option("--log-level", options.log_level, kLogLevelWords);
  cli.add_flag("--check-config", options.only_check,
               "Check the config file, say what it means, end");
  cli.set_version_flag("--version", std::string(program_version()));
  if (const auto answer = for_shell(cli, argc, argv)) {
    std::cout << *answer;
    return end_of_output(cli);
  }
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return answer_parse(cli, e);
  }
  lcrig::set_up_logging("info");
  const auto config = effective_config(options);
  if (!config) {
    tell(config.error(), options);
    return 2;
  }
  if (!set_up_logging(config->log_level)) {
    tell(Error(Errc::invalid_request,
               fmt::format("log level {}: expected trace, debug, info, warn, error or off",
                           printable(config->log_level))),
         options);
    return 2;
  }
  for (const auto& warning : config_warnings(*config, options.config)) spdlog::warn("{}", warning);
  if (options.only_check) {
    if (auto good = check_surroundings(*config, options.config); !good) {
      tell(good.error(), options);
      return 2;
    }
    std::cout << fmt::format("{}: in order\n{}", options.config, config_summary(*config));
    return end_of_output(cli);
  }
  return serve(options, *config);
}
