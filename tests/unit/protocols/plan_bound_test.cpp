// SPDX-License-Identifier: Apache-2.0
// What the plan says about the force at the end of a motion.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "protocols/plan/planned_motion.hpp"
#include "protocols/rig/constants.hpp"
#include "protocols/rig/rest_measurement.hpp"
#include "protocols/steps/hold.hpp"
#include "tests/unit/protocols/planned.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

// The value that a refusal proposes for a place.
std::string advised(const std::string& text, const std::string& place) {
  const auto at = text.find(place + ": ");
  EXPECT_NE(at, std::string::npos) << text;
  if (at == std::string::npos) return "0";
  const auto begin = at + place.size() + 2;
  return text.substr(begin, text.find_first_of(",)", begin) - begin);
}

TEST(Plan, PredictedOvershootMustFitTheAllowanceAndTheLimit) {
  // dF = k (v tau + v^2 / 2a) = 60e3 * (1e-3 * 1e-3 + 1e-6 / 0.1) = 0.66 N at 1 mm/s.
  const auto load = [](const std::string& more) {
    return R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":1,"timeout_s":400)" +
           more + "}";
  };
  EXPECT_THAT(refusal(load(""), frame_rig()),
              HasSubstr("1 mm/s to 1 N may end at 1.66 N on a contact of up to 60 N/mm, the limit "
                        "is 1.5 N: at most 0.864 mm/s (/steps/0/speed_mm_s: 0.864)"));
  // On a frame as soft as 40 N/mm it may end within the limit, but not within 0.1 N.
  Rig softer = frame_rig();
  softer.frame_stiffness_N_m = 40e3;
  softer.compression_m = [](double force) { return force / 40e3; };
  EXPECT_THAT(refusal(load(R"(,"overshoot_N":0.1)"), softer), HasSubstr("the step allows 0.1 N"));
  const auto two = [&load](const std::string& from) {
    return load(R"(,"overshoot_N":0.1,"final_speed_mm_s":0.05,"final_from":)" + from);
  };
  EXPECT_EQ(refusal(two("0.4"), frame_rig()), "planned");
  // 0.5 + 0.66 N: the slow part would begin too late.
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
  const std::string value = advised(text, "/steps/0/until/force_N");
  EXPECT_GT(std::stod(value), 1.4);
  EXPECT_EQ(refusal(load(value), frame_rig()), "planned");
}

// The guard ends a run at the first sample beyond the limit.
TEST(Plan, ASpeedThatARefusalNamesLeavesRoomForTheNoiseOfTheCell) {
  const auto load = [](const std::string& speed) {
    return R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":)" + speed +
           R"(,"timeout_s":4000})";
  };
  const auto rig = [](double noise_N) {
    Rig noisy = frame_rig();
    noisy.force_noise_N = noise_N;
    return noisy;
  };
  constexpr double kNoise_N = 0.005;
  const std::string text = refusal(load("1"), rig(kNoise_N));
  EXPECT_THAT(text, HasSubstr("the limit is 1.5 N less 0.031 N for the noise of the cell"));
  const std::string speed = advised(text, "/steps/0/speed_mm_s");
  EXPECT_EQ(refusal(load(speed), rig(kNoise_N)), "planned");
  const double v = 1e-3 * std::stod(speed), worst_N = 1 + 60e3 * (v * 1e-3 + v * v / 0.1);
  EXPECT_LE(worst_N, 1.5 - kSampleSigmas * kNoise_N);
  EXPECT_GT(worst_N, 1.5 - 3 * kSampleSigmas * kNoise_N);
  EXPECT_EQ(refusal(load(speed), rig(2.7 * kNoise_N)), "planned")
      << "a look of 20 samples needs more";
  EXPECT_NE(refusal(load("0.864"), rig(kNoise_N)), "planned") << "it fills all up to the limit";
  EXPECT_EQ(refusal(load("0.864"), frame_rig()), "planned")
      << "of an unknown noise nothing is said";
}

// The first look found a half of the scatter, and the second one 1.1 times of it.
TEST(Plan, ASpeedThatARefusalNamesIsAcceptedAfterAnotherLook) {
  const auto load = [](const std::string& speed) {
    return R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":)" + speed +
           R"(,"timeout_s":4000})";
  };
  const auto rig = [](double noise_N) {
    RestMeasurement rest;
    for (int i = 0; i < 20; ++i) {
      FrameSample s;
      s.force_N = i % 2 == 0 ? noise_N : -noise_N;
      s.received = MonoTime() + i * 50ms;
      rest.add(std::span(&s, 1));
    }
    Rig noisy = frame_rig();
    noisy.force_noise_N = rest.scatter_N();
    noisy.force_scatter = CellNoise(rest);
    return noisy;
  };
  constexpr double kNoise_N = 0.002;
  const std::string speed = advised(refusal(load("1"), rig(0.5 * kNoise_N)), "/steps/0/speed_mm_s");
  EXPECT_EQ(refusal(load(speed), rig(1.1 * kNoise_N)), "planned");
  EXPECT_NE(refusal(load(speed), rig(1.4 * kNoise_N)), "planned") << "too careful";
}

TEST(Plan, ADepthAtWhichNoSpeedIsSlowEnoughIsAnsweredByOneThatIsAccepted) {
  Rig rig = frame_rig();
  rig.frame_stiffness_N_m = 600e3;  // ten times as stiff as the model expects
  rig.start_travel = Length::from_si(-2e-3);
  rig.start_gap = 2.0_mm;
  const auto press = [](const std::string& to) {
    return R"({"id":"p","do":"ramp","to":{)" + to + R"(},"speed_mm_s":0.1,"timeout_s":400})";
  };
  // 1.2 times the 1.32 N that are expected there exceeds the limit.
  const std::string gap = refusal(press(R"("gap_um":-22)"), rig);
  EXPECT_THAT(gap, HasSubstr("22 um deep into the specimen"));
  const std::string gap_um = advised(gap, "/steps/0/to/gap_um");
  EXPECT_LT(std::stod(gap_um), -15);
  EXPECT_EQ(refusal(press(R"("gap_um":)" + gap_um), rig), "planned");
  const std::string travel_um =
      advised(refusal(press(R"("travel_um":22)"), rig), "/steps/0/to/travel_um");
  EXPECT_DOUBLE_EQ(std::stod(travel_um), -std::stod(gap_um));
  EXPECT_EQ(refusal(press(R"("travel_um":)" + travel_um), rig), "planned");
  // Where a slower motion would do, the depth is kept.
  EXPECT_THAT(advised(refusal(R"({"id":"p","do":"ramp","to":{"gap_um":-15},"speed_mm_s":1,)"
                              R"("timeout_s":400})",
                              rig),
                      "/steps/0/speed_mm_s"),
              testing::StartsWith("0."));
}

TEST(Plan, ASearchThatIsSlowedDownStillNamesItsSpeed) {
  const auto search = [](const std::string& speed, const std::string& timeout_s) {
    return R"({"id":"c","do":"find_contact","speed_mm_s":)" + speed +
           R"(,"force_N":0.02,"back_off_mm":0.1,"slow_down":true,"overshoot_mN":0.1,)"
           R"("timeout_s":)" +
           timeout_s + "}";
  };
  // The search is slowed down for the limit, but not for the step's own allowance.
  const std::string text = refusal(search("2", "60"), frame_rig());
  EXPECT_THAT(text, HasSubstr("the step allows 0.0001 N"));
  const std::string speed = advised(text, "/steps/0/speed_mm_s");
  EXPECT_EQ(speed, "0.00163");
  EXPECT_EQ(refusal(search(speed, advised(text, "/steps/0/timeout_s")), frame_rig()), "planned");

  std::string named = with_steps(search(R"("$v_mm_s")", "4000"));
  named.insert(1, R"("parameters":{"v_mm_s":{"default":2,"min":0.0001,"max":9}},)");
  EXPECT_THAT(plan_of(parse_protocol(named, "t.json").value(), frame_rig()).error().what,
              HasSubstr("(-p v_mm_s=0.00163)"));
}

TEST(Plan, ANumberThatStandsNowhereIsNothingToChange) {
  const Protocol protocol = load_protocol("protocols/library/creep.json").value();
  const Environment environment;
  EXPECT_THAT(at_most(Number(1e-3), 1e-4, Asked{protocol, environment}), IsEmpty());
  EXPECT_THAT(at_least(Number(1e-3), 1e-2, Asked{protocol, environment}), IsEmpty());
}

TEST(Plan, AStepOfTwoMotionsTakesAsLongAsBoth) {
  const Protocol protocol =
      parse_protocol(with_steps(R"({"id":"m","do":"measure","count":1,"within_s":5})"), "t.json")
          .value();
  const Environment environment;
  const Rig rig = frame_rig();
  Plan plan;
  PlannedRig planned(protocol, environment, rig,
                     bind_limits(protocol, environment, rig.frame).value(), plan);
  StepPlan out;
  const Number timeout(100), speed(1e-3);
  PlannedMotion motion(planned, timeout, out);
  Target to;
  to.kind = TargetKind::travel;
  to.value = Number(-1e-3);  // 2 mm from where the frame is assumed to stand
  motion.to_travel(to, speed);
  to.value = Number(-2e-3);
  motion.to_travel(to, speed);
  EXPECT_NEAR(out.seconds, 3, 1e-9);
}

// A file cannot express this: a travel that is held asks nothing of the frame.
TEST(Plan, AStepThatMovesThoughItsFactsDenyItIsABug) {
  Protocol protocol =
      parse_protocol(with_steps(R"({"id":"h","do":"hold","hold":"force","force_N":1,"for_s":1})"),
                     "t.json")
          .value();
  ASSERT_TRUE(plan_of(protocol, frame_rig()));
  auto hold = protocol.steps.front().action->copy();
  dynamic_cast<HoldStep&>(*hold).mode = HoldMode::travel;
  protocol.steps.front().action = hold;
  const auto plan = plan_of(protocol, frame_rig());
  ASSERT_FALSE(plan);
  EXPECT_THAT(plan.error().what, HasSubstr("/steps/0 (h): a bug: its plan moves the frame"));
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
  // 20 ms more: 60e3 * (0.3e-3 * 21e-3 + 0.09e-6 / 0.1) = 0.432 N; without them 0.072 N.
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

TEST(Plan, AFastWayToASmallGapSaysWhatAFaceThatCameUpWouldFeel) {
  Rig rig = frame_rig();
  rig.start_travel = Length::from_si(-5e-3);
  rig.start_gap = 5.0_mm;
  const auto plan = plan_steps(
      R"({"id":"s","do":"ramp","to":{"gap_mm":0.01},"speed_mm_s":1,"timeout_s":700})", rig);
  ASSERT_TRUE(plan) << plan.error().what;
  // The device stops at the limit of 1.5 N: 60e3 * (1e-3 * 1e-3 + 1e-6 / 0.1) = 0.66 N beyond.
  EXPECT_THAT(plan->steps.at(0).note,
              HasSubstr("a face that has come up by more than 0.01 mm: up to 2.16 N"));
  EXPECT_THAT(plan->assumptions, testing::Contains(HasSubstr("face has not come up")));
}

}  // namespace
}  // namespace lcrig
