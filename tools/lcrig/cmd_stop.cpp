// SPDX-License-Identifier: Apache-2.0
// pause, resume, abort, freeze, confirm: one call each.
#include <fmt/ostream.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

struct Verb {
  const char* name;
  const char* method;
  const char* summary;
  const char* example;
  const char* done;
  bool takes_why;
  bool takes_run;
};

constexpr Verb kPause{"pause",
                      "run.pause",
                      "Hold travel now and keep recording",
                      "lcrig pause",
                      "paused; lcrig resume goes on",
                      false,
                      false};
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
                      true,
                      false};
constexpr Verb kFreeze{"freeze",
                       "run.freeze",
                       "Stop now and stay where it is",
                       "lcrig freeze",
                       "stopped; the frame stays where it is",
                       true,
                       false};
constexpr Verb kConfirm{"confirm",
                        "run.confirm",
                        "Tell the run that what it asked for is done",
                        "lcrig confirm",
                        "confirmed",
                        false,
                        false};

class VerbCommand final : public Command {
 public:
  explicit VerbCommand(const Verb& verb) : verb_(verb) {}
  const char* name() const override { return verb_.name; }
  const char* summary() const override { return verb_.summary; }
  const char* example() const override { return verb_.example; }
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

Outcome<json> VerbCommand::params() const {
  json out = json::object();
  if (!why_.empty()) out["why"] = why_;
  if (confirmed_) out["confirm_specimen"] = true;
  if (run_.empty() && confirmed_) {
    return tl::unexpected(Failure(kUsage,
                                  "--confirm-specimen is about an interrupted run: RUN is missing",
                                  "lcrig runs   (then lcrig resume RUN --confirm-specimen)"));
  }
  if (run_.empty()) return out;
  std::int64_t number = 0;
  const auto* end = run_.data() + run_.size();
  const auto r = std::from_chars(run_.data(), end, number);
  if (r.ec != std::errc() || r.ptr != end || number < 1) {
    return tl::unexpected(
        Failure(kUsage, fmt::format("RUN '{}' is not the number of a run", run_), "lcrig runs"));
  }
  out["run"] = number;
  return out;
}

Outcome<ExitCode> VerbCommand::run(Context& context) {
  auto wanted = params();
  if (!wanted) return tl::unexpected(wanted.error());
  auto socket = context.socket_path();
  if (!socket) return tl::unexpected(socket.error());
  auto client = ControlClient::connect(*socket, context.clock);
  if (!client) return tl::unexpected(client.error());
  constexpr auto kPatience = std::chrono::seconds(90);  // the frame confirms standstill first
  auto answer = client->call(verb_.method, *wanted, kPatience);
  if (!answer) return tl::unexpected(answer.error());
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

std::unique_ptr<Command> make_pause_command() {
  return std::make_unique<VerbCommand>(kPause);
}
std::unique_ptr<Command> make_resume_command() {
  return std::make_unique<VerbCommand>(kResume);
}
std::unique_ptr<Command> make_abort_command() {
  return std::make_unique<VerbCommand>(kAbort);
}
std::unique_ptr<Command> make_freeze_command() {
  return std::make_unique<VerbCommand>(kFreeze);
}
std::unique_ptr<Command> make_confirm_command() {
  return std::make_unique<VerbCommand>(kConfirm);
}

}  // namespace lcrig::cli
