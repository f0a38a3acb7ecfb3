// SPDX-License-Identifier: Apache-2.0
// pause, resume, abort, freeze, confirm: one call each.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

struct Verb {
  const char *name, *method, *summary, *example, *done;
  bool takes_why = false, takes_run = false;
};

constexpr Verb kPause{"pause", "run.pause", "Hold travel now and keep recording", "lcrig pause",
                      "paused; lcrig resume goes on"};
constexpr Verb kResume{"resume",
                       "run.resume",
                       "Go on after a pause, or with an interrupted run",
                       "lcrig resume",
                       "goes on",
                       false,
                       true};
constexpr Verb kAbort{"abort",
                      "run.abort",
                      "Stop now, then unload (`finally`)",
                      "lcrig abort --why \"wrong specimen\"",
                      "stopped",
                      true};
constexpr Verb kFreeze{"freeze",
                       "run.freeze",
                       "Stop now and stay where it is",
                       "lcrig freeze",
                       "stopped; the frame stays where it is",
                       true};
constexpr Verb kConfirm{"confirm", "run.confirm", "Tell the run that what it asked for is done",
                        "lcrig confirm", "confirmed"};

class VerbCommand final : public Command {
 public:
  explicit VerbCommand(const Verb& verb)
      : Command(verb.name, verb.summary, verb.example), verb_(verb) {}
  void declare(ArgumentList& list) override {
    if (verb_.takes_why) list.option("--why", why_, "TEXT", "Stored with the run");
    if (!verb_.takes_run) return;
    list.positional("RUN", run_, "An interrupted run's number", false);
    list.flag("--confirm-specimen", confirmed_, "I looked: the specimen was not touched since");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<json> params() const;
  const Verb& verb_;
  std::string why_, run_;
  bool confirmed_ = false;
};

template <const Verb& verb>
std::unique_ptr<Command> make_verb() {
  return std::make_unique<VerbCommand>(verb);
}

Outcome<json> VerbCommand::params() const {
  json out = json::object();
  if (!why_.empty()) out["why"] = why_;
  if (confirmed_) out["confirm_specimen"] = true;
  if (run_.empty() && confirmed_) {
    return Failure(kUsage, "--confirm-specimen is about an interrupted run: RUN is missing",
                   "lcrig runs   (then lcrig resume RUN --confirm-specimen)");
  }
  if (run_.empty()) return out;
  const auto number = number_from<std::int64_t>(run_);
  if (!number || *number < 1) {
    return Failure(kUsage, fmt::format("RUN '{}' is not the number of a run", run_), "lcrig runs");
  }
  out["run"] = *number;
  return out;
}

Outcome<ExitCode> VerbCommand::run(Context& context) {
  auto wanted = params();
  if (!wanted) return wanted.error();
  auto client = ControlClient::connect(context);
  if (!client) return client.error();
  constexpr auto kPatience = std::chrono::seconds(90);  // the frame confirms standstill first
  auto answer = client->call(verb_.method, *wanted, kPatience);
  if (!answer) return answer.error();
  if (context.global.json) {
    print_json(context.console.out, *answer);
  } else if (!run_.empty() && answer->value("run", std::int64_t{0}) != wanted->value("run", 0)) {
    fmt::print(context.console.out, "run {} continues run {}\n", answer->value("run", 0), run_);
    if (!confirmed_) {
      fmt::print(context.console.err, "  next: look at the specimen, then lcrig confirm\n");
    }
  } else {
    // A stop says itself what became of it.
    const std::string note = answer->value("note", std::string());
    fmt::print(context.console.out, "{}\n", note.empty() ? verb_.done : printable(note));
  }
  return kOk;
}

}  // namespace

const CommandFactory kPauseCommand = make_verb<kPause>;
const CommandFactory kResumeCommand = make_verb<kResume>;
const CommandFactory kAbortCommand = make_verb<kAbort>;
const CommandFactory kFreezeCommand = make_verb<kFreeze>;
const CommandFactory kConfirmCommand = make_verb<kConfirm>;

}  // namespace lcrig::cli
