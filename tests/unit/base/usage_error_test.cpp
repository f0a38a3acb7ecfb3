// SPDX-License-Identifier: Apache-2.0
#include "base/usage_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdint>

namespace lcrig {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string said_of(std::vector<std::string> arguments) {
  CLI::App app{"a program", "prog"};
  std::string config;
  std::uint16_t port = 0;
  app.add_option("--config", config);
  app.add_option("--frame-port", port);
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& e) {
    return usage_error(app, e);
  }
  return "";
}

TEST(UsageError, NamesTheWordAndWhatWasMeant) {
  EXPECT_EQ(said_of({"--confg", "x"}),
            "error: prog: unknown option --confg; did you mean '--config'?\n"
            "  next: prog --help\n");
  EXPECT_THAT(said_of({"--confg=x"}), HasSubstr("did you mean '--config'?"));
  EXPECT_THAT(said_of({"start"}), HasSubstr("prog: 'start' has no place here"));
  EXPECT_THAT(said_of({"--config"}), HasSubstr("prog: --config: give it one value\n"));
  EXPECT_THAT(said_of({"--frame-port", "any"}),
              AllOf(HasSubstr("--frame-port: 'any'"), HasSubstr("not a number")));
  EXPECT_EQ(said_of({"--frame-port", "4710"}), "");
}

}  // namespace
}  // namespace lcrig
