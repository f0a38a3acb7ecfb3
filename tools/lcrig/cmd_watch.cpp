// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/follow_run.hpp"

namespace lcrig::cli {

namespace {

class WatchCommand final : public Command {
 public:
  WatchCommand() : Command("watch", "Show the run that goes on until it ends", "lcrig watch") {}

  Outcome<ExitCode> run(Context& context) override {
    StopSignals signals;
    auto client = ControlClient::connect(context);
    if (!client) return client.error();
    auto watching = client->call("watch", nlohmann::json::object());
    if (!watching) return watching.error();
    auto status = parse_daemon_status(*watching);
    if (!status) return Failure(status.error());
    FollowOptions options;
    if (status->run) {
      options.run = status->run->run;
    } else {
      fmt::print(context.console.err, "no run goes on; waiting for one (Ctrl-C leaves)\n");
      context.console.err.flush();
    }
    auto end = follow_run(context, *client, signals, options);
    if (!end) return end.error();
    return print_run_end(context, *client, end->run);
  }
};

}  // namespace

const CommandFactory kWatchCommand = make_command<WatchCommand>;

}  // namespace lcrig::cli
