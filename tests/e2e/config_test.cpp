// SPDX-License-Identifier: Apache-2.0
// lcrigd with a config file that is good, bad or not there.
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ConfigFile : public Rig {
 protected:
  Ended lcrigd(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), LCRIG_BIN "/lcrigd");
    return program(arguments, 15s);
  }
};

TEST_F(ConfigFile, TheShippedExampleIsInOrder) {
  const auto done = lcrigd({"--check-config", "--config", "systemd/lcrigd.example.json"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("in order"), HasSubstr("simulated bench paper")));
}

TEST_F(ConfigFile, ACheckNamesTheInstrumentsAndOpensNothing) {
  write("real.json", R"({"format": "lcrigd-config/1",
    "meter": {"driver": "lcr6100", "port": "/dev/no-such-port"},
    "frame": {"driver": "dead_weight"},
    "fixture": {"probe_diameter_mm": 4.0}})");
  const auto done = lcrigd({"--check-config", "--config", file("real.json")});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("/dev/no-such-port"), HasSubstr("dead weights")));
}

// Exit status 2: the unit does not start it again (RestartPreventExitStatus).
TEST_F(ConfigFile, ABadOneIsRefusedWithItsPlaceAndStatus2) {
  write("bad.json", "{ \"format\": \"lcrigd-config/1\",\n  \"meters\": {} }");
  for (const bool check : {true, false}) {
    std::vector<std::string> arguments{"--config", file("bad.json")};
    if (check) arguments.emplace_back("--check-config");
    const auto done = lcrigd(arguments);
    EXPECT_EQ(done.code, 2) << done.err;
    EXPECT_THAT(done.err, AllOf(HasSubstr("bad.json"), HasSubstr("meters")));
  }
}

TEST_F(ConfigFile, AMissingOneSaysWhereTheExampleIs) {
  const auto done = lcrigd({"--config", file("none.json")});
  EXPECT_EQ(done.code, 2) << done.err;
  EXPECT_THAT(done.err, AllOf(HasSubstr("none.json"), HasSubstr("lcrigd.example.json")));
}

}  // namespace
}  // namespace lcrig::e2e
