// SPDX-License-Identifier: Apache-2.0
#include "model/auto_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/error_estimate.hpp"
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

Specimen bonded(std::size_t n) {
  Specimen s = shipped("paper-1");
  s.faces = Faces::bonded_laminate;
  for (Material& m : s.materials) {
    m.youngs_modulus_Pa = m.rigid ? 2.5e9 : 2 * 42e3 * 1.49;
    m.poisson_ratio = m.rigid ? 0.34 : 0.49;
    m.rigid = false;
  }
  s.capacitors.assign(n, s.capacitors.front());
  return s;
}

// Estimated errors of every level against the reference changes of the bonded laminate, N = 1.
TEST(AutoLevel, EstimateBoundsTheTrueErrorWithinTen) {
  const Specimen s = bonded(1);
  for (const auto& [p_kPa, exact_fF] : {std::pair{10.0, 5.3776}, std::pair{100.0, 51.170}}) {
    for (const Level level : {Level::bonded, Level::fem_linear}) {
      LevelSettings settings;
      settings.level = level;
      auto model = make_level_model(s, settings).value();
      const double change = model->at_pressure(p_kPa * 1.0_kPa)->delta_capacitance_F * 1e15;
      const double truth = std::abs(change / exact_fF - 1);
      const double estimate = estimate_error(s, settings, p_kPa * 1.0_kPa).value();
      EXPECT_GE(estimate, truth) << to_string(level) << " at " << p_kPa;
      EXPECT_LE(estimate, 10 * truth) << to_string(level) << " at " << p_kPa;
    }
  }
}

TEST(AutoLevel, BondedFacesClimbTheLadder) {
  const Specimen s = bonded(1);
  EXPECT_EQ(choose_level(s, 0.05, 100.0_kPa)->settings.level, Level::bonded);
  EXPECT_EQ(choose_level(s, 0.015, 10.0_kPa)->settings.level, Level::fem_linear);
  const auto fine = choose_level(s, 1e-3, 100.0_kPa);
  ASSERT_TRUE(fine) << fine.error().what;
  EXPECT_EQ(fine->settings.level, Level::fem_finite);
  const auto never = choose_level(s, 1e-9, 100.0_kPa);
  ASSERT_FALSE(never);
  EXPECT_THAT(never.error().what, testing::HasSubstr("no level meets"));
}

TEST(AutoLevel, RefusesSenselessRequests) {
  EXPECT_FALSE(choose_level(shipped("paper-1"), 0, 100.0_kPa));
  EXPECT_FALSE(choose_level(shipped("paper-1"), 1e-3, 0.0_kPa));
  EXPECT_FALSE(choose_level(shipped("paper-1"), std::nan(""), 1.0_kPa));
}

}  // namespace
}  // namespace lcrig
