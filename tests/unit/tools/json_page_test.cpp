// SPDX-License-Identifier: Apache-2.0
// The examples of docs/cli-json.md must be what the commands print.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/cli_fixture.hpp"

namespace lcrig {
namespace {

using nlohmann::json;

// The block of JSON behind the line that begins with `command`.
json example(const std::string& command) {
  std::ifstream page("docs/cli-json.md");
  std::string text;
  bool found = false, inside = false;
  for (std::string line; std::getline(page, line);) {
    found = found || line.starts_with(command);
    if (inside && line == "```") break;
    if (inside) text += line;
    if (found && line == "```json") inside = true;
  }
  return json::parse(text, nullptr, false);
}

// Times of day, places and the speed of the computer may differ.
void expect_alike(const json& shown, const json& printed) {
  ASSERT_TRUE(shown.is_object());
  for (const auto& [key, value] : printed.items()) {
    ASSERT_TRUE(shown.contains(key)) << key << " is not in the example";
  }
  for (const auto& [key, value] : shown.items()) {
    ASSERT_TRUE(printed.contains(key)) << key << " does not exist";
    if (key == "wall_s" || value.is_string()) continue;
    if (value.is_object()) {
      expect_alike(value, printed[key]);
      continue;
    }
    if (!value.is_number_float()) {
      EXPECT_EQ(value, printed[key]) << key;
    } else {
      EXPECT_NEAR(value.get<double>(), printed[key].get<double>(),
                  1e-3 * std::abs(value.get<double>()))
          << key;
    }
  }
}

TEST(JsonPage, ShowsWhatARehearsalAndItsListingPrint) {
  support::Cli cli;
  cli.rehearsal = &rehearse;
  std::ifstream file("protocols/library/static-frame.json");
  cli.add_data("protocols/static-frame.json", {std::istreambuf_iterator<char>(file), {}});
  ASSERT_EQ(cli.run({"rehearse", "static-frame", "--specimen", "paper-1", "--json"}), 0)
      << cli.err.str();
  const auto printed = cli.out.str();
  expect_alike(example("`lcrig rehearse"), json::parse(printed));
  ASSERT_EQ(cli.run({"runs", "--json"}), 0) << cli.err.str();
  const auto runs = json::parse(cli.out.str());
  expect_alike(example("`lcrig runs --json`"), runs["runs"][0]);
  EXPECT_FALSE(::testing::Test::HasFailure()) << printed << runs["runs"][0];
}

}  // namespace
}  // namespace lcrig
