// SPDX-License-Identifier: Apache-2.0
// The plan's words about the force where a motion ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/protocols/planned.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Plan, PredictedOvershootMustFitTheAllowanceAndTheLimit) {
  // dF = k (v tau + v^2 / 2a) = 60e3 * (1e-3 * 1e-3 + 1e-6 / 0.1) = 0.66 N at 1 mm/s.
  const auto load = [](const std::string& more) {
    return R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":1,"timeout_s":400)" +
           more + "}";
  };
  EXPECT_THAT(refusal(load(""), frame_rig()),
              HasSubstr("1 mm/s to 1 N may end at 1.66 N on a contact of up to 60 N/mm, the limit "
                        "is 1.5 N: at most 0.864 mm/s (/steps/0/speed_mm_s: 0.864)"));
  // On a frame that is as soft as 40 N/mm it may end within the limit, but not within 0.1 N.
  Rig softer = frame_rig();
  softer.frame_stiffness_N_m = 40e3;
  softer.compression_m = [](double force) { return force / 40e3; };
  EXPECT_THAT(refusal(load(R"(,"overshoot_N":0.1)"), softer), HasSubstr("the step allows 0.1 N"));
  const auto two = [&load](const std::string& from) {
    return load(R"(,"overshoot_N":0.1,"final_speed_mm_s":0.05,"final_from":)" + from);
  };
  EXPECT_EQ(refusal(two("0.4"), frame_rig()), "planned");
  // 0.5 + 0.66 N: the slow part would come too late.
  EXPECT_THAT(refusal(two("0.5"), frame_rig()), HasSubstr("the step allows 0.6 N"));
  EXPECT_THAT(refusal(two("1"), frame_rig()), HasSubstr("1.66 N"));
}

TEST(Plan, AForceTooNearToTheLimitIsAnsweredByOneThatIsAccepted) {
  const auto load = [](const std::string& force_N) {
    return R"({"id":"l","do":"move_until","until":{"force_N":)" + force_N +
           R"(},"speed_mm_s":0.016,"timeout_s":4000})";
  };
  // 60e3 * (0.016e-3 * 1e-3 + 0.016e-3^2 / 0.1) = 0.00111 N beyond.
  const std::string text = refusal(load("1.5"), frame_rig());
  EXPECT_THAT(text, HasSubstr("to 1.5 N may end at 1.50111 N"));
  const std::string place = "(/steps/0/until/force_N: ";
  const auto at = text.find(place);
  ASSERT_NE(at, std::string::npos) << text;
  const auto begin = at + place.size();
  const std::string advised = text.substr(begin, text.find(')', begin) - begin);
  EXPECT_GT(std::stod(advised), 1.4);
  EXPECT_EQ(refusal(load(advised), frame_rig()), "planned");
}

TEST(Plan, WhatTheUnloadedCellShowsBelowZeroIsMissingUpToTheLimit) {
  const auto shows = [](double rest_force_N, double noise_N) {
    Rig rig = frame_rig();
    rig.start_travel = Length::from_si(-1e-3);  // else the way back is towards anywhere
    rig.rest_force_N = rest_force_N;  // below zero: more presses than is shown
    rig.force_noise_N = noise_N;
    return rig;
  };
  const auto worst_N = [](const std::string& steps, const Rig& rig) {
    return plan_steps(steps, rig).value().worst_force_N;
  };
  const Rig tared = shows(0, 0.001), below = shows(-0.23, 0.001);
  for (const std::string step :
       {R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":0.1,"timeout_s":400})",
        R"({"id":"l","do":"ramp","to":{"force_N":1},"speed_mm_s":0.1,"timeout_s":400})",
        R"({"id":"l","do":"ramp","to":{"force_N":1},"force_rate_N_s":0.1,"timeout_s":400})",
        R"({"id":"l","do":"hold","hold":"force","force_N":1,"for_s":1})"}) {
    SCOPED_TRACE(step);
    const double whole_N = worst_N(step, tared);
    EXPECT_NEAR(worst_N(step, below), whole_N + 0.23, 1e-9);
    EXPECT_EQ(worst_N(step, shows(-0.23, 0.05)), whole_N) << "within 5 sigma of noise it is none";
    EXPECT_EQ(worst_N(R"({"id":"z","do":"zero","force":true},)" + step, below), whole_N);
  }
  const std::string load =
      R"({"id":"l","do":"move_until","until":{"force_N":1.35},"speed_mm_s":0.1,"timeout_s":400})";
  EXPECT_EQ(refusal(load, tared), "planned");
  EXPECT_THAT(refusal(load, below), HasSubstr("the limit is 1.5 N"));
}

TEST(Plan, AHostSideStopOvershootsMore) {
  // 20 ms more: 60e3 * (0.3e-3 * 21e-3 + 0.09e-6 / 0.1) = 0.432 N, without them 0.072 N.
  const std::string load =
      R"({"id":"l","do":"move_until","until":{"force_N":1.2},"speed_mm_s":0.3,"timeout_s":400})";
  EXPECT_EQ(refusal(load, frame_rig()), "planned");
  Rig rig = frame_rig();
  rig.frame.device_stop = false;
  EXPECT_THAT(refusal(load, rig), HasSubstr("may end at 1.63 N"));
}

TEST(Plan, BeforeContactIsFoundAWayIsNotJudgedByAGuessedGap) {
  Rig rig = frame_rig();
  rig.expected_contact.reset();
  rig.start_travel = Length::from_si(-5e-3);
  const auto plan = plan_steps(
      R"({"id":"s","do":"ramp","to":{"travel_mm":0.9},"speed_mm_s":0.01,"timeout_s":700})", rig);
  ASSERT_TRUE(plan) << plan.error().what;
}

}  // namespace
}  // namespace lcrig
