// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/live_line.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

void print_status(std::ostream& out, const DaemonStatus& s) {
  fmt::print(out, "lcrigd {}  database {}\n", printable(s.version, kLongestName),
             printable(s.database, kLongestWords));
  for (const auto& i : s.instruments) {
    fmt::print(out, "{:6} {:8} {}  {}\n", printable(i.name, kLongestName),
               printable(i.state, kLongestWords), printable(i.port, kLongestWords),
               printable(i.identity, kLongestWords));
  }
  if (s.run) {
    fmt::print(out, "run {}  {} on {}  {}\n", s.run->run, printable(s.run->protocol, kLongestName),
               printable(s.run->specimen, kLongestName), state_word(s.run->state));
    fmt::print(out, "{}\n", format_plain_line(*s.run));
    if (!s.run->prompt.empty())
      fmt::print(out, "waits for: {}\n", printable(s.run->prompt, kLongestWords));
    return;
  }
  fmt::print(out, "no run goes on\n");
  if (!s.last_run) return;
  const auto& last = *s.last_run;
  fmt::print(out, "last: run {} {} {}\n", last.run, to_string(last.exit_status),
             printable(last.reason, kLongestWords));
}

class StatusCommand final : public Command {
 public:
  const char* name() const override { return "status"; }
  const char* summary() const override { return "What the rig is doing"; }
  const char* example() const override { return "lcrig status --ask"; }
  void declare(ArgumentList& list) override {
    list.flag("--ask", ask_, "Ask both instruments who they are; nothing at the frame changes");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto socket = context.socket_path();
    if (!socket) return tl::unexpected(socket.error());
    auto client = ControlClient::connect(*socket, context.clock);
    if (!client) return tl::unexpected(client.error());
    constexpr auto kPatience = std::chrono::minutes(1);
    auto answer = client->call(ask_ ? "instruments.ask" : "status", json::object(), kPatience);
    if (!answer) return tl::unexpected(answer.error());
    if (context.global.json) {
      print_json(context.console.out, *answer);
      return kOk;
    }
    auto status = parse_daemon_status(*answer);
    if (!status) return tl::unexpected(Failure(status.error()));
    print_status(context.console.out, *status);
    return kOk;
  }

 private:
  bool ask_ = false;
};

}  // namespace

std::unique_ptr<Command> make_status_command() {
  return std::make_unique<StatusCommand>();
}

}  // namespace lcrig::cli
