// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class MetricsCommand final : public Command {
 public:
  MetricsCommand() : Command("metrics", "The daemon's health, for Prometheus", "lcrig metrics") {}
  Outcome<ExitCode> run(Context& context) override {
    auto client = ControlClient::connect_for_any_database(context);
    if (!client) return client.error();
    auto answer = client->call("metrics", json::object());
    if (!answer) return answer.error();
    return show(context, *answer,
                [&](std::ostream& out) { out << answer->value("text", std::string()); });
  }
};

}  // namespace

const CommandFactory kMetricsCommand = make_command<MetricsCommand>;

}  // namespace lcrig::cli
