// SPDX-License-Identifier: Apache-2.0
// Runs the lcrig command line inside the test process: arguments in, exit code and both outputs
// back. For the unit tests of tools/.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "daemon/control/config_view.hpp"
#include "daemon/rehearse.hpp"
#include "daemon/rehearse_batch.hpp"
#include "protocols/plan/check.hpp"
#include "tests/support/temp_dir.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::support {

// A `rehearse` that records the request and gives the answer that a test sets.
struct FakeRehearsal {
  static inline RehearseRequest last;
  static inline Result<RehearseResult> answer = RehearseResult();
  static Result<RehearseResult> run(const RehearseRequest& request) {
    last = request;
    RunStatus status;
    status.run = 1;
    status.state = RunState::running;
    status.step_id = "load";
    if (request.progress) request.progress(status);
    return answer;
  }
};

class Cli {
 public:
  Cli() {
    env.variable = [this](const char* name) -> std::optional<std::string> {
      const auto it = variables.find(name);
      if (it == variables.end() || it->second.empty()) return std::nullopt;
      return it->second;
    };
    env.executable = dir.file("nowhere/bin/lcrig");
    env.daemon_db = dir.file("no-daemon.db");
    env.daemon_config = dir.file("no-daemon.json");
    env.daemon_socket = dir.file("no-daemon.sock");
    variables["HOME"] = dir.file("home");
  }

  int run(const std::vector<std::string>& args) {
    out.str("");
    err.str("");
    cli::Console console(out, err);
    console.err_tty = tty;
    console.in_tty = tty;
    console.color = tty && !variables.contains("NO_COLOR");
    console.width = [] { return 80; };
    console.enter = [this] { return typed; };
    cli::DaemonParts daemon;
    daemon.rehearse = rehearsal;
    daemon.bench_rig = bench_rig;
    daemon.config = &look_at_config_file;
    daemon.rehearse_batch = day;
    cli::Context context(console, env, clock, daemon);
    return cli::run_cli(args, context);
  }
  // Adds a file to the library of protocols and specimens, and points $LCRIG_DATA to it.
  void add_data(const std::string& name, const std::string& text) {
    const auto path = std::filesystem::path(dir.file("data")) / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
    variables["LCRIG_DATA"] = dir.file("data");
  }

  TempDir dir;
  std::map<std::string, std::string> variables;
  cli::ProcessEnv env;
  RealClock clock;
  std::ostringstream out, err;
  bool tty = false;
  std::optional<std::string> typed;  // what the person types before Enter; nullopt: nobody is there
  Result<RehearseResult> (*rehearsal)(const RehearseRequest&) = &FakeRehearsal::run;
  Result<Rig> (*bench_rig)(const BenchRequest&) = nullptr;
  Result<RehearseBatchResult> (*day)(const RehearseBatchRequest&) = nullptr;
};

}  // namespace lcrig::support
