// SPDX-License-Identifier: Apache-2.0
#include "base/option_completion.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string_view>

namespace lcrig {

namespace {

bool takes_value(const CLI::App& app, const std::string& name) {
  const auto* option = app.get_option_no_throw(name);
  return option != nullptr && option->get_items_expected_max() > 0;
}

std::string options_of(const CLI::App& app) {
  std::string out = "none\n";
  for (const CLI::Option* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) {
      out += fmt::format("--{}\t{}\n", name, option->get_description());
    }
  }
  return out;
}

std::string values_of(const OptionValues& values, std::string_view before) {
  std::string out = values.files + "\n";
  for (const auto& word : values.words) out += fmt::format("{}{}\t\n", before, word);
  return out;
}

}  // namespace

std::optional<std::string> completion_of(const CLI::App& app,
                                         const std::map<std::string, OptionValues>& values,
                                         std::span<const char* const> arguments) {
  if (arguments.size() < 2 || std::string_view(arguments[0]) != "__complete") return std::nullopt;
  const std::vector<std::string> words(arguments.begin() + 2, arguments.end());  // the words after
                                                                                 // "--"
  const std::string word = words.empty() ? "" : words.back();
  const std::string before = words.size() < 2 ? "" : words[words.size() - 2];
  const auto offered = [&](const std::string& option, std::string_view prefix) {
    const auto known = values.find(option);
    return values_of(known == values.end() ? OptionValues() : known->second, prefix);
  };
  if (takes_value(app, before)) return offered(before, "");
  const auto equals = word.find('=');
  if (equals != word.npos) {
    return offered(word.substr(0, equals), std::string_view(word).substr(0, equals + 1));
  }
  return options_of(app);  // the program takes nothing but options
}

}  // namespace lcrig
