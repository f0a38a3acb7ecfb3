// SPDX-License-Identifier: Apache-2.0
// protocol list, show, check.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "protocols/file/parse.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/library_path.hpp"
#include "tools/lcrig/print_json.hpp"

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
  const char* name() const override { return "protocol list"; }
  const char* summary() const override { return "The protocols that are installed"; }
  const char* example() const override { return "lcrig protocol list"; }
  Outcome<ExitCode> run(Context& context) override {
    json rows = json::array();
    for (const auto& file : LibraryPath(context.env).list(LibraryKind::protocol)) {
      auto protocol = load_protocol(file.path.string());
      const auto title = protocol ? protocol->title : "invalid: " + protocol.error().what;
      rows.push_back(json{{"name", file.name}, {"path", file.path.string()}, {"title", title}});
      if (!context.global.json)
        fmt::print(context.console.out, "{:18} {}\n", printable(file.name, kLongestName),
                   printable(title, kLongestWords));
    }
    json all = json::object();
    all["protocols"] = std::move(rows);
    if (context.global.json) print_json(context.console.out, all);
    return kOk;
  }
};

class ProtocolShowCommand final : public Command {
 public:
  const char* name() const override { return "protocol show"; }
  const char* summary() const override { return "The text and the parameters of a protocol"; }
  const char* example() const override { return "lcrig protocol show dynamic-cycles"; }
  void declare(ArgumentList& list) override {
    list.positional("PROTOCOL", protocol_, "Name or file");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto file = LibraryPath(context.env).get(LibraryKind::protocol, protocol_);
    if (!file) return tl::unexpected(file.error());
    auto protocol = parse_protocol(file->text, file->path.string());
    if (!protocol) return tl::unexpected(invalid(protocol.error()));
    if (!context.global.json) {
      context.console.print_file(file->text);
      return kOk;
    }
    json parameters = json::array();
    for (const auto& [name, p] : protocol->parameters)
      parameters.push_back(parameter_json(name, p));
    json out{{"name", protocol->name}, {"title", protocol->title}, {"text", file->text}};
    out["description"] = protocol->description;
    out["path"] = file->path.string();
    out["parameters"] = std::move(parameters);
    print_json(context.console.out, out);
    return kOk;
  }

 private:
  std::string protocol_;
};

class CheckCommand final : public Command {
 public:
  const char* name() const override { return "protocol check"; }
  const char* summary() const override { return "Is a protocol file correct?"; }
  const char* example() const override { return "lcrig protocol check my-protocol.json"; }
  void declare(ArgumentList& list) override {
    list.positional("FILE", protocol_, "Name or file");
    list.options("-p,--parameter", parameters_, "NAME=VALUE", "Change a parameter");
  }
  Outcome<ExitCode> run(Context& context) override {
    auto parameters = parse_assignments(parameters_);
    if (!parameters) return tl::unexpected(parameters.error());
    auto file = LibraryPath(context.env).get(LibraryKind::protocol, protocol_);
    if (!file) return tl::unexpected(file.error());
    auto protocol = parse_protocol(file->text, file->path.string());
    if (!protocol) return tl::unexpected(invalid(protocol.error()));
    auto bound = bind_parameters(*protocol, *parameters);
    if (!bound) return tl::unexpected(invalid(bound.error()));
    if (context.global.json) {
      print_json(context.console.out, json{{"name", protocol->name}, {"valid", true}});
    } else {
      fmt::print(context.console.out, "{}: correct\n", printable(file->path.string()));
      fmt::print(context.console.err, "  next: lcrig protocol plan {}\n", printable(protocol_));
    }
    return kOk;
  }

 private:
  std::string protocol_;
  std::vector<std::string> parameters_;
};

}  // namespace

std::unique_ptr<Command> make_protocol_list_command() {
  return std::make_unique<ProtocolListCommand>();
}
std::unique_ptr<Command> make_protocol_show_command() {
  return std::make_unique<ProtocolShowCommand>();
}
std::unique_ptr<Command> make_protocol_check_command() {
  return std::make_unique<CheckCommand>();
}

}  // namespace lcrig::cli
