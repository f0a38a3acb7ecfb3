// SPDX-License-Identifier: Apache-2.0
// A frame's capabilities, stored and read back.
#include "daemon/record/stored_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lcrig {
namespace {

class RandomCapabilities {
 public:
  // The structured bindings name every member, so that a new one breaks the build here.
  FrameCapabilities draw() {
    FrameCapabilities c;
    auto& [motion, force_hold, device_stop, weights, force_channel, travel_channel, zero_force,
           zero_travel, force_max, force_class, speed_min, speed_max, travel_min, travel_max,
           rate_Hz, force_loop, reaction, deceleration, travel_step, force_step, filter, play] = c;
    for (bool* flag : {&motion, &force_hold, &device_stop, &weights, &force_channel,
                       &travel_channel, &zero_force, &zero_travel}) {
      *flag = chance();
    }
    force_max = Force::from_si(value());
    if (chance()) force_class = ForceClass(kForceClasses[random_() % kForceClasses.size()]);
    speed_min = Velocity::from_si(value());
    speed_max = Velocity::from_si(value());
    travel_min = Length::from_si(-value());
    travel_max = Length::from_si(value());
    rate_Hz = value();
    if (chance()) force_loop = draw_loop();
    reaction = time();
    deceleration = Acceleration::from_si(value());
    if (chance()) travel_step = Length::from_si(value());
    if (chance()) force_step = Force::from_si(value());
    if (chance()) filter = time();
    if (chance()) play = Length::from_si(value());
    return c;
  }

 private:
  ForceLoop draw_loop() {
    ForceLoop out;
    auto& [approach, contact, rate_max, lag, ripple, stiffness_max] = out;
    approach = Velocity::from_si(value());
    contact = Force::from_si(value());
    rate_max = ForceRate::from_si(value());
    lag = time();
    ripple = Force::from_si(value());
    stiffness_max = Stiffness::from_si(value());
    return out;
  }
  bool chance() { return random_() % 2 == 0; }
  double value() { return std::exp(std::uniform_real_distribution(-20.0, 20.0)(random_)); }
  Duration time() { return Duration(static_cast<std::int64_t>(random_() % 60'000'000'000)); }

  std::mt19937_64 random_{1};
};

TEST(StoredFrame, IsReadBackWhole) {
  RandomCapabilities random;
  for (int i = 0; i < 1000; ++i) {
    const FrameCapabilities c = random.draw();
    const std::string row = to_json(stored_capabilities(c));
    EXPECT_EQ(frame_capabilities(parse_capabilities(row)), c) << row;
  }
}

TEST(StoredFrame, OfAnOlderRowHasNoForceLoopAndBothChannels) {
  const auto c = frame_capabilities(parse_capabilities(
      R"({"deceleration_m_s2":0.05,"device_stop":true,"force_hold":true,"force_max_N":20.0,)"
      R"("motion":true,"reaction_s":0.001,"speed_max_m_s":0.01,"travel_max_m":0.1,)"
      R"("travel_min_m":-0.1,"weights":false})"));
  FrameCapabilities expected;
  expected.motion = expected.device_stop = expected.force_hold = true;
  expected.force_max = 20.0_N;
  expected.speed_max = 10.0_mm_s;
  expected.travel_min = -100.0_mm;
  expected.travel_max = 100.0_mm;
  expected.reaction = std::chrono::milliseconds(1);
  expected.deceleration = 0.05_m_s2;
  EXPECT_EQ(c, expected);
}

}  // namespace
}  // namespace lcrig
