// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "tools/lcrig/argument_table.hpp"

namespace lcrig::cli {

namespace {

// Escapes what scdoc takes for markup. Words in back-quotes, which people type, become bold.
std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size() + 8);
  for (const char c : text) {
    if (c == '_' || c == '*' || c == '\\') out += '\\';
    out += c == '`' ? '*' : c;
  }
  return out;
}

std::string strong_names(const Argument& a) {
  std::string out;
  for (const auto& name : a.names) out += (out.empty() ? "*" : ", *") + escaped(name) + "*";
  return out;
}

// "RUN" or "[RUN]"; "--specimen S".
std::string in_synopsis(const Argument& a) {
  if (a.option) return fmt::format(" *{}* _{}_", escaped(a.names.back()), escaped(a.value));
  const auto word = fmt::format("_{}_{}", escaped(a.value), a.repeats ? "..." : "");
  return a.required ? " " + word : " \\[" + word + "\\]";
}

std::string item(const Argument& a) {
  std::string out = a.option ? strong_names(a) : fmt::format("_{}_", escaped(a.value));
  if (a.option && !a.value.empty()) out += fmt::format(" _{}_", escaped(a.value));
  if (a.repeats) out += " ...";
  return fmt::format("{}\n\t{}\n\n", out, escaped(a.help));
}

std::string entry(Command& command) {
  const auto arguments = arguments_of(command);
  std::string synopsis, items;
  bool optional = false;
  for (const auto& a : arguments) {
    if (!a.option || a.required) synopsis += in_synopsis(a);
    optional = optional || (a.option && !a.required);
    items += item(a);
  }
  return fmt::format("## lcrig {}\n\n*lcrig {}*{}{}\n\n{}.\n\n{}```\n{}\n```\n\n", command.name,
                     command.name, synopsis, optional ? " \\[_option_...\\]" : "",
                     escaped(command.summary), items, command.example);
}

}  // namespace

std::string manual_of_commands() {
  std::string out = "## Options of every command\n\n";
  for (const auto& a : global_arguments()) out += item(a);
  out += "*-h, --help*\n\tWhat a command takes, with an example.\n\n";
  out +=
      "*--version*\n\t"
      "The version, with the commit of its sources.\n\n";
  for (const auto& command : make_commands()) out += entry(*command);
  return out;
}

}  // namespace lcrig::cli
