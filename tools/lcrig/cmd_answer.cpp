// SPDX-License-Identifier: Apache-2.0
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/next_command.hpp"
#include "tools/lcrig/print_json.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

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
    // An answer is never taken for that of another question, which came up meanwhile.
    if (*asked) request.question = (*asked)->number;
    constexpr auto kPatience = std::chrono::seconds(30);  // it is stored first
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

const CommandFactory kAnswerCommand = make_command<AnswerCommand>;

}  // namespace lcrig::cli
