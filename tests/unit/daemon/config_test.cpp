// SPDX-License-Identifier: Apache-2.0
#include "daemon/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/corpus.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

constexpr const char* kReal = R"({ "format": "lcrigd-config/1",
  "meter": { "driver": "lcr6100", "port": "serial:2184:005f" },
  "frame": { "driver": "zwick", "port": "tcp://192.0.2.1:4710" },
  "fixture": { "probe_diameter_mm": 4.0 } })";

TEST(Config, ARealRigIsRead) {
  const auto c = parse_config(kReal, "c.json");
  ASSERT_TRUE(c) << c.error().what;
  EXPECT_EQ(c->meter_port, "serial:2184:005f");
  EXPECT_NEAR(*c->fixture.probe_area_m2(), 12.566e-6, 1e-9);
  EXPECT_FALSE(c->bench);
}

TEST(ConfigCorpus, EveryBadFileIsRefusedWithPointerAndReason) {
  corpus::expect_all_refused("tests/corpus/config/reject", 12, parse_config);
}

TEST(ConfigCorpus, EveryGoodFileIsAccepted) {
  const auto good = corpus::files("tests/corpus/config/accept");
  EXPECT_GE(good.size(), 3U);
  for (const auto& path : good) {
    const auto config = load_config(path);
    EXPECT_TRUE(config) << config.error().what;
  }
}

TEST(Bench, TheShippedOneIsRead) {
  const auto text = read_text_file("daemon/rig/benches/paper.json");
  ASSERT_TRUE(text) << text.error().what;
  const auto b = parse_bench(*text, "paper.json");
  ASSERT_TRUE(b) << b.error().what;
  EXPECT_DOUBLE_EQ(b->plant.contact_travel_m, 3.2e-3);
  EXPECT_DOUBLE_EQ(b->plant.frame_stiffness_N_m, 200e3);
  EXPECT_DOUBLE_EQ(b->plant.capacitance_noise_F[0], 60e-15);
}

TEST(Bench, ANegativeStiffnessIsRefused) {
  const auto b = parse_bench(R"({ "format": "bench/1", "name": "x", "error_tolerance": 1e-3,
    "fixture": { "probe_diameter_mm": 4 }, "frame": { "stiffness_N_mm": -1 }, "meter": {} })",
                             "b.json");
  ASSERT_FALSE(b);
  EXPECT_THAT(b.error().what, HasSubstr("/frame/stiffness_N_mm"));
}

TEST(Bench, TheLargestRateOfTheFrameHasBounds) {
  const auto bench = [](const std::string& frame) {
    return parse_bench(R"({ "format": "bench/1", "name": "x", "error_tolerance": 1e-3,
      "fixture": { "probe_diameter_mm": 4 }, "frame": {)" +
                           frame + R"(}, "meter": {} })",
                       "b.json");
  };
  EXPECT_EQ(bench("")->frame_rate_max_Hz, 500);
  EXPECT_EQ(bench(R"("rate_max_kHz": 1)")->frame_rate_max_Hz, 1000);
  for (const char* wrong : {R"("rate_max_Hz": 0)", R"("rate_max_Hz": 1001)"}) {
    const auto b = bench(wrong);
    ASSERT_FALSE(b) << wrong;
    EXPECT_THAT(b.error().what, HasSubstr("/frame/rate_max_Hz"));
  }
}

TEST(Bench, TheClassOfItsCellIsOneOfIso7500) {
  const auto bench = [](const std::string& frame) {
    return parse_bench(R"({ "format": "bench/1", "name": "x", "error_tolerance": 1e-3,
      "fixture": { "probe_diameter_mm": 4 }, "frame": {)" +
                           frame + R"(}, "meter": {} })",
                       "b.json");
  };
  EXPECT_EQ(bench("")->plant.force_class, std::nullopt);
  EXPECT_EQ(bench(R"("force_class": 3)")->plant.force_class, ForceClass(3));
  const auto wrong = bench(R"("force_class": 4)");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().what, HasSubstr("/frame/force_class: 4, expected 0.5, 1, 2 or 3"));
}

}  // namespace
}  // namespace lcrig
