// SPDX-License-Identifier: Apache-2.0
// lcrig-sim plays a random rig, and writes what a config file would say about it.
#include <csignal>
#include <fstream>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

TEST_F(Rig, ARandomRigIsServedAndTold) {
  Child sim({LCRIG_BIN "/lcrig-sim", "--rig", "random:7", "--told", file("told.json")},
            file("sim.log"));
  const auto line = sim.out().next(20s);
  ASSERT_TRUE(line) << sim.log();
  ports_ = json::parse(*line);
  EXPECT_TRUE(ports_.at("frame").get<std::string>().starts_with("tcp://"));
  std::ifstream file_told(file("told.json"));
  const json told = json::parse(file_told);
  EXPECT_TRUE(told.at("frame").contains("force_class"));
  EXPECT_TRUE(told.at("fixture").contains("probe_diameter_mm"));
  EXPECT_TRUE(told.contains("specimen"));
  sim.signal(SIGTERM);
  EXPECT_EQ(sim.wait(10s), 0);
}

TEST_F(Rig, AnUnknownRigIsRefusedWithAnExample) {
  Child sim({LCRIG_BIN "/lcrig-sim", "--rig", "odd:7"}, file("sim.log"));
  EXPECT_EQ(sim.wait(10s), 2);
  EXPECT_NE(sim.log().find("such as random:7"), std::string::npos) << sim.log();
}

}  // namespace
}  // namespace lcrig::e2e
