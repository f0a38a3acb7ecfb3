// SPDX-License-Identifier: Apache-2.0
// Texts that tell somebody what to type must name commands and programs that exist.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/cli_fixture.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;

// The words that may follow `lcrig`: "run", "runs", "runs list".
std::set<std::string> known_words() {
  std::set<std::string> out{"help"};
  for (const auto& command : cli::make_commands()) {
    const std::string name = command->name;
    out.insert(name);
    out.insert(name.substr(0, name.find(' ')));
  }
  return out;
}

// In a group ("runs") the second word counts, too. After a whole command anything may follow.
bool exists(const std::set<std::string>& known, const std::string& first,
            const std::string& second) {
  if (!known.contains(first)) return false;
  const bool is_group = std::ranges::any_of(
      known, [&](const std::string& name) { return name.starts_with(first + " "); });
  return !is_group || second.empty() || known.contains(first + " " + second);
}

std::vector<std::string> unknown_in(const std::string& text, const std::set<std::string>& known) {
  static const std::regex command(
      R"((?:^|[\n`(;:,>$&|] ?)lcrig ([a-z][a-z-]*)(?: ([a-z][a-z-]*))?)");
  // The name must not be the beginning of a longer one.
  static const std::regex program(R"(\blcrig-[a-z]+\b(?![-/]))");
  static const std::set<std::string> programs{"lcrig-sim", "lcrig-gateway"};
  std::vector<std::string> out;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), command);
       it != std::sregex_iterator(); ++it) {
    if (exists(known, (*it)[1], (*it)[2])) continue;
    out.push_back(it->str().substr(it->str().find("lcrig")));
  }
  for (auto it = std::sregex_iterator(text.begin(), text.end(), program);
       it != std::sregex_iterator(); ++it) {
    if (!programs.contains(it->str())) out.push_back(it->str());
  }
  return out;
}

// The code in a page: text in backticks, and the lines of fenced or indented blocks.
std::string code_of_page(const fs::path& path) {
  static const std::regex span("`([^`]+)`");
  std::ifstream in(path);
  std::string out, line;
  bool fenced = false;
  while (std::getline(in, line)) {
    if (line.starts_with("```")) {
      fenced = !fenced;
    } else if (fenced || line.starts_with("    ")) {
      out += line.substr(0, line.find('#')) + '\n';
    } else {
      for (auto it = std::sregex_iterator(line.begin(), line.end(), span);
           it != std::sregex_iterator(); ++it) {
        out += (*it)[1].str() + '\n';
      }
    }
  }
  return out;
}

// The string literals of a source file; its comments do not count.
std::string strings_of_source(const fs::path& path) {
  static const std::regex literal(R"re("((?:[^"\\]|\\.)*)")re");
  std::ifstream in(path);
  std::string out, line;
  while (std::getline(in, line)) {
    line = line.substr(0, line.find("// "));
    for (auto it = std::sregex_iterator(line.begin(), line.end(), literal);
         it != std::sregex_iterator(); ++it) {
      out += (*it)[1].str() + '\n';
    }
  }
  return out;
}

TEST(NamedCommands, NothingIsNamedThatDoesNotExist) {
  const auto known = known_words();
  std::size_t pages = 0, sources = 0;
  for (const char* top : {"README.md", "CONTRIBUTING.md"}) {
    EXPECT_THAT(unknown_in(code_of_page(top), known), ::testing::IsEmpty()) << top;
  }
  for (const char* folder : {"docs", "base", "events", "plot", "storage", "model", "drivers",
                             "protocols", "daemon", "analysis", "budget", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const auto kind = entry.path().extension();
      std::string text;
      if (kind == ".md") text = code_of_page(entry.path()), ++pages;
      if (kind == ".cpp" || kind == ".hpp") text = strings_of_source(entry.path()), ++sources;
      EXPECT_THAT(unknown_in(text, known), ::testing::IsEmpty()) << entry.path();
    }
  }
  EXPECT_GT(pages, 10U);
  EXPECT_GT(sources, 200U);
}

// Options on a page that the command does not have, as "runs show --frce".
std::vector<std::string> unknown_options_in(const std::string& text) {
  static const std::regex call(
      R"((?:^|[\n`$/ ])lcrig ([a-z][a-z-]*)(?: ([a-z][a-z-]*))?([^\n`|;&]*))");
  static const std::regex option(R"(--[a-zA-Z][a-zA-Z-]*)");
  std::vector<std::string> out;
  support::Cli cli;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), call); it != std::sregex_iterator();
       ++it) {
    const std::string one = (*it)[1], two = one + " " + (*it)[2].str(), rest = (*it)[3];
    std::vector<std::string> words{one};
    if (known_words().contains(two)) words.push_back((*it)[2]);
    if (words.size() == 1 && one == "runs") words.emplace_back("list");
    words.emplace_back("--help");
    cli.run(words);
    for (auto o = std::sregex_iterator(rest.begin(), rest.end(), option);
         o != std::sregex_iterator(); ++o) {
      if (cli.out.str().find(o->str()) == std::string::npos) out.push_back(two + " " + o->str());
    }
  }
  return out;
}

TEST(NamedCommands, NoOptionIsNamedThatDoesNotExist) {
  std::vector<fs::path> pages{"README.md", "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator("docs")) pages.push_back(entry.path());
  for (const auto& page : pages) {
    if (page.extension() != ".md") continue;
    EXPECT_THAT(unknown_options_in(code_of_page(page)), ::testing::IsEmpty()) << page;
  }
  EXPECT_THAT(unknown_options_in("lcrig runs show 3 --frce"),
              ::testing::ElementsAre("runs show --frce"));
  EXPECT_THAT(unknown_options_in("lcrig run x --specimen s --detach"), ::testing::IsEmpty());
}

TEST(NamedCommands, WhatDoesNotExistIsFound) {
  const auto known = known_words();
  EXPECT_THAT(unknown_in("lcrig rewind", known), ::testing::ElementsAre("lcrig rewind"));
  EXPECT_THAT(unknown_in("lcrig runs shwo 1", known), ::testing::ElementsAre("lcrig runs shwo"));
  EXPECT_THAT(unknown_in("lcrig-web", known), ::testing::ElementsAre("lcrig-web"));
  EXPECT_THAT(unknown_in("lcrig status shows it; lcrig runs; lcrig-sim", known),
              ::testing::IsEmpty());
}

}  // namespace
}  // namespace lcrig
