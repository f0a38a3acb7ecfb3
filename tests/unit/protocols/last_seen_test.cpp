// SPDX-License-Identifier: Apache-2.0
#include "protocols/rig/last_seen.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "protocols/file/parse.hpp"
#include "protocols/run/point.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

LastSeen at(double travel_m, double force_N, double t_s = 10, double speed_m_s = 0) {
  LastSeen m;
  m.travel_m = travel_m;
  m.force_N = force_N;
  m.device_time_s = t_s;
  m.speed_m_s = speed_m_s;
  return m;
}

FrameTolerance tolerance() {
  FrameTolerance t;
  t.force_N = 0.05;
  t.deceleration = Acceleration::from_si(0.05);
  return t;
}

TEST(LastSeen, TheSameStandingFrameIsWelcome) {
  EXPECT_TRUE(compare_frame(at(1e-3, 0.5), at(1.002e-3, 0.48, 14), tolerance()));
}

TEST(LastSeen, AStandingFrameThatMovedIsNot) {
  const auto r = compare_frame(at(1e-3, 0.5), at(1.05e-3, 0.5, 14), tolerance());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::refused);
  EXPECT_THAT(r.error().what, HasSubstr("1.0500 mm"));
}

TEST(LastSeen, AMovingFrameMayHaveGoneOnUntilItsGatewayNoticed) {
  const LastSeen moving = at(1e-3, 0.1, 10, 50e-6);
  EXPECT_TRUE(compare_frame(moving, at(1.06e-3, 0.5, 14), tolerance()));
  EXPECT_FALSE(compare_frame(moving, at(1.2e-3, 0.5, 14), tolerance()));
  EXPECT_TRUE(compare_frame(moving, at(0.95e-3, 0, 14), tolerance())) << "away from it, too";
}

// Half as fast again as it was seen, until the gateway notices, and then its braking.
TEST(LastSeen, AMovingFrameGoesOnForItsBrakingToo) {
  FrameTolerance brakes = tolerance();
  brakes.silence = Duration::zero();
  const LastSeen moving = at(1e-3, 0.1, 10, 1e-3);
  const double way_m = 10e-6 + 1.5e-3 * 1.5e-3 / (2 * 0.05);
  EXPECT_TRUE(compare_frame(moving, at(1e-3 + 0.99 * way_m, 0.1, 14), brakes));
  EXPECT_FALSE(compare_frame(moving, at(1e-3 + 1.01 * way_m, 0.1, 14), brakes));
}

TEST(LastSeen, WithoutAKnownContactTheForceOnTheWayIsNotJudged) {
  LastSeen moving = at(1e-3, 0.1, 10, 50e-6);
  moving.zeroed = true;
  EXPECT_TRUE(compare_frame(moving, at(1.01e-3, 15, 14), tolerance()));
}

TEST(LastSeen, AFrameThatMayHaveBegunToMoveAfterTheLastSampleMayBeFurtherOn) {
  LastSeen begun = at(1e-3, 0.5);
  begun.begun_m_s = 0.5e-3;
  EXPECT_TRUE(compare_frame(begun, at(1.06e-3, 0.7, 14), tolerance()));
  EXPECT_FALSE(compare_frame(begun, at(1.9e-3, 0.7, 14), tolerance()));
  EXPECT_FALSE(compare_frame(begun, at(1e-3, 0.8, 14), tolerance())) << "it did not move after all";
}

TEST(LastSeen, AnotherForceAtTheSameTravelIsALostZeroOrAnotherSpecimen) {
  const auto r = compare_frame(at(1e-3, 0.5), at(1e-3, 0.8, 14), tolerance());
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().what, HasSubstr("check its zero"));
  LastSeen overloaded = at(1e-3, 0.5, 14);
  overloaded.force_N.reset();
  EXPECT_FALSE(compare_frame(at(1e-3, 0.5), overloaded, tolerance()));
}

// The frame moved while the link was lost, so force and travel must agree.
TEST(LastSeen, OfAFrameThatMovedTheForceAgreesWithTheWay) {
  FrameTolerance allowed = tolerance();
  allowed.rest_N = 0.01;
  allowed.noise_N = 0.001;
  allowed.force_after_N = [](double felt_N, double way_m) { return felt_N + 20e3 * way_m; };
  LastSeen moving = at(1e-3, 0.5, 10, 50e-6);
  moving.zeroed = true;
  const auto fits = [&](double travel_m, double force_N) {
    return compare_frame(moving, at(travel_m, force_N, 14), allowed).has_value();
  };
  EXPECT_TRUE(fits(1.03e-3, 0.5)) << "a soft contact";
  EXPECT_TRUE(fits(1.03e-3, 1.1)) << "the stiffest";
  EXPECT_FALSE(fits(1.03e-3, 1.3)) << "no contact is as stiff";
  EXPECT_FALSE(fits(1.03e-3, 0.4)) << "less force, though closer";
  EXPECT_TRUE(fits(0.97e-3, 0.5));
  EXPECT_TRUE(fits(0.97e-3, 0.0)) << "20 N/mm take 0.6 N away";
  EXPECT_FALSE(fits(0.97e-3, 0.6)) << "more force, though further away";
  EXPECT_FALSE(fits(0.99e-3, 0.0)) << "that takes away more than the stiffest does";
  moving.zeroed = false;
  EXPECT_TRUE(fits(1.03e-3, 1.3)) << "nothing that the run set can have been lost";
  const auto r = compare_frame(at(1e-3, 0.5, 10, 50e-6), at(1.03e-3, 1.3, 14), allowed);
  EXPECT_TRUE(r);
}

TEST(LastSeen, TheForceOnTheWayIsJudgedByTheClassOfTheCell) {
  FrameTolerance allowed = tolerance();
  allowed.force_N = 0;
  allowed.force_after_N = [](double felt_N, double way_m) { return felt_N + 20e3 * way_m; };
  LastSeen moving = at(1e-3, 10, 10, 50e-6);
  moving.zeroed = true;
  for (const double percent : kForceClasses) {
    allowed.cell = ForceClass(percent);
    const auto fits = [&](double part) {
      return compare_frame(moving, at(1.03e-3, 10 - 10 * part, 14), allowed).has_value();
    };
    EXPECT_TRUE(fits(0.99 * percent / 100)) << percent;
    EXPECT_FALSE(fits(1.01 * percent / 100)) << percent;
  }
}

TEST(LastSeen, ARestartedFrameMattersWhenItWasZeroed) {
  LastSeen before = at(1e-3, 0.5, 100);
  EXPECT_TRUE(compare_frame(before, at(1e-3, 0.5, 2), tolerance()));
  before.zeroed = true;
  EXPECT_FALSE(compare_frame(before, at(1e-3, 0.5, 2), tolerance()));
}

TEST(LastSeen, WithoutTravelNothingIsKnown) {
  LastSeen blind = at(1e-3, 0.5);
  blind.travel_m.reset();
  EXPECT_FALSE(compare_frame(blind, at(1e-3, 0.5), tolerance()));
  EXPECT_FALSE(compare_frame(at(1e-3, 0.5), blind, tolerance()));
}

TEST(LastSeen, SpeedComesFromTheDevicesOwnClock) {
  std::array<FrameSample, 3> samples;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].travel_m = 1e-3 + 2e-6 * static_cast<double>(i);
    samples[i].device_time_s = 5 + 0.02 * static_cast<double>(i);
    samples[i].flags = frame_flag::kMoving;
  }
  LastSeen m;
  for (const FrameSample& s : samples) m.feed(s);
  EXPECT_NEAR(m.speed_m_s, 1e-4, 1e-9);
  samples[2].flags = 0;
  m.feed(samples[2]);
  EXPECT_EQ(m.speed_m_s, 0) << "it stands";
}

TEST(RunPoint, SurvivesItsText) {
  RunPoint p;
  p.steps_done = 17;
  p.levels = 5;
  p.level_in_repeat = 2;
  p.level_repeat = 3;
  p.contact_travel_m = 1.2345678e-3;
  p.travel_m = -2.5e-3;
  p.zeroed = true;
  p.origin = "18 \"x\"";
  const auto back = parse_run_point(to_json(p));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(back->steps_done, 17);
  EXPECT_EQ(back->levels, 5);
  EXPECT_EQ(back->level_in_repeat, 2);
  EXPECT_EQ(back->level_repeat, 3);
  EXPECT_EQ(back->contact_travel_m, 1.2345678e-3);
  EXPECT_EQ(back->travel_m, -2.5e-3);
  EXPECT_TRUE(back->zeroed);
  EXPECT_EQ(back->origin, p.origin);
  EXPECT_FALSE(parse_run_point(to_json(RunPoint()))->origin);
  for (const char* bad :
       {"", "[]", "{}", R"({"steps_done":"x"})",
        R"({"steps_done":-1,"levels":0,"level_in_repeat":0,"level_repeat":0,"zeroed":false})"}) {
    EXPECT_FALSE(parse_run_point(bad)) << bad;
  }
}

TEST(RunPoint, ARodBeginsAtItsLastWeight) {
  const auto weights = load_protocol("protocols/library/static-weights.json").value();
  const auto env = bind_parameters(weights, {}).value();
  // Each level of the library: place, settle or measure.
  std::int64_t last = -1;
  for (std::int64_t i = 0; i < 12; ++i) {
    const auto first = first_step_of(weights, env, i);
    EXPECT_LE(first, i);
    EXPECT_GE(first, last) << "it never goes back further than the last weight";
    last = first;
  }
  const auto frame = load_protocol("protocols/library/static-frame.json").value();
  EXPECT_EQ(first_step_of(frame, bind_parameters(frame, {}).value(), 7), 7);
}

TEST(RunPoint, NamesTheStepThatItStandsAt) {
  const auto frame = load_protocol("protocols/library/static-frame.json").value();
  const auto env = bind_parameters(frame, {}).value();
  EXPECT_EQ(kind_of(*step_at(frame, env, 0)), "zero");
  EXPECT_NE(kind_of(*step_at(frame, env, 1)), "zero");
  EXPECT_EQ(step_at(frame, env, 1'000'000), nullptr);
}

TEST(RunPoint, IsRefusedUnderAnotherZeroAndSaysWhoseItMayBe) {
  const auto frame = load_protocol("protocols/library/static-frame.json").value();
  const auto env = bind_parameters(frame, {}).value();
  Continuation from;
  from.run = 7;
  EXPECT_TRUE(compare_with_now(from, frame, env, "4")) << "its gateway could not say it";
  from.point.origin = "3";
  EXPECT_TRUE(compare_with_now(from, frame, env, "3"));
  const auto zeroed = compare_with_now(from, frame, env, "4");
  ASSERT_FALSE(zeroed);
  EXPECT_NE(zeroed.error().what.find("interrupted while it zeroed"), std::string::npos);
  from.point.steps_done = 5;
  const auto later = compare_with_now(from, frame, env, std::nullopt);
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().code, Errc::frame_fault);
  EXPECT_EQ(later.error().what.find("interrupted while it zeroed"), std::string::npos);
}

}  // namespace
}  // namespace lcrig
