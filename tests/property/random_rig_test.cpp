// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig-sim/random_rig.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "model/specimen_file.hpp"
#include "tests/property/own_bounds.hpp"

namespace lcrig::property {
namespace {

TEST(RandomRig, IsTheSameForTheSameSeed) {
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    EXPECT_EQ(describe(sim::random_rig(seed)), describe(sim::random_rig(seed)));
    EXPECT_NE(describe(sim::random_rig(seed)), describe(sim::random_rig(seed + 1)));
  }
}

TEST(RandomRig, IsToldOnTheSafeSideOfTheTruth) {
  int bounded = 0;
  for (std::uint64_t seed = 1; seed < 2000; ++seed) {
    const sim::RandomRig rig = sim::random_rig(seed);
    SCOPED_TRACE(sim::describe(rig));
    const FrameCapabilities& c = rig.declared();
    EXPECT_GE(to_seconds(c.reaction), rig.reaction_s());
    EXPECT_LE(c.deceleration.si(), rig.plant.deceleration_m_s2);
    const OwnContact told(rig);
    if (!told.is_bounded()) continue;
    ++bounded;
    for (double part = 0.05; part <= 2; part += 0.39) {
      const double force_N = part * rig.limit_N;
      EXPECT_GE(told.stiffness_N_m(force_N), 0.999 * rig.stiffness_N_m(force_N));
    }
  }
  EXPECT_GT(bounded, 1500);
}

TEST(RandomRig, SpansWhatRigsMayBe) {
  double softest = 1e9, stiffest = 0, slowest_s = 0, quickest_s = 1;
  for (std::uint64_t seed = 1; seed < 2000; ++seed) {
    const sim::RandomRig rig = sim::random_rig(seed);
    softest = std::min(softest, rig.stiffness_N_m(0));
    stiffest = std::max(stiffest, rig.stiffness_N_m(0));
    slowest_s = std::max(slowest_s, rig.reaction_s());
    quickest_s = std::min(quickest_s, rig.reaction_s());
  }
  EXPECT_LT(softest, 1.1e3);
  EXPECT_GT(stiffest, 900e3);
  EXPECT_GT(slowest_s, 0.07);
  EXPECT_LT(quickest_s, 0.6e-3);
}

TEST(RandomRig, TellsASpecimenThatTheProgramReads) {
  for (std::uint64_t seed = 1; seed < 300; ++seed) {
    const auto told = nlohmann::json::parse(told_json(sim::random_rig(seed)));
    if (told.at("specimen").is_null()) continue;
    const auto read = parse_specimen(told.at("specimen").dump(), "told");
    EXPECT_TRUE(read) << read.error().what;
  }
}

TEST(RandomRig, IsNamedByItsSeed) {
  EXPECT_EQ(sim::parse_rig("random:7").value().seed, 7U);
  for (const char* wrong : {"", "7", "random:", "random:7x", "random:-1", "Random:7"}) {
    EXPECT_EQ(sim::parse_rig(wrong).error().code, Errc::invalid_request) << wrong;
  }
}

}  // namespace
}  // namespace lcrig::property
