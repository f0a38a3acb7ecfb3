// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/number.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class ResumeCommand final : public Command {
 public:
  ResumeCommand()
      : Command("resume", "Go on after a pause, or with an interrupted run", "lcrig resume") {}
  void declare(ArgumentList& list) override {
    list.positional(kRunWord, run_, "An interrupted run (default: the one that a crash left)",
                    false);
    list.flag("--confirm-specimen", confirmed_,
              "With RUN: I looked, the specimen was not touched since");
  }

  Outcome<ExitCode> run(Context& context) override {
    auto which = named(context.global);
    if (!which) return which.error();
    auto client = ControlClient::connect(context);
    if (!client) return client.error();
    std::string words = "run " + run_;
    if (!*which) {
      auto offered = offer(*client, context.global);
      if (!offered) return offered.error();
      if (*offered) {
        *which = (*offered)->run;
        words = words_of(**offered);
      }
    }
    json params = json::object();
    if (*which) params["run"] = **which;
    if (confirmed_) params["confirm_specimen"] = true;
    auto answer = client->call("run.resume", params, std::chrono::seconds(90));
    if (!answer) return answer.error();
    const auto going = answer->value("run", std::int64_t{0});
    return show(context, *answer, [&](std::ostream& out) {
      if (!*which || going == **which) {
        fmt::print(out, "goes on\n");
        return;
      }
      fmt::print(out, "run {} continues {}\n", going, words);
      if (confirmed_) return;
      context.console.next("look at the specimen, then: " +
                           next_command(context.global, {"confirm"}));
    });
  }

 private:
  // The number that was typed; nullopt: none was.
  Outcome<std::optional<std::int64_t>> named(const GlobalOptions& global) const {
    if (run_.empty() && confirmed_) {
      return Failure(kUsage, "--confirm-specimen is about an interrupted run: RUN is missing",
                     next_command(global, {"runs"}, "then lcrig resume RUN --confirm-specimen"));
    }
    if (run_.empty()) return std::optional<std::int64_t>();
    const auto number = number_from<std::int64_t>(run_);
    if (number && *number >= 1) return number;
    return Failure(kUsage, fmt::format("RUN '{}' is not the number of a run", run_),
                   next_command(global, {"runs"}));
  }

  // The run that may be continued without being named. nullopt: a run is going on, possibly paused.
  // Nothing moves before a person has confirmed the specimen.
  static Outcome<std::optional<ResumableRun>> offer(ControlClient& client,
                                                    const GlobalOptions& global) {
    auto answer = client.call("status", json::object());
    if (!answer) return answer.error();
    const auto status = parse_daemon_status(*answer);
    if (!status) return Failure(status.error());
    if (status->run) return std::optional<ResumableRun>();
    const auto& found = status->resumable;
    if (found.size() == 1) return std::optional(found.front());
    if (found.empty()) {
      return Failure(kFailed,
                     "no run is paused, and none that was interrupted since the last one that was "
                     "carried out has steps left",
                     next_command(global, {"runs"},
                                  "then lcrig resume RUN, for one that was interrupted before"));
    }
    Failure several(kFailed, "several runs were interrupted: say which one is to go on",
                    next_command(global, {"resume", std::to_string(found.back().run)}));
    for (const auto& run : found) several.detail += words_of(run) + "\n";
    return several;
  }

  std::string run_;
  bool confirmed_ = false;
};

}  // namespace

const CommandFactory kResumeCommand = make_command<ResumeCommand>;

}  // namespace lcrig::cli
