// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/follow_run.hpp"

namespace lcrig::cli {

namespace {

class WatchCommand final : public Command {
 public:
  const char* name() const override { return "watch"; }
  const char* summary() const override { return "Show the run that goes on until it ends"; }
  const char* example() const override { return "lcrig watch"; }
  Outcome<ExitCode> run(Context& context) override;
};

Outcome<ExitCode> WatchCommand::run(Context& context) {
  auto socket = context.socket_path();
  if (!socket) return tl::unexpected(socket.error());
  StopSignals signals;
  auto client = ControlClient::connect(*socket, context.clock);
  if (!client) return tl::unexpected(client.error());
  auto watching = client->call("watch", nlohmann::json::object());
  if (!watching) return tl::unexpected(watching.error());
  auto status = parse_daemon_status(*watching);
  if (!status) return tl::unexpected(Failure(status.error()));
  FollowOptions options;
  if (status->run) {
    options.run = status->run->run;
  } else {
    fmt::print(context.console.err, "no run goes on; waiting for one (Ctrl-C leaves)\n");
    context.console.err.flush();
  }
  auto end = follow_run(context, *client, signals, options);
  if (!end) return tl::unexpected(end.error());
  return print_run_end(context, end->run);
}

}  // namespace

std::unique_ptr<Command> make_watch_command() {
  return std::make_unique<WatchCommand>();
}

}  // namespace lcrig::cli
