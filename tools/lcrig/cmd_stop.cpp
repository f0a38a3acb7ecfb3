// SPDX-License-Identifier: Apache-2.0
// pause, stop, abort, freeze, confirm, answer: one call each.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

struct Verb {
  const char *name, *method, *summary, *example, *done;
  bool takes_why = false;
  const char* next = nullptr;  // the verb that ends what this verb began
  // The parameter that names a place in the protocol ("after"), and the help for its option.
  const char *place = nullptr, *place_help = nullptr;
  bool needs_place = false;
};

constexpr Verb kPause{
    .name = "pause",
    .method = "run.pause",
    .summary = "Hold travel now and keep recording",
    .example = "lcrig pause",
    .done = "paused",
    .next = "resume",
    .place = "at",
    .place_help = "Finish the present step, level, cycle or repeat first, or go to a safe point",
};
constexpr Verb kStop{
    .name = "stop",
    .method = "run.stop",
    .summary = "Finish the present level (or step, cycle, repeat), then unload",
    .example = "lcrig stop --after level",
    .done = "",
    .takes_why = true,
    .place = "after",
    .place_help = "What to finish; run: nothing follows from the queue; safe_point: go to one",
    .needs_place = true,
};
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

constexpr const char* kWholeRun = "run";  // the run is finished first, and the queue ends with it

class VerbCommand final : public Command {
 public:
  explicit VerbCommand(const Verb& verb)
      : Command(verb.name, verb.summary, verb.example), verb_(verb) {}
  void declare(ArgumentList& list) override {
    if (verb_.takes_why) list.option("--why", why_, "TEXT", "Stored with the run");
    if (verb_.place != nullptr) {
      auto places = all_words<StopPlace>();
      if (verb_.needs_place) places.emplace_back(kWholeRun);
      list.one_of(verb_.needs_place ? "--after" : "--at", place_, places, verb_.place_help);
    }
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Failure unheard(Failure failure) const;

  const Verb& verb_;
  std::string why_, place_;
};

// Does not propose a rehearsal: the frame has to stop now.
Failure VerbCommand::unheard(Failure failure) const {
  if (&verb_ == &kConfirm) return without_rehearsal(std::move(failure));
  failure.next =
      fmt::format("if the frame moves: stop it at the machine (E-stop); or: {}", kStopBySignal);
  return failure;
}

// What to say after the queue was held.
std::string end_of_queue(ControlClient& client) {
  const auto status = client.call("status", json::object());
  const bool runs =
      status && status->is_object() && status->contains("run") && !status->at("run").is_null();
  return runs ? "the queue ends with the run in progress" : "the queue is held; no run in progress";
}

Outcome<ExitCode> VerbCommand::run(Context& context) {
  if (verb_.needs_place && place_.empty()) {
    return Failure(
        kUsage,
        "--after is missing: what is to be finished? (step, level, cycle, repeat, safe_point, run)",
        next_command(context.global, {"stop", "--after", "level"}, "lcrig abort stops at once"));
  }
  // A stop goes to any daemon, whichever database is meant. A confirmation does not, because it may
  // start a motion.
  auto client = &verb_ == &kConfirm ? ControlClient::connect(context)
                                    : ControlClient::connect_to_stop(context);
  if (!client) return unheard(client.error());
  json params = json::object();
  if (!why_.empty()) params["why"] = why_;
  const bool ends_queue = place_ == kWholeRun;
  if (!place_.empty() && !ends_queue) params[verb_.place] = place_;
  auto answer =
      client->call(ends_queue ? "queue.hold" : verb_.method, params, context.env.stop_patience);
  if (!answer) return answer.error().no_daemon ? unheard(answer.error()) : answer.error();
  client->tell_other_database(context);
  const std::string done = ends_queue ? end_of_queue(*client) : verb_.done;
  return show(context, *answer, [&](std::ostream& out) {
    // A stop reports its own result.
    const std::string note = answer->value("note", std::string());
    fmt::print(out, "{}\n", note.empty() ? done : printable(note));
    if (verb_.next != nullptr && place_.empty()) {
      GlobalOptions daemon = context.global;
      daemon.db.clear();
      context.console.next(next_command(daemon, {verb_.next}));
    }
  });
}

class AnswerCommand final : public Command {
 public:
  AnswerCommand()
      : Command("answer", "Answer the question that the run asks", "lcrig answer 125.5") {}
  void declare(ArgumentList& list) override {
    list.positional("VALUE", value_, "The answer, without its unit (a confirmation needs none)",
                    false);
  }

  Outcome<ExitCode> run(Context& context) override {
    auto client = ControlClient::connect(context);
    if (!client) return without_rehearsal(client.error());
    auto asked = question(*client);
    if (!asked) return asked.error();
    const bool confirms = !*asked || (*asked)->question.type == AnswerType::confirmation;
    if (value_.empty() && !confirms) return missing(context.global, (*asked)->question);
    AnswerRequest request;
    if (!value_.empty()) request.value = value_;
    // The number keeps the answer from being taken for that of a question which came up meanwhile.
    if (*asked) request.question = (*asked)->number;
    constexpr auto kPatience = std::chrono::seconds(30);  // the answer is stored first
    auto answer = client->call("run.answer", to_json(request), kPatience);
    if (!answer) return answer.error();
    return show(context, *answer, [&](std::ostream& out) {
      const json& value = answer->at("value");
      const std::string said = value.is_string()   ? value.get<std::string>()
                               : value.is_number() ? fmt::format("{}", value.get<double>())
                                                   : std::string("confirmed");
      const auto unit = answer->value("unit", std::string());
      fmt::print(out, "step {}: {}{}{}\n",
                 printable(answer->value("step", std::string()), kLongestName),
                 printable(said, kLongestWords), unit.empty() ? "" : " ", unit);
    });
  }

 private:
  static Outcome<std::optional<OpenQuestion>> question(ControlClient& client) {
    auto answer = client.call("status", json::object());
    if (!answer) return answer.error();
    auto status = parse_daemon_status(*answer);
    if (!status) return Failure(status.error());
    if (!status->run) return std::optional<OpenQuestion>();
    return status->run->question;
  }

  static Failure missing(const GlobalOptions& global, const Question& q) {
    return Failure(kUsage,
                   fmt::format("VALUE is missing: step {} asks \"{}\", expected {}",
                               printable(q.step_id, kLongestName), printable(q.text, kLongestWords),
                               printable(expected_words(q), kLongestWords)),
                   next_command(global, {"answer", "VALUE"}));
  }

  std::string value_;
};

}  // namespace

const CommandFactory kPauseCommand = make_command<VerbCommand, kPause>;
const CommandFactory kStopCommand = make_command<VerbCommand, kStop>;
const CommandFactory kAbortCommand = make_command<VerbCommand, kAbort>;
const CommandFactory kFreezeCommand = make_command<VerbCommand, kFreeze>;
const CommandFactory kConfirmCommand = make_command<VerbCommand, kConfirm>;
const CommandFactory kAnswerCommand = make_command<AnswerCommand>;

}  // namespace lcrig::cli
