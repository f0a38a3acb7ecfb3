// SPDX-License-Identifier: Apache-2.0
#include "model/auto_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

TEST(AutoLevel, TakesTheCheapestThatMeetsTheTolerance) {
  const Specimen s = shipped("paper-1");
  EXPECT_EQ(choose_level(s, 1e-3, 100.0_kPa)->settings.level, Level::hyperelastic);
  const auto rough = choose_level(s, 0.5, 1.0_kPa);
  ASSERT_TRUE(rough);
  EXPECT_EQ(rough->settings.level, Level::linear);
  EXPECT_LE(rough->error_estimate, 0.5);
}

TEST(AutoLevel, SaysWhatWasLeftOut) {
  const auto choice = choose_level(shipped("paper-1"), 1e-3, 100.0_kPa);
  ASSERT_TRUE(choice);
  const auto json = to_json(*choice);
  EXPECT_EQ(json["level"], "hyperelastic");
  ASSERT_GE(json["left_out"].size(), 5U);
  EXPECT_EQ(json["left_out"][0]["effect"], "fringe field");
  EXPECT_NEAR(json["left_out"][0]["relative_size"], 0.030, 0.003);
  EXPECT_THAT(to_text(*choice), testing::HasSubstr("lateral friction"));
}

TEST(AutoLevel, BondedFacesClimbTheLadder) {
  const Specimen s = laminate(1);
  EXPECT_EQ(choose_level(s, 0.05, 100.0_kPa)->settings.level, Level::bonded);
  EXPECT_EQ(choose_level(s, 0.01, 10.0_kPa)->settings.level, Level::fem_linear);
  const auto fine = choose_level(s, 1e-3, 100.0_kPa);
  ASSERT_TRUE(fine) << fine.error().what;
  EXPECT_EQ(fine->settings.level, Level::fem_finite);
  const auto never = choose_level(s, 1e-9, 100.0_kPa);
  ASSERT_FALSE(never);
  EXPECT_THAT(never.error().what, testing::HasSubstr("no level meets"));
  // The message says which tolerance can be met, and this is true.
  const auto& what = never.error().what;
  const double met = std::stod(what.substr(what.find("kPa; ") + 5));
  EXPECT_TRUE(choose_level(s, met * 1.02, 100.0_kPa)) << what;
}

TEST(AutoLevel, AStackThatNoLevelCoversIsRefusedWithoutFinerMeshes) {
  const auto never = choose_level(soft_block(1), 10, Pressure::from_si(1e9));
  ASSERT_FALSE(never);
  EXPECT_THAT(never.error().what, testing::HasSubstr("no level covers this stack"));
  EXPECT_THAT(never.error().what, testing::HasSubstr("fem_finite (mesh 0) not applicable"));
  EXPECT_THAT(never.error().what, testing::Not(testing::HasSubstr("mesh 1")));
}

TEST(AutoLevel, ARefusalNamesTheBestLevelAndItsCost) {
  double time = 100;
  SearchTime patience;
  patience.seconds_now = [&] { return time += 0.5; };
  const auto never = choose_level(soft_block(1), 1e-9, 1.0_kPa, patience);
  ASSERT_FALSE(never);
  const std::string& what = never.error().what;
  EXPECT_THAT(what, testing::ContainsRegex("can be met by fem_.* in [0-9.]+ s"));
  const double seconds = std::stod(what.substr(what.find(" in ") + 4));
  EXPECT_GE(seconds, 1) << "since the search began, not since it had solved nearly all: " << what;
  EXPECT_LT(seconds, time - 100) << what;
}

// The tolerance that can be met is that of the finest mesh, even where no mesh comes near the
// requested one.
TEST(AutoLevel, ARefusalHasTriedTheFinestMesh) {
  ErrorEstimator solved(laminate(1));
  const auto never = choose_level(solved, 1e-9, 10.0_kPa);
  ASSERT_FALSE(never);
  LevelSettings finest;
  finest.level = Level::fem_finite;
  finest.mesh.refinement = kFinestFiniteMesh;
  const auto best = solved.estimate(finest, 10.0_kPa);
  ASSERT_TRUE(best);
  EXPECT_THAT(never.error().what, testing::HasSubstr("fem_finite (mesh 2)"));
  const double met = std::stod(never.error().what.substr(never.error().what.find("kPa; ") + 5));
  EXPECT_NEAR(met, best->relative, 0.05 * best->relative);
}

TEST(AutoLevel, RefusesSenselessRequests) {
  EXPECT_FALSE(choose_level(shipped("paper-1"), 0, 100.0_kPa));
  EXPECT_FALSE(choose_level(shipped("paper-1"), 1e-3, 0.0_kPa));
  EXPECT_FALSE(choose_level(shipped("paper-1"), std::nan(""), 1.0_kPa));
}

}  // namespace
}  // namespace lcrig
