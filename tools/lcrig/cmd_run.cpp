// SPDX-License-Identifier: Apache-2.0
// run, watch.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "tools/lcrig/cmd_watch.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/follow_run.hpp"
#include "tools/lcrig/plan_text.hpp"
#include "tools/lcrig/protocol_request.hpp"
#include "tools/lcrig/queue_request.hpp"
#include "tools/lcrig/queue_words.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

class RunCommand final : public Command {
 public:
  RunCommand()
      : Command("run", "Run a protocol on the rig and record it",
                "lcrig run dynamic-cycles -p cycles=5 --specimen paper-1") {}
  void declare(ArgumentList& list) override {
    list.positional(kProtocolWord, protocol_, "Name or file");
    list.options("-p,--parameter", parameters_, kParameterWord, "Change a parameter");
    list.option("-s,--specimen", specimen_, kSpecimenWord, "Name or file of what is on the rig",
                true);
    list.option("--operator", operator_, kOperatorWord, "Who runs it (default: you)");
    list.option("--note", note_, "TEXT", "Stored with the run");
    list.flag("--detach", detach_, "Return as soon as the run goes on");
    list.flag("--next", next_, "Put it at the front of the queue");
    list.flag("--dry-run", dry_run_, "Only look and plan on this rig; nothing moves");
  }

  Outcome<ExitCode> run(Context& context) override {
    auto start = request(context);
    if (!start) return start.error();
    StopSignals signals;
    auto client = ControlClient::connect(context);
    if (!client) return unreachable(context, client.error());
    if (next_ && !dry_run_) return queue_first(context, *client, *start);
    if (dry_run_) return show_plan(context, *client, *start);
    // Watching begins before the run, so that nothing of it is missed.
    if (!detach_) {
      auto watching = client->call("watch", json::object());
      if (!watching) return watching.error();
    }
    // The daemon identifies and configures the instruments before it answers.
    auto started = client->call("run.start", to_json(*start), kPlanPatience);
    if (!started) return refused_run(context, started.error(), *start, protocol_, parameters_);
    const auto run = started->is_object() ? started->value("run", std::int64_t{0}) : 0;
    if (!context.global.json) print_pressure(context.console.out, *started);
    return follow(context, *client, signals, run);
  }

 private:
  Outcome<ExitCode> queue_first(Context& context, ControlClient& client, const RunRequest& start) {
    json params = to_json(start);
    params["place"] = "first";
    return queue_run(context, client, params, start, protocol_, parameters_);
  }

  Outcome<RunRequest> request(const Context& context) const {
    auto out = run_request(LibraryPath(context.env), protocol_, parameters_, specimen_);
    if (!out) return out;
    out->operator_name = operator_;
    out->note = note_;
    return out;
  }

  // Proposes the same run without a rig.
  Failure unreachable(const Context& context, Failure failure) const {
    if (!failure.no_daemon) return failure;
    failure.next =
        without_daemon(next_command(at_database(context.global.db), pressing("rehearse")));
    return failure;
  }

  Words pressing(const char* verb) const {
    Words words{verb, protocol_};
    add_options(words, "-p", parameters_);
    add_option(words, "--specimen", specimen_);
    return words;
  }

  // The command as it was typed, without --dry-run.
  std::string this_run(const Context& context) const {
    Words words = pressing("run");
    add_option(words, "--operator", operator_);
    add_option(words, "--note", note_);
    add_flag(words, "--detach", detach_);
    add_flag(words, "--next", next_);
    return next_command(context.global, words);
  }

  Outcome<ExitCode> show_plan(Context& context, ControlClient& client, const RunRequest& start) {
    auto plan = client.call("run.plan", to_json(start), kPlanPatience);
    if (!plan) return refused_run(context, plan.error(), start, protocol_, parameters_);
    return show(context, *plan, [&](std::ostream& out) {
      print_plan(out, *plan);
      context.console.next(this_run(context));
    });
  }

  Outcome<ExitCode> follow(Context& context, ControlClient& client, StopSignals& signals,
                           std::int64_t run) {
    if (detach_) {
      return show(context, json{{"run", run}}, [&](std::ostream& out) {
        fmt::print(out, "run {} goes on\n", run);
        context.console.next(next_command(context.global, {"watch"}));
      });
    }
    auto end = follow_run(context, client, signals, {.run = run, .owner = true});
    if (!end) return end.error();
    const auto code = print_run_end(context, client, end->run);
    return end->interrupted ? kInterrupted : code;
  }

  std::string protocol_, specimen_, operator_, note_;
  std::vector<std::string> parameters_;
  bool detach_ = false, dry_run_ = false, next_ = false;
};

// Says what has to happen before a run starts, so that nobody waits for what waits for them.
void say_idle(Context& context, const DaemonStatus& status) {
  context.console.note(idle_words(status.queue, status.correcting) + "; Ctrl-C leaves");
  if (!status.queue) return;
  GlobalOptions daemon = context.global;
  daemon.db.clear();
  const auto next = next_for_queue(daemon, *status.queue);
  if (!next.empty()) context.console.next(next);
}

}  // namespace

Outcome<ExitCode> watch_live(Context& context) {
  StopSignals signals;
  auto client = ControlClient::connect(context);
  if (!client) return client.error();
  auto watching = client->call("watch", json::object());
  if (!watching) return watching.error();
  auto status = parse_daemon_status(*watching);
  if (!status) return Failure(status.error());
  FollowOptions options;
  if (status->run) {
    options.run = status->run->run;
  } else {
    say_idle(context, *status);
  }
  auto end = follow_run(context, *client, signals, options);
  if (!end) return end.error();
  return print_run_end(context, *client, end->run);
}

const CommandFactory kRunCommand = make_command<RunCommand>;

}  // namespace lcrig::cli
