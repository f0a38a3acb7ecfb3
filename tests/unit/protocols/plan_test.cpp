// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/protocols/planned.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

TEST(Plan, StaticFrameTakes1680Readings) {
  const auto plan = shipped("static-frame", frame_rig());
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_EQ(plan->measure_readings, 14 * 30 * 4);
  EXPECT_NEAR(plan->peak_force_N, 1.2566, 1e-3);
  // 56 levels of 10 s and 1 s, four rests, ramps of 1.26 N at 0.1 N/s in each pass.
  EXPECT_NEAR(plan->duration_s, 56 * 11 + 4 * (5 + 12.6 + 2) + 60, 60);
}

TEST(Plan, StaticWeightsTakes1680ReadingsAndSaysTheMasses) {
  const auto plan = shipped("static-weights", weights_rig());
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_EQ(plan->measure_readings, 1680);
  EXPECT_EQ(plan->steps.at(2).id, "place");
  EXPECT_EQ(plan->steps.at(2).times, 56);
  EXPECT_THAT(plan->steps.at(2).note, HasSubstr("12.81 g = 0.1257 N"));
}

TEST(Plan, DynamicCyclesLastTwentySixMinutes) {
  const auto plan = shipped("dynamic-cycles", frame_rig());
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_GT(plan->duration_s, 10 * 2.5 / 0.016);
  EXPECT_LT(plan->duration_s, 10 * 2.6 / 0.016 + 200);
  EXPECT_DOUBLE_EQ(plan->peak_force_N, 1.0);
  EXPECT_NEAR(plan->travel_max_m, 1.0 / 60e3, 1e-9);
  EXPECT_NEAR(plan->travel_min_m, -5e-3, 1e-9);
  EXPECT_EQ(plan->lcr.aperture, Aperture::fast);
  EXPECT_EQ(plan->frame_samples, static_cast<std::int64_t>(plan->duration_s * 50));
}

TEST(Plan, EveryShippedProtocolIsPossibleOnItsRig) {
  for (const char* name :
       {"static-frame", "dynamic-cycles", "preconditioning", "creep", "follow"}) {
    const auto plan = shipped(name, frame_rig());
    EXPECT_TRUE(plan) << plan.error().what;
  }
}

TEST(Plan, LoopsAreSummarised) {
  const auto plan = shipped("dynamic-cycles", frame_rig(), {{"cycles", "100000"}});
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_EQ(plan->steps.size(), 6U);
  EXPECT_EQ(plan->steps.at(3).id, "load");
  EXPECT_EQ(plan->steps.at(3).times, 100000);
}

TEST(Plan, SlowIsRefusedForThirtyReadingsInTenSeconds) {
  const std::string step = R"({"id":"m","do":"measure","count":30,"within_s":10})";
  EXPECT_EQ(refusal(step, frame_rig(), "slow"),
            "t.json:3:10 /steps/0 (m): 30 readings in 10 s need a conversion of at most 333 ms; "
            "aperture slow takes 380 ms: use medium (/steps/0/within_s: 12)");
  EXPECT_EQ(refusal(step, frame_rig(), "medium"), "planned");
}

// Before this was refused, the run ended with a fault after the specimen was loaded.
TEST(Plan, AMeterThatIsPolledTooSeldomForALevelIsRefused) {
  LcrSettings polled;
  polled.aperture = Aperture::fast;
  polled.trigger = LcrTrigger::internal;
  polled.poll_interval = std::chrono::milliseconds(400);
  EXPECT_FALSE(check_measure(10, 4, polled, meter()));
  const auto why = check_measure(20, 4, polled, meter());
  ASSERT_TRUE(why);
  EXPECT_THAT(*why, HasSubstr("need one every 200 ms, the meter is polled every 400 ms"));
}

TEST(Plan, AveragingLengthensTheConversion) {
  const auto what = refusal(R"({"id":"s","do":"set_lcr","average":10},
{"id":"m","do":"measure","count":30,"within_s":10})",
                            frame_rig(), "fast");
  EXPECT_THAT(what, HasSubstr("aperture fast with 10 averages takes 650 ms: use fewer averages"));
}

TEST(Plan, AutoIsTheSlowestApertureThatFits) {
  const auto chosen = [](const std::string& count) {
    const auto plan = plan_steps(R"({"id":"m","do":"measure","within_s":10,"count":)" + count + "}",
                                 frame_rig(), "auto");
    EXPECT_TRUE(plan) << plan.error().what;
    return *plan;
  };
  EXPECT_EQ(chosen("26").lcr.aperture, Aperture::slow);
  EXPECT_EQ(chosen("30").lcr.aperture, Aperture::medium);
  EXPECT_EQ(chosen("100").lcr.aperture, Aperture::fast);
  EXPECT_EQ(chosen("30").aperture_note,
            "medium: 30 readings in 10 s (m) need a conversion of at most 333 ms; it takes 120 ms");
}

TEST(Plan, AutoLooksAtTheLoadedPartOfACycle) {
  const std::string load =
      R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":0.016,"timeout_s":400})";
  const auto plan = plan_steps(load, frame_rig(), "auto");
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_EQ(plan->lcr.aperture, Aperture::medium);  // 2.08 s / 15 = 138 ms
  EXPECT_THAT(plan->aperture_note, HasSubstr("15 readings in the loaded part of 2.08 s (l)"));
  Rig unknown = frame_rig();
  unknown.compression_m = nullptr;
  const auto blind = plan_steps(load, unknown, "auto");
  ASSERT_TRUE(blind) << blind.error().what;
  EXPECT_EQ(blind->lcr.aperture, Aperture::fast);
  EXPECT_FALSE(blind->assumptions.empty());
}

std::string assumptions_of(const Plan& plan) {
  std::string out;
  for (const std::string& text : plan.assumptions) out += text + "; ";
  return out;
}

TEST(Plan, TheClassOfTheCellIsStatedOrAssumedInWords) {
  const std::string load =
      R"({"id":"l","do":"move_until","until":{"force_N":1},"speed_mm_s":0.016,"timeout_s":400})";
  Rig rig = frame_rig();
  const auto unknown = plan_steps(load, rig, "fast");
  ASSERT_TRUE(unknown) << unknown.error().what;
  EXPECT_THAT(assumptions_of(*unknown), HasSubstr("load cell of class 1 (ISO 7500-1)"));
  EXPECT_DOUBLE_EQ(unknown->force_uncertainty.zero_N, 0.02);
  for (const double percent : kForceClasses) {
    rig.frame.force_class = ForceClass(percent);
    const auto stated = plan_steps(load, rig, "fast");
    ASSERT_TRUE(stated) << stated.error().what;
    EXPECT_THAT(assumptions_of(*stated), testing::Not(HasSubstr("ISO 7500-1")));
    EXPECT_DOUBLE_EQ(stated->force_uncertainty.zero_N, 20 * percent / 1000);
    EXPECT_DOUBLE_EQ(stated->force_uncertainty.class_N, 1.5 * percent / 100);
  }
}

TEST(Plan, ForceBeyondTheLimitIsRefused) {
  EXPECT_THAT(
      refusal(
          R"({"id":"l","do":"move_until","until":{"force_N":1.8},"speed_mm_s":0.1,"timeout_s":400})",
          frame_rig()),
      HasSubstr("/steps/0 (l): a force of 1.8 N, the limits allow -0.2 to 1.5 N"));
  EXPECT_THAT(
      refusal(R"({"id":"h","do":"hold","hold":"force","pressure_kPa":200,"for_s":1})", frame_rig()),
      HasSubstr("a force of 2.513 N"));
}

TEST(Plan, TravelIntoTheSpecimenIsAForce) {
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":0.03},"speed_mm_s":0.1,"timeout_s":400})",
              frame_rig()),
      HasSubstr("a force of 1.8 N"));
}

TEST(Plan, TravelBeyondTheLimitsOrTheFrameIsRefused) {
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":-6},"speed_mm_s":0.1,"timeout_s":400})",
              frame_rig()),
      HasSubstr("a travel of -6 mm, the limits allow -5 to 1 mm"));
  Rig rig = frame_rig();
  rig.frame.travel_min = Length::from_si(-1e-3);
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":-2},"speed_mm_s":0.1,"timeout_s":400})",
              rig),
      HasSubstr("a limit of -5 mm, this frame goes from -1 to 100 mm"));
}

TEST(Plan, SpeedBeyondTheFrameIsRefused) {
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":-1},"speed_mm_s":20,"timeout_s":400})",
              frame_rig()),
      HasSubstr("a speed of 20 mm/s, the frame moves at 1e-05 to 10 mm/s"));
}

TEST(Plan, AGapNeedsContactFirst) {
  const std::string gap =
      R"({"id":"g","do":"ramp","to":{"gap_mm":1},"speed_mm_s":0.1,"timeout_s":400})";
  EXPECT_THAT(refusal(gap, frame_rig()), HasSubstr("a gap before find_contact"));
  Rig stated = frame_rig();
  stated.start_gap = 2.0_mm;
  EXPECT_EQ(refusal(gap, stated), "planned");
  EXPECT_EQ(refusal(R"({"id":"c","do":"find_contact","speed_mm_s":0.05,"force_N":0.02,)"
                    R"("back_off_mm":1,"timeout_s":300},)" +
                        gap,
                    frame_rig()),
            "planned");
}

TEST(Plan, ATimeoutShorterThanTheWayIsRefused) {
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":-0.5},"speed_mm_s":0.01,"timeout_s":100})",
              frame_rig()),
      HasSubstr("takes 250 s (2.5 mm at 0.01 mm/s"));
}

TEST(Plan, WhatTheRigCannotDoIsRefused) {
  for (const char* moving : {"dynamic-cycles", "static-frame"}) {  // these begin with `zero`
    EXPECT_THAT(shipped(moving, weights_rig()).error().what,
                AllOf(HasSubstr("zero of the force, which this rig cannot do"),
                      HasSubstr("load with place_weight, as static-weights does")));
  }
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":0},"speed_mm_s":1,"timeout_s":9})",
              weights_rig()),
      HasSubstr("ramp needs a frame that moves; this rig has dead weights: use place_weight"));
  EXPECT_THAT(shipped("static-weights", frame_rig()).error().what,
              HasSubstr("(empty): place_weight needs a dead-weight rig"));
  Rig no_loop = frame_rig();
  no_loop.frame.force_hold = false;
  EXPECT_THAT(refusal(R"({"id":"h","do":"hold","hold":"force","for_s":1})", no_loop),
              HasSubstr("holding a force needs a force loop"));
}

// The frame would refuse it during the run (docs/frame-link.md: contact required).
TEST(Plan, AForceIsHeldInContactOnly) {
  const std::string gap = R"({"id":"g","do":"set_gap","gap_mm":2},)",
                    hold = R"({"id":"h","do":"hold","hold":"force","force_N":1,"for_s":1})",
                    load = R"({"id":"l","do":"ramp","to":{"force_N":0.9},"force_rate_N_s":0.1,
                               "timeout_s":60},)";
  EXPECT_THAT(refusal(gap + hold, frame_rig()),
              HasSubstr("holding a force needs contact, and the specimen is 2 mm away here"));
  EXPECT_EQ(refusal(gap + load + hold, frame_rig()), "planned");
}

TEST(Plan, WhatTheMeterCannotDoIsRefused) {
  const auto set = [](const std::string& what) {
    return refusal(R"({"id":"s","do":"set_lcr",)" + what + "}", frame_rig());
  };
  EXPECT_THAT(set(R"("frequency_kHz":200)"),
              HasSubstr("a frequency of 200000 Hz, the meter offers 10 to 100000 Hz"));
  EXPECT_THAT(set(R"("level_V":5)"), HasSubstr("a level of 5 V, the meter offers 0.01 to 2 V"));
  EXPECT_THAT(set(R"("bias_V":5)"), HasSubstr("a bias of 5 V"));
  EXPECT_THAT(set(R"("function":"R-X")"), HasSubstr("the function R-X, which this meter"));
}

TEST(Plan, LimitsBoundByParametersMustStayInOrder) {
  const auto text = with_steps(R"({"id":"r","do":"record","for_s":1})");
  std::string bad = text;
  bad.replace(bad.find("[-0.2,1.5]"), 10, R"([-0.2,"$f_N"],"speed_mm_s":1)");
  bad.replace(bad.find("\"name\""), 0, R"("parameters":{"f_N":{"default":1,"min":-1,"max":2}},)");
  const auto p = parse_protocol(bad, "t.json");
  ASSERT_TRUE(p) << p.error().what;
  EXPECT_TRUE(plan_of(*p, frame_rig()));
  EXPECT_THAT(plan_of(*p, frame_rig(), {{"f_N", "-0.5"}}).error().what,
              HasSubstr("expected the lower limit first"));
}

TEST(Plan, FinallyMustFitItsTimeout) {
  auto p = parse_protocol(with_steps(R"({"id":"r","do":"record","for_s":1})"), "t.json");
  ASSERT_TRUE(p);
  p->finally_timeout = 1s;
  EXPECT_THAT(plan_of(*p, frame_rig()).error().what, HasSubstr("finally_timeout_s is 1"));
}

TEST(Plan, EndlessRepeatsAreRefused) {
  EXPECT_THAT(refusal(R"({"id":"a","do":"repeat","count":1000000,"steps":[
    {"id":"b","do":"repeat","count":1000000,"steps":[{"id":"m","do":"mark","text":"x"}]}]})",
                      frame_rig()),
              HasSubstr("more than 2000000 steps"));
}

TEST(Plan, JsonHasThePromisedNames) {
  const auto plan = shipped("static-frame", frame_rig());
  ASSERT_TRUE(plan);
  const auto j = to_json(*plan);
  EXPECT_EQ(j.at("measure_readings"), 1680);
  EXPECT_TRUE(j.at("duration_s").is_number());
  EXPECT_TRUE(j.at("peak_force_N").is_number());
  EXPECT_EQ(j.at("travel_mm").size(), 2U);
  EXPECT_EQ(j.at("steps").at(0).at("id"), "zero");
  EXPECT_GT(j.at("database_bytes"), 100'000);
  EXPECT_EQ(j.at("frame_rate_Hz"), 50);
}

TEST(Plan, AFrameThatReportsNoTravelIsNotMoved) {
  const std::string step =
      R"({"id":"s","do":"ramp","to":{"travel_mm":-1},"speed_mm_s":0.1,"timeout_s":60})";
  EXPECT_EQ(refusal(step, frame_rig()), "planned");
  Rig rig = frame_rig();
  rig.frame.travel_channel = false;
  EXPECT_NE(refusal(step, rig).find("reports no travel"), std::string::npos);
  rig = frame_rig();
  rig.frame.force_channel = false;
  EXPECT_NE(refusal(step, rig).find("reports no force"), std::string::npos);
}

TEST(Plan, AFrameThatIsSlowerThanItsFamilyIsAskedForNoMore) {
  const std::string step =
      R"({"id":"s","do":"ramp","to":{"travel_mm":-1},"speed_mm_s":0.1,"timeout_s":60})";
  Rig rig = frame_rig();
  rig.frame.speed_max = 0.05_mm_s;
  const std::string why = refusal(step, rig);
  EXPECT_NE(why.find("a speed of 0.1 mm/s, the frame moves at 1e-05 to 0.05 mm/s"),
            std::string::npos)
      << why;
}

}  // namespace
}  // namespace lcrig
