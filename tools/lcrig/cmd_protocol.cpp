// SPDX-License-Identifier: Apache-2.0
// protocol list, show, check.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "protocols/file/parse.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/protocol_request.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

json parameter_json(const std::string& name, const Parameter& p) {
  return json{{"name", name}, {"default", p.default_value}, {"min", p.min},
              {"max", p.max}, {"integer", p.integer},       {"description", p.description}};
}

Failure invalid(const Error& error) {
  Failure out(error, "correct the file; docs/protocol-file.md describes it");
  out.code = kProtocol;
  return out;
}

class ProtocolListCommand final : public Command {
 public:
  ProtocolListCommand()
      : Command("protocol list", "The protocols that are installed", "lcrig protocol list") {}
  Outcome<ExitCode> run(Context& context) override {
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
    return kOk;
  }
};

class ProtocolShowCommand final : public Command {
 public:
  ProtocolShowCommand()
      : Command("protocol show", "The text and the parameters of a protocol",
                "lcrig protocol show dynamic-cycles") {}
  void declare(ArgumentList& list) override {
    list.positional("PROTOCOL", protocol_, "Name or file");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto file = LibraryPath(context.env).get(LibraryKind::protocol, protocol_);
    if (!file) return file.error();
    auto protocol = parse_protocol(file->text, file->path.string());
    if (!protocol) return invalid(protocol.error());
    json parameters = json::array();
    for (const auto& [key, p] : protocol->parameters) parameters.push_back(parameter_json(key, p));
    json out{{"name", protocol->name}, {"title", protocol->title}, {"text", file->text}};
    out["description"] = protocol->description;
    out["path"] = file->path.string();
    out["parameters"] = std::move(parameters);
    return show(context, out, [&](std::ostream&) { context.console.print_file(file->text); });
  }

 private:
  std::string protocol_;
};

class CheckCommand final : public Command {
 public:
  CheckCommand()
      : Command("protocol check", "Is a protocol file correct?",
                "lcrig protocol check my-protocol.json") {}
  void declare(ArgumentList& list) override {
    list.positional("FILE", protocol_, "Name or file");
    list.options("-p,--parameter", parameters_, "NAME=VALUE", "Change a parameter");
  }
  Outcome<ExitCode> run(Context& context) override {
    const auto wanted = find_protocol(LibraryPath(context.env), protocol_, parameters_);
    if (!wanted) return wanted.error();
    const LibraryFile& file = wanted->file;
    auto protocol = parse_protocol(file.text, file.path.string());
    if (!protocol) return invalid(protocol.error());
    auto bound = bind_parameters(*protocol, wanted->parameters);
    if (!bound) return invalid(bound.error());
    const json verdict{{"name", protocol->name}, {"valid", true}};
    return show(context, verdict, [&](std::ostream& out) {
      fmt::print(out, "{}: correct\n", printable(file.path.string()));
      fmt::print(context.console.err, "  next: lcrig protocol plan {}\n", printable(protocol_));
    });
  }

 private:
  std::string protocol_;
  std::vector<std::string> parameters_;
};

}  // namespace

const CommandFactory kProtocolListCommand = make_command<ProtocolListCommand>;
const CommandFactory kProtocolShowCommand = make_command<ProtocolShowCommand>;
const CommandFactory kProtocolCheckCommand = make_command<CheckCommand>;

}  // namespace lcrig::cli
