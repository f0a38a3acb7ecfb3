// SPDX-License-Identifier: Apache-2.0
#include <exception>
#include <iostream>

#include "base/clock.hpp"
#include "base/log.hpp"
#include "tools/lcrig/command.hpp"

int main(int argc, char** argv) {
  using namespace lcrig;
  try {
    set_up_logging("warn");
    const auto env = cli::real_process_env();
    auto console = cli::real_console(env);
    const RealClock clock;
    const cli::DaemonParts daemon{.rehearse = &rehearse,
                                  .rehearse_batch = &rehearse_batch,
                                  .bench_rig = &bench_rig,
                                  .config = &look_at_config_file};
    cli::Context context(console, env, clock, daemon);
    return cli::run_cli(std::vector<std::string>(argv + 1, argv + argc), context);
  } catch (const std::exception& e) {
    std::cerr << "lcrig: a fault of this program: " << e.what() << '\n';
    return cli::kFailed;
  }
}
