// SPDX-License-Identifier: Apache-2.0
// What a gateway states in CAPS together with what a person states in the config file.
#include "drivers/stated_frame.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lcrig {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Values with three digits, so that a sentence shows them whole.
class RandomStatement {
 public:
  StatedFrame draw() {
    StatedFrame s;
    if (chance()) s.force_class = ForceClass(kForceClasses[random_() % kForceClasses.size()]);
    if (chance()) s.force_loop = draw_loop();
    if (chance()) s.travel_step = Length::from_si(whole() * 1e-8);
    if (chance()) s.force_step = Force::from_si(whole() * 1e-5);
    if (chance()) s.filter = time();
    if (chance()) s.play = Length::from_si(whole() * 1e-7);
    return s;
  }

 private:
  ForceLoop draw_loop() {
    ForceLoop loop;
    loop.approach = Velocity::from_si(whole() * 1e-6);
    loop.contact = Force::from_si(whole() * 1e-4);
    loop.rate_max = ForceRate::from_si(whole() * 1e-2);
    loop.lag = time();
    loop.ripple = Force::from_si(whole() * 1e-5);
    loop.stiffness_max = Stiffness::from_si(whole() * 1e3);
    return loop;
  }
  bool chance() { return random_() % 4 != 0; }
  double whole() { return static_cast<double>(1 + random_() % 999); }
  Duration time() { return std::chrono::milliseconds(1 + random_() % 999); }

  std::mt19937_64 random_{7};
};

FrameCapabilities stating(const StatedFrame& s) {
  FrameCapabilities c;
  c.force_class = s.force_class;
  c.force_loop = s.force_loop;
  c.travel_step = s.travel_step;
  c.force_step = s.force_step;
  c.filter = s.filter;
  c.play = s.play;
  return c;
}

// In the units of the sentences; nullopt: not stated.
using Values = std::vector<std::pair<std::string, std::optional<double>>>;
Values values_of(const FrameCapabilities& c) {
  const auto of = [](const auto& q, auto value) {
    return q ? std::optional<double>(value(*q)) : std::nullopt;
  };
  const auto& l = c.force_loop;
  return {{"frame.force_class", of(c.force_class, [](auto v) { return v.percent(); })},
          {"frame.travel_step_um", of(c.travel_step, [](auto v) { return v.si() * 1e6; })},
          {"frame.force_step_mN", of(c.force_step, [](auto v) { return v.si() * 1e3; })},
          {"frame.filter_s", of(c.filter, [](auto v) { return to_seconds(v); })},
          {"frame.play_um", of(c.play, [](auto v) { return v.si() * 1e6; })},
          {"frame.force_loop.approach_mm_s", of(l, [](auto v) { return v.approach.si() * 1e3; })},
          {"frame.force_loop.contact_N", of(l, [](auto v) { return v.contact.si(); })},
          {"frame.force_loop.rate_max_N_s", of(l, [](auto v) { return v.rate_max.si(); })},
          {"frame.force_loop.lag_s", of(l, [](auto v) { return to_seconds(v.lag); })},
          {"frame.force_loop.ripple_N", of(l, [](auto v) { return v.ripple.si(); })},
          {"frame.force_loop.stiffness_max_N_mm",
           of(l, [](auto v) { return v.stiffness_max.si() * 1e-3; })}};
}

TEST(StatedTwice, TheWorseOneCountsAndASentenceNamesBoth) {
  RandomStatement random;
  for (int i = 0; i < 1000; ++i) {
    const FrameCapabilities frame = stating(random.draw());
    const StatedFrame person = random.draw();
    const auto [counted, differences] = count_the_worse(frame, person);
    const Values a = values_of(frame), b = values_of(stating(person)), c = values_of(counted);
    std::size_t both = 0;
    for (std::size_t k = 0; k < c.size(); ++k) {
      const auto& [key, value] = c[k];
      SCOPED_TRACE(key);
      ASSERT_EQ(value.has_value(), a[k].second || b[k].second);
      if (!value) continue;
      const bool smaller_is_worse =
          key.ends_with("rate_max_N_s") || key.ends_with("stiffness_max_N_mm");
      for (const auto& one : {a[k].second, b[k].second}) {
        if (!one) continue;
        if (smaller_is_worse) {
          EXPECT_LE(*value, *one);
        } else {
          EXPECT_GE(*value, *one * (1 - 1e-12));
        }
      }
      if (!a[k].second || !b[k].second || *a[k].second == *b[k].second) continue;
      ++both;
      EXPECT_THAT(differences,
                  testing::Contains(testing::StartsWith(
                      fmt::format("the frame states {:.6g} for {}, the config {:.6g}: that of the ",
                                  *a[k].second, key, *b[k].second))));
    }
    EXPECT_EQ(differences.size(), both);
    if (!frame.force_loop || !person.force_loop) continue;
    // A HOLD overshoots by rate times lag.
    const auto over_N = [](const ForceLoop& l) { return l.rate_max.si() * to_seconds(l.lag); };
    EXPECT_GE(over_N(*counted.force_loop), over_N(*frame.force_loop) * (1 - 1e-6));
    EXPECT_GE(over_N(*counted.force_loop), over_N(*person.force_loop) * (1 - 1e-6));
  }
}

TEST(StatedTwice, AsTheSameIsNoDifference) {
  RandomStatement random;
  const StatedFrame s = random.draw();
  const auto twice = count_the_worse(stating(s), s);
  EXPECT_EQ(twice.capabilities, stating(s));
  EXPECT_THAT(twice.differences, IsEmpty());
}

TEST(MissingStatements, AreThoseWithoutADefault) {
  FrameCapabilities c;
  EXPECT_THAT(missing_statements(c), IsEmpty()) << "dead weights";
  c.motion = true;
  EXPECT_THAT(missing_statements(c), ElementsAre("frame.travel_step_um"));
  c.force_hold = true;
  EXPECT_THAT(missing_statements(c), ElementsAre("frame.travel_step_um", "frame.force_loop"));
  c.travel_step = Length();
  c.force_loop.emplace();
  EXPECT_THAT(missing_statements(c), IsEmpty());
}

}  // namespace
}  // namespace lcrig
