// SPDX-License-Identifier: Apache-2.0
// protocol list, show, check.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "protocols/file/parse.hpp"
#include "tools/lcrig/command_output.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/control_client.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

json parameter_json(const std::string& name, const Parameter& p) {
  return json{{"name", name}, {"default", p.default_value}, {"min", p.min},
              {"max", p.max}, {"integer", p.integer},       {"description", p.description}};
}

Outcome<ExitCode> protocol_list(Context& context, const std::string&) {
  json rows = json::array();
  for (const auto& file : LibraryPath(context.env).list(LibraryKind::protocol)) {
    auto protocol = load_protocol(file.path.string());
    const auto title = protocol ? protocol->title : "invalid: " + protocol.error().what;
    rows.push_back(json{{"name", file.name}, {"path", file.path.string()}, {"title", title}});
    if (!context.global.json) {
      fmt::print(context.console.out, "{:18} {}\n", printable(file.name, kLongestName),
                 printable(title, kLongestWords));
    }
  }
  if (context.global.json) print_json(context.console.out, json{{"protocols", rows}});
  if (!rows.empty()) return kOk;
  return Failure(kFailed, "no protocol is installed",
                 "LCRIG_DATA may name a folder that holds protocols/");
}

constexpr OneWord kProtocolList{"protocol list", "The protocols that are installed",
                                "lcrig protocol list", protocol_list};

Outcome<ExitCode> protocol_show(Context& context, const std::string& name) {
  auto file = LibraryPath(context.env).get(LibraryKind::protocol, name);
  if (!file) return file.error();
  auto protocol = parse_protocol(file->text, file->path.string());
  if (!protocol) return file_refused(protocol.error());
  json parameters = json::array();
  for (const auto& [key, p] : protocol->parameters) parameters.push_back(parameter_json(key, p));
  json out{{"name", protocol->name}, {"title", protocol->title}, {"text", file->text}};
  out["description"] = protocol->description;
  out["path"] = file->path.string();
  out["parameters"] = std::move(parameters);
  return show(context, out, [&](std::ostream&) { context.console.print_file(file->text); });
}

constexpr OneWord kProtocolShow{"protocol show",
                                "The text and the parameters of a protocol",
                                "lcrig protocol show dynamic-cycles",
                                protocol_show,
                                kProtocolWord,
                                "Name or file"};

class CheckCommand final : public Command {
 public:
  CheckCommand()
      : Command("protocol check", "Is a protocol file correct?",
                "lcrig protocol check my-protocol.json") {}
  void declare(ArgumentList& list) override {
    list.positional({"FILE", Proposes::protocol}, protocol_, "Name or file");
    list.options("-p,--parameter", parameters_, kParameterWord, "Change a parameter");
    list.flag("--rig", rig_, "Also by the limits of the rig that the daemon has; nothing moves");
    list.option("-s,--specimen", specimen_, kSpecimenWord, "With --rig: what will be pressed");
  }
  Outcome<ExitCode> run(Context& context) override {
    const auto wanted = find_protocol(LibraryPath(context.env), protocol_, parameters_);
    if (!wanted) return wanted.error();
    const LibraryFile& file = wanted->file;
    auto bound = bind_protocol(context, *wanted);
    if (!bound) return bound.error();
    if (rig_) {
      if (auto planned = plan_on_rig(context); !planned) return planned.error();
    }
    const json verdict{{"name", bound->protocol.name}, {"valid", true}};
    return show(context, verdict, [&](std::ostream& out) {
      fmt::print(out, "{}: correct\n", printable(file.path.string()));
      context.console.next(planning(context));
    });
  }

 private:
  // With `--rig` the proposed command uses the rig as well.
  std::string planning(const Context& context) const {
    Words words = rig_ ? Words{"run", protocol_} : Words{"protocol", "plan", protocol_};
    add_options(words, "-p", parameters_);
    add_option(words, "--specimen", specimen_);
    add_flag(words, "--dry-run", rig_);
    return next_command(context.global, words);
  }

  // A specimen is required, because what a rig can do depends on what it presses.
  Outcome<json> plan_on_rig(const Context& context) const {
    if (specimen_.empty()) {
      return Failure(kUsage, "lcrig protocol check --rig: --specimen is missing",
                     next_command(context.global, {"specimen", "list"}, "shows the known ones"));
    }
    auto request = run_request(LibraryPath(context.env), protocol_, parameters_, specimen_);
    if (!request) return request.error();
    auto client = ControlClient::connect(context);
    if (!client) return unreachable(context, client.error());
    auto plan = client->call("run.plan", to_json(*request), kPlanPatience);
    if (plan) return plan;
    Failure refused = plan.error();
    if (refused.refused_request) {  // the daemon's own words propose `lcrig run --dry-run`
      Words again{"protocol", "check", protocol_};
      add_options(again, "-p", parameters_);
      add_option(again, "--specimen", specimen_);
      add_flag(again, "--rig", true);
      refused.next = next_command(context.global, again, "when what the message names is changed");
    }
    return refused_run(context, std::move(refused), *request, protocol_, parameters_);
  }

  // Proposes the same check without a rig.
  Failure unreachable(const Context& context, Failure failure) const {
    if (!failure.no_daemon) return failure;
    Words words{"protocol", "plan", protocol_};
    add_options(words, "-p", parameters_);
    add_option(words, "--specimen", specimen_);
    failure.next = without_daemon(next_command(at_database(context.global.db), words));
    return failure;
  }

  std::string protocol_, specimen_;
  std::vector<std::string> parameters_;
  bool rig_ = false;
};

}  // namespace

const CommandFactory kProtocolListCommand = make_command<OneWordCommand, kProtocolList>;
const CommandFactory kProtocolShowCommand = make_command<OneWordCommand, kProtocolShow>;
const CommandFactory kProtocolCheckCommand = make_command<CheckCommand>;

}  // namespace lcrig::cli
