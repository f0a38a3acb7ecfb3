// SPDX-License-Identifier: Apache-2.0
#include "base/usage_error.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "base/near_word.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kLongest = 100;

std::string words_of_extras(const CLI::App& app) {
  const std::vector<std::string> extras = app.remaining();
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) known.push_back("--" + name);
  }
  // The first word that is no option may be the value of the unknown option, so find that option
  // first.
  const auto option =
      std::ranges::find_if(extras, [](const std::string& w) { return w.starts_with('-'); });
  if (option == extras.end()) {
    return fmt::format("'{}' has no place here: it takes options only",
                       extras.empty() ? "" : printable(extras.front(), kLongest));
  }
  const std::string name = option->substr(0, option->find('='));
  return fmt::format("unknown option {}{}", printable(name, kLongest),
                     did_you_mean(name, known, kGuessAtPrompt));
}

// CLI11 writes "Could not convert: --seed = fast".
std::string words_of_value(std::string_view text) {
  constexpr std::string_view kLead = "Could not convert: ", kIs = " = ";
  const auto is = text.find(kIs);
  if (!text.starts_with(kLead) || is == text.npos) return std::string(text);
  return fmt::format("{}: '{}' is not a number that it takes",
                     text.substr(kLead.size(), is - kLead.size()),
                     printable(text.substr(is + kIs.size()), kLongest));
}

std::string words_of(const CLI::App& app, const CLI::ParseError& error) {
  const std::string text = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) return words_of_extras(app);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    return text.substr(0, text.find(':')) + ": give it one value";
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr) return words_of_value(text);
  return text;
}

}  // namespace

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  return fmt::format("error: {}: {}\n  next: {} --help\n", app.get_name(), words_of(app, error),
                     app.get_name());
}

int answer_parse(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) {  // --help, --version
    app.exit(error);
    return end_of_output(app);
  }
  std::cerr << usage_error(app, error);
  return 2;
}

int end_of_output(const CLI::App& app) {
  std::cout.flush();
  if (std::cout && std::fflush(stdout) == 0) return 0;
  std::cerr << fmt::format("error: {}: cannot write to standard output: {}\n  next: df -h\n",
                           app.get_name(), std::strerror(errno));
  return 1;
}

}  // namespace lcrig
