// SPDX-License-Identifier: Apache-2.0
// The frame's capabilities in the row of a run.
#include "storage/frame_capabilities.hpp"

#include <gtest/gtest.h>

namespace lcrig {
namespace {

TEST(StoredCapabilities, AreReadAsTheyWereWritten) {
  StoredCapabilities rod;
  rod.weights = true;
  rod.force_max_N = 20;
  const std::string text = to_json(rod);
  EXPECT_EQ(text, R"({"deceleration_m_s2":0.0,"device_stop":false,"force_channel":true,)"
                  R"("force_hold":false,"force_max_N":20.0,"motion":false,"reaction_s":0.0,)"
                  R"("sample_rate_max_Hz":0.0,"speed_max_m_s":0.0,"speed_min_m_s":0.0,)"
                  R"("travel_channel":true,"travel_max_m":0.0,"travel_min_m":0.0,"weights":true,)"
                  R"("zero_force":false,"zero_travel":false})");
  EXPECT_EQ(to_json(parse_capabilities(text)), text);
  StoredCapabilities frame;
  frame.force_class_percent = 3;
  EXPECT_EQ(parse_capabilities(to_json(frame)).force_class_percent, 3);
  EXPECT_EQ(parse_capabilities(text).force_class_percent, std::nullopt);
}

TEST(StoredCapabilities, OfOldOrOddRowsAreTheDefaults) {
  for (const char* text : {"{}", "", "[]", "5", R"({"weights": 1})", R"({"weights": null})"}) {
    EXPECT_FALSE(parse_capabilities(text).weights) << text;
  }
  EXPECT_TRUE(parse_capabilities(R"({"weights": true, "travel_max_m": null})").weights);
  EXPECT_TRUE(parse_capabilities("{}").force_channel);
  EXPECT_FALSE(parse_capabilities("{}").force_loop);
}

TEST(StoredCapabilities, ContainNoPartOfAForceLoop) {
  const std::string five =
      R"("approach_m_s":0.1,"contact_N":1,"rate_max_N_s":2,"lag_s":0.01,"ripple_N":0)";
  const auto loop_of = [](const std::string& fields) {
    return parse_capabilities(R"({"force_loop":{)" + fields + "}}").force_loop;
  };
  EXPECT_FALSE(loop_of(five));
  ASSERT_TRUE(loop_of(five + R"(,"stiffness_max_N_m":1e6)"));
  EXPECT_EQ(loop_of(five + R"(,"stiffness_max_N_m":1e6)")->stiffness_max_N_m, 1e6);
}

}  // namespace
}  // namespace lcrig
