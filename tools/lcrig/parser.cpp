// SPDX-License-Identifier: Apache-2.0
// Parses arguments with CLI11. Where the messages of CLI11 2.1 are poor (unknown subcommand,
// unknown option), the mistake is found before CLI11 parses. Its exit codes are converted to ours.
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <span>
#include <string_view>

#include "base/near_word.hpp"
#include "base/number.hpp"
#include "base/program_version.hpp"
#include "tools/lcrig/command.hpp"
#include "tools/lcrig/did_you_mean.hpp"

namespace lcrig::cli {

namespace {

class Cli11Arguments final : public ArgumentList {
 public:
  explicit Cli11Arguments(CLI::App& app) : app_(app) {}
  void positional(Placeholder name, std::string& out, const char* help, bool required) override {
    app_.add_option(name.word, out, help)
        ->required(required)
        ->option_text(required ? "" : "[optional]");
  }
  void words(Placeholder name, std::vector<std::string>& out, const char* help,
             bool required) override {
    app_.add_option(name.word, out, help)->required(required)->option_text("...");
  }
  void option(const char* names, std::string& out, Placeholder value, const char* help,
              bool required) override {
    app_.add_option(names, out, help)->required(required)->option_text(value.word);
  }
  void options(const char* names, std::vector<std::string>& out, Placeholder value,
               const char* help) override {
    // One value for each option, so that the words after it stay positional.
    app_.add_option(names, out, help)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->option_text(std::string(value.word) + " ...");
  }
  void seed(const char* names, std::optional<std::uint64_t>& out, const char* help) override {
    // Otherwise CLI11 would accept -1 as 2^64 - 1.
    const auto parse = [&out](const std::string& text) {
      out = number_from<std::uint64_t>(text);
      if (out) return;
      throw CLI::ValidationError("--seed", "'" + text + "' is not a whole number from 0 on");
    };
    app_.add_option_function<std::string>(names, parse, help)->option_text("N");
  }
  void number(const char* names, std::function<void(double)> take, const char* metavar,
              const char* help) override {
    const auto parse = [names, take = std::move(take)](const std::string& text) {
      const auto value = number_from<double>(text);
      if (!value) {
        const auto comma = comma_words(text);
        throw CLI::ValidationError(
            names, '"' + text + "\": " + (comma.empty() ? "expected a number" : comma));
      }
      take(*value);
    };
    app_.add_option_function<std::string>(names, parse, help)->option_text(metavar);
  }
  void one_of(const char* names, std::string& out, const std::vector<std::string>& choices,
              const char* help) override {
    std::string text;
    for (const auto& choice : choices) text += (text.empty() ? "" : "|") + choice;
    const auto check = [choices](const std::string& word) -> std::string {
      if (std::ranges::find(choices, word) != choices.end()) return {};
      const auto guess = did_you_mean(word, choices, kGuessAtPrompt);
      return fmt::format("'{}'{} it takes {}", word, guess.empty() ? ";" : guess,
                         join_words(choices));
    };
    app_.add_option(names, out, help)->check(CLI::Validator(check, ""))->option_text(text);
  }
  void flag(const char* names, bool& out, const char* help) override {
    app_.add_flag(names, out, help);
  }

 private:
  CLI::App& app_;
};

using Commands = std::vector<std::unique_ptr<Command>>;

// "protocol list" -> {"protocol", "list"}
std::vector<std::string> name_words(const Command& command) {
  return CLI::detail::split(command.name, ' ');
}

struct Parser {
  Parser(Commands& commands, GlobalOptions& global);

  Outcome<Command*> find(const std::vector<std::string>& args);
  Outcome<Command*> find_in_group(const std::string& group, std::size_t at,
                                  const std::vector<std::string>& args);
  Outcome<Command*> check_options(Command* command, const std::vector<std::string>& args);
  std::optional<Failure> unknown_option(const std::vector<std::string>& args,
                                        std::size_t end) const;  // before `end`
  const CLI::Option* known_option(const CLI::App& app, const std::string& token) const;
  std::vector<std::string> option_names(const CLI::App& app) const;
  std::size_t first_word(const std::vector<std::string>& args, std::size_t from) const;
  std::string help_of(const Command* command, const std::string& group) const;

  CLI::App app{"Runs and records characterizations of capacitive sensors.", "lcrig"};
  std::map<std::string, CLI::App*> groups;  // "protocol"
  std::map<const Command*, CLI::App*> apps;
  std::vector<std::string> top_words;
  Commands& all;
  std::string group_for_help;
};

Parser::Parser(Commands& commands, GlobalOptions& global) : all(commands) {
  app.require_subcommand(1);
  app.set_version_flag("--version", fmt::format("lcrig {}", program_version()));
  Cli11Arguments everywhere(app);
  declare_global(everywhere, global);
  for (const auto& command : commands) {
    const auto words = name_words(*command);
    CLI::App* parent = &app;
    if (words.size() > 1) {
      auto& group = groups[words[0]];
      if (group == nullptr) {
        group = app.add_subcommand(words[0]);
        group->require_subcommand(1)->fallthrough();
        top_words.push_back(words[0]);
      }
      parent = group;
    } else {
      top_words.push_back(words[0]);
    }
    if (parent != &app) {
      const std::string before = parent->get_description();
      parent->description(before + (before.empty() ? "" : ", ") + words.back());
    }
    auto* sub = parent->add_subcommand(words.back(), command->summary);
    sub->fallthrough();
    Cli11Arguments arguments(*sub);
    command->declare(arguments);
    apps[command.get()] = sub;
  }
}

const CLI::Option* Parser::known_option(const CLI::App& sub, const std::string& token) const {
  auto name = token.substr(0, token.find('='));
  // "-pname=value" and "-o-" contain their value.
  if (!name.starts_with("--") && name.size() > 2) name.resize(2);
  if (const auto* option = sub.get_option_no_throw(name)) return option;
  return app.get_option_no_throw(name);
}

// The first argument that is neither an option nor the value of one.
std::size_t Parser::first_word(const std::vector<std::string>& args, std::size_t from) const {
  std::size_t i = from;
  while (i < args.size() && args[i].starts_with('-') && args[i].size() > 1) {
    const auto* option = known_option(app, args[i]);
    const bool takes_next = option != nullptr && option->get_expected_max() > 0 &&
                            option->get_items_expected_max() > 0 &&
                            args[i].find('=') == std::string::npos;
    i += takes_next ? 2 : 1;
  }
  return std::min(i, args.size());
}

bool asks_for(const std::vector<std::string>& args, const char* a, const char* b) {
  return std::any_of(args.begin(), args.end(),
                     [=](const std::string& word) { return word == a || word == b; });
}

Failure usage(std::string what, std::string next) {
  return Failure(kUsage, std::move(what), std::move(next));
}

// nullptr: help for everything or for a group, or --version; CLI11 recognises which.
Outcome<Command*> Parser::find(const std::vector<std::string>& args) {
  const auto at = first_word(args, 0);
  if (at == args.size()) {
    if (asks_for(args, "--help", "-h") || asks_for(args, "--version", "")) return nullptr;
    if (const auto unknown = unknown_option(args, at)) return *unknown;
    return usage("a command is missing", "lcrig --help");
  }
  const auto& word = args[at];
  if (word == "run" && at + 1 < args.size()) {  // a verb of `runs`
    const auto meant = "runs " + args[at + 1];
    if (std::ranges::any_of(all, [&](const auto& command) { return meant == command->name; })) {
      return usage(fmt::format("unknown command 'run {}'{}", args[at + 1],
                               guess_words(meant, kGuessAtPrompt)),
                   fmt::format("lcrig {} --help", meant));
    }
  }
  if (groups.contains(word)) return find_in_group(word, at, args);
  for (const auto& command : all) {
    if (word == command->name) return check_options(command.get(), args);
  }
  // The word after an unknown option may be its value.
  if (const auto unknown = unknown_option(args, at)) return *unknown;
  return usage(
      fmt::format("unknown command '{}'{}", word, did_you_mean(word, top_words, kGuessAtPrompt)),
      "lcrig --help");
}

std::optional<Failure> Parser::unknown_option(const std::vector<std::string>& args,
                                              std::size_t end) const {
  for (const auto& arg : std::span(args).first(end)) {
    if (!arg.starts_with('-') || arg == "--" || known_option(app, arg) != nullptr) continue;
    return usage(
        fmt::format("unknown option {}{}", arg, did_you_mean_option(arg, option_names(app))),
        "lcrig --help");
  }
  return std::nullopt;
}

Outcome<Command*> Parser::find_in_group(const std::string& group, std::size_t at,
                                        const std::vector<std::string>& args) {
  std::vector<std::string> verbs;
  const auto verb_at = first_word(args, at + 1);
  for (const auto& command : all) {
    const auto words = name_words(*command);
    if (words.size() < 2 || words[0] != group) continue;
    verbs.push_back(words[1]);
    if (verb_at < args.size() && args[verb_at] == words[1]) {
      return check_options(command.get(), args);
    }
  }
  // The word after an unknown option may be its value.
  if (const auto unknown = unknown_option(args, verb_at)) return *unknown;
  group_for_help = group;
  if (verb_at == args.size() && asks_for(args, "--help", "-h")) return nullptr;
  const auto next = fmt::format("lcrig {} --help   (it knows: {})", group, join_words(verbs));
  if (verb_at == args.size()) {
    return usage(fmt::format("lcrig {}: what? a verb is missing", group), next);
  }
  return usage(fmt::format("unknown command '{} {}'{}", group, args[verb_at],
                           did_you_mean(args[verb_at], verbs, kGuessAtPrompt)),
               next);
}

std::vector<std::string> Parser::option_names(const CLI::App& sub) const {
  std::vector<std::string> names;
  for (const auto* part : {&sub, &app}) {
    for (const auto* option : part->get_options()) {
      for (const auto& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

// Options for a file, socket, anchor or thing at the rig, where an empty value is a mistake. A note
// may be empty.
bool names_something(std::string_view option) {
  constexpr std::array kOptions{"--db",      "--socket",  "--config", "--anchor",     "--specimen",
                                "--probe",   "--fixture", "--batch",  "--not-before", "--not-after",
                                "--between", "--tag",     "--to",     "--operator",   "--since",
                                "--bundle",  "--output",  "-o",       "--csv",        "--svg"};
  return std::ranges::find(kOptions, option) != kOptions.end();
}

// The option meant by "-specimen" or "–specimen" (the dash of a word processor); "": none.
std::string meant_option(const std::string& typed, const std::vector<std::string>& known) {
  std::string_view name = std::string_view(typed).substr(0, typed.find('='));
  if (name.starts_with("--")) return {};
  if (name.starts_with('-')) {
    name.remove_prefix(1);
  } else {
    std::string_view dash;
    for (const std::string_view one : {"\u2013", "\u2014", "\u2212"}) {
      if (name.starts_with(one)) dash = one;
    }
    if (dash.empty()) return {};
    while (name.starts_with(dash)) name.remove_prefix(dash.size());
  }
  const auto meant = fmt::format("--{}", name);
  return name.size() > 1 && std::ranges::find(known, meant) != known.end() ? meant : std::string();
}

// Finds mistakes that CLI11 blames on the wrong argument: an unknown option before a positional,
// and a missing value of an option.
Outcome<Command*> Parser::check_options(Command* command, const std::vector<std::string>& args) {
  const auto& sub = *apps.at(command);
  std::set<const CLI::Option*> seen;
  const std::string* waits = nullptr;  // the option whose value is expected next
  const auto wrong = [&](const std::string& what) {
    return usage(fmt::format("lcrig {}: {}", command->name, what),
                 fmt::format("lcrig {} --help", command->name));
  };
  // It is often an unset shell variable; another file would be taken, or nothing compared.
  const auto empty = [&](const std::string& option) {
    return wrong(option + ": its value is empty");
  };
  const auto without_value = [&] { return wrong(*waits + ": its value is missing"); };
  for (const auto& arg : args) {
    if (waits != nullptr) {
      const bool option = arg.starts_with('-') && known_option(sub, arg) != nullptr;
      if (option && arg.size() > 1) return without_value();
      if (arg.empty() && names_something(*waits)) return empty(*waits);
      waits = nullptr;
      continue;
    }
    if (arg == "--") break;
    if (const auto meant = meant_option(arg, option_names(sub)); !meant.empty()) {
      return wrong(fmt::format("{} is no option{}", arg.substr(0, arg.find('=')),
                               guess_words(meant, kGuessAtPrompt)));
    }
    if (!arg.starts_with('-') || arg.size() < 2) continue;
    if (number_from<double>(arg)) continue;  // a negative number
    const auto* option = known_option(sub, arg);
    if (option == nullptr) {
      return wrong(
          fmt::format("unknown option {}{}", arg, did_you_mean_option(arg, option_names(sub))));
    }
    const auto name = arg.substr(0, arg.find('='));
    const bool takes_value = option->get_items_expected_max() > 0;
    if (arg.ends_with('=') && names_something(arg.substr(0, arg.size() - 1))) {
      return empty(arg.substr(0, arg.size() - 1));
    }
    if (takes_value && arg.ends_with('=')) {  // CLI11 takes no empty value here, nor in `--note=`
      return wrong(name + " its value is missing");
    }
    if (!takes_value && arg.find('=') != std::string::npos) return wrong(name + " takes no value");
    const bool once = option->get_multi_option_policy() != CLI::MultiOptionPolicy::TakeAll;
    if (takes_value && !seen.insert(option).second && once) return wrong(name + " was given twice");
    const bool attached =
        arg.find('=') != std::string::npos || (!arg.starts_with("--") && arg.size() > 2);
    if (takes_value && !attached) waits = &arg;
  }
  if (waits != nullptr) return without_value();
  return command;
}

std::string Parser::help_of(const Command* command, const std::string& group) const {
  if (command != nullptr) {
    const auto words = name_words(*command);
    const std::string parent = words.size() > 1 ? "lcrig " + words[0] : "lcrig";
    return fmt::format(
        "Example: {}\n\n{}\nEverywhere: --db FILE, --socket PATH, --config FILE, "
        "--json\n",
        command->example, apps.at(command)->help(parent));
  }
  if (!group.empty()) {
    for (const auto& one : all) {
      if (name_words(*one)[0] != group) continue;
      return fmt::format("Example: {}\n\n{}", one->example, groups.at(group)->help("lcrig"));
    }
  }
  return fmt::format("Example: lcrig rehearse static-frame --specimen paper-1\n\n{}", app.help());
}

// The verb of a group that was typed without one. "": the group needs a verb.
std::string usual_verb(std::string_view group) {
  if (group == "runs") return "list";
  return group == "lcr" ? "show" : "";
}

// Translates short forms: `lcrig help run` is `lcrig run --help`, and `lcrig runs` lists the runs.
std::vector<std::string> as_parsed(const Parser& parser, std::vector<std::string> args) {
  const auto at = parser.first_word(args, 0);
  if (at < args.size() && args[at] == "help") {
    args.erase(args.begin() + static_cast<std::ptrdiff_t>(at));
    args.emplace_back("--help");
    return args;
  }
  const auto verb = at == args.size() ? std::string() : usual_verb(args[at]);
  if (verb.empty() || asks_for(args, "--help", "-h")) return args;
  if (parser.first_word(args, at + 1) < args.size()) return args;
  args.insert(args.begin() + static_cast<std::ptrdiff_t>(at) + 1, verb);
  return args;
}

std::string missing_words(const CLI::App& sub) {
  std::vector<std::string> missing;
  for (const auto* option : sub.get_options()) {
    if (option->get_required() && option->count() == 0) missing.push_back(option->get_name());
  }
  return fmt::format("{} {} missing", join_words(missing), missing.size() == 1 ? "is" : "are");
}

// Says in plain words what CLI11 refuses.
std::string plain_words(const CLI::ParseError& error, const CLI::App& all, const CLI::App& sub) {
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) return missing_words(sub);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const auto words = all.remaining(true);
    return fmt::format("too many words: '{}' {} no place here", fmt::join(words, "', '"),
                       words.size() == 1 ? "has" : "have");
  }
  return error.what();
}

Outcome<ExitCode> parse_and_run(Parser& parser, const std::vector<std::string>& args,
                                Context& context) {
  auto command = parser.find(args);
  if (!command) return command.error();
  try {
    std::vector<std::string> reversed(args.rbegin(), args.rend());  // CLI11 pops from the back
    parser.app.parse(std::move(reversed));
  } catch (const CLI::CallForHelp&) {
    context.console.out << parser.help_of(*command, parser.group_for_help);
    return kOk;
  } catch (const CLI::CallForVersion& e) {
    context.console.out << e.what() << '\n';
    return kOk;
  } catch (const CLI::ParseError& e) {  // its exit codes 105 to 110 mean nothing to a script
    if (*command == nullptr) return usage(e.what(), "lcrig --help");
    const char* name = (*command)->name;
    return usage(
        fmt::format("lcrig {}: {}", name, plain_words(e, parser.app, *parser.apps.at(*command))),
        fmt::format("lcrig {} --help", name));
  }
  if (*command == nullptr) return usage("a command is missing", "lcrig --help");
  return (*command)->run(context);
}

}  // namespace

int run_cli(const std::vector<std::string>& args, Context& context) {
  if (const auto answer = answer_to_program(context.env, args)) {
    context.console.out << *answer;
    return kOk;
  }
  auto commands = make_commands();
  Parser parser(commands, context.global);
  auto code = parse_and_run(parser, as_parsed(parser, args), context);
  context.console.out.flush();
  if (!code) {
    context.console.print(code.error());
    return code.error().code;
  }
  if (!context.console.out) {
    context.console.print(Failure(kFailed, "cannot write to standard output", "df -h"));
    return kFailed;
  }
  return *code;
}

}  // namespace lcrig::cli
