// SPDX-License-Identifier: Apache-2.0
#include "base/option_completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

namespace lcrig {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string asked(std::vector<const char*> words) {
  CLI::App app{"a program", "program"};
  std::string level, config;
  bool weights = false;
  app.add_option("--log-level", level, "How much is said");
  app.add_option("--config", config, "Config file");
  app.add_flag("--weights", weights, "Dead weights");
  OptionValues levels, files;
  levels.words = {"info", "warn"};
  files.files = "json";
  words.insert(words.begin(), {"__complete", "--"});
  return completion_of(app, {{"--log-level", levels}, {"--config", files}}, words)
      .value_or("nobody asks");
}

TEST(OptionCompletion, OffersOptionsWhereNoValueIsMissing) {
  for (const auto& words : std::vector<std::vector<const char*>>{
           {}, {""}, {"--"}, {"--weights", ""}, {"--log-level", "info", "--w"}}) {
    EXPECT_THAT(asked(words), AllOf(StartsWith("none\n"), HasSubstr("--weights\tDead weights\n"),
                                    HasSubstr("--help\t")));
  }
}

TEST(OptionCompletion, OffersTheValuesOfTheOptionBefore) {
  EXPECT_EQ(asked({"--log-level", "i"}), "none\ninfo\t\nwarn\t\n");
  EXPECT_EQ(asked({"--log-level=i"}), "none\n--log-level=info\t\n--log-level=warn\t\n");
  EXPECT_EQ(asked({"--weights", "--config", ""}), "json\n");
}

TEST(OptionCompletion, IsForTheShellsOnly) {
  CLI::App app{"a program", "program"};
  const std::vector<const char*> plain{"--log-level", "info"}, alone{"__complete"};
  EXPECT_EQ(completion_of(app, {}, plain), std::nullopt);
  EXPECT_EQ(completion_of(app, {}, alone), std::nullopt);
  EXPECT_EQ(completion_of(app, {}, {}), std::nullopt);
}

}  // namespace
}  // namespace lcrig
