// SPDX-License-Identifier: Apache-2.0
#include "protocols/plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "protocols/parse.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

LcrCapabilities meter() {
  LcrCapabilities c;
  c.functions = {LcrFunction::CpD, LcrFunction::CpRp};
  c.frequency_min = 10.0_Hz;
  c.frequency_max = 100.0_kHz;
  c.level_min = 0.01_V;
  c.level_max = 2.0_V;
  c.bias_min = Voltage::from_si(-2);
  c.bias_max = 2.0_V;
  c.average_max = 256;
  c.conversion[0] = 65ms;
  c.conversion[1] = 120ms;
  c.conversion[2] = 380ms;
  return c;
}

// A 4 mm tip on a specimen of 60 N/mm.
Rig frame_rig() {
  Rig rig;
  rig.lcr = meter();
  FrameCapabilities& f = rig.frame;
  f.motion = f.force_hold = f.device_stop = f.zero_force = f.zero_travel = true;
  f.force_max = 20.0_N;
  f.speed_min = Velocity::from_si(1e-8);
  f.speed_max = 10.0_mm_s;
  f.travel_min = Length::from_si(-0.1);
  f.travel_max = Length::from_si(0.1);
  f.sample_rate_max_Hz = 1000;
  f.reaction = 1ms;
  f.deceleration = 0.05_m_s2;
  f.force_loop.emplace();
  f.force_loop->approach = 0.1_mm_s;
  f.force_loop->contact = Force::from_si(0.005);
  f.force_loop->rate_max = 10.0_N_s;
  f.force_loop->lag = 10ms;
  f.force_loop->ripple = Force::from_si(0.002);
  f.force_loop->stiffness_max = 1000.0_N_mm;
  rig.expected_contact = Length();
  rig.frame_stiffness_N_m = 60e3;
  rig.probe_area = Area::from_si(std::numbers::pi * 4e-6);
  rig.compression_m = [](double force) { return force / 60e3; };
  return rig;
}

Rig weights_rig() {
  Rig rig = frame_rig();
  rig.frame = FrameCapabilities();
  rig.frame.weights = true;
  rig.frame.travel_channel = false;
  rig.compression_m = nullptr;
  return rig;
}

Result<Plan> plan_of(const Protocol& p, const Rig& rig,
                     const std::map<std::string, std::string>& overrides = {}) {
  const auto env = bind_parameters(p, overrides);
  if (!env) return fail(env.error());
  return make_plan(p, *env, rig);
}
Result<Plan> shipped(const std::string& name, const Rig& rig,
                     const std::map<std::string, std::string>& overrides = {}) {
  const auto p = load_protocol("protocols/library/" + name + ".json");
  if (!p) return fail(p.error());
  return plan_of(*p, rig, overrides);
}

// A protocol of the steps given, in a rig with motion.
std::string with_steps(const std::string& steps, const std::string& aperture = "fast") {
  return R"({"format":"load-protocol/1","name":"t","limits":{"force_N":[-0.2,1.5],"travel_mm":[-5,1]},
"sample":{"lcr":{"function":"Cp-D","frequency_Hz":1000,"level_V":1,"aperture":")" +
         aperture + R"("}},
"steps":[)" +
         steps + R"(],
"finally":[{"id":"clear","do":"ramp","to":{"travel_mm":-5},"speed_mm_s":1,"timeout_s":60}]})";
}
Result<Plan> plan_steps(const std::string& steps, const Rig& rig,
                        const std::string& aperture = "fast") {
  const auto p = parse_protocol(with_steps(steps, aperture), "t.json");
  if (!p) throw std::runtime_error(p.error().what);
  return plan_of(*p, rig);
}
std::string refusal(const std::string& steps, const Rig& rig,
                    const std::string& aperture = "fast") {
  const auto r = plan_steps(steps, rig, aperture);
  if (r) return "planned";
  EXPECT_EQ(r.error().code, Errc::invalid_request);
  return r.error().what;
}

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
            "t:3:10 /steps/0 (m): 30 readings in 10 s need a conversion of at most 333 ms; "
            "aperture slow takes 380 ms: use medium (/steps/0/within_s: 11.4)");
  EXPECT_EQ(refusal(step, frame_rig(), "medium"), "planned");
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
  EXPECT_EQ(
      refusal(load(R"(,"overshoot_N":0.1,"final_speed_mm_s":0.05,"final_from":0.5)"), frame_rig()),
      "planned");
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

TEST(Plan, ATimeoutShorterThanTheWayIsRefused) {
  EXPECT_THAT(
      refusal(R"({"id":"l","do":"ramp","to":{"travel_mm":-0.5},"speed_mm_s":0.01,"timeout_s":100})",
              frame_rig()),
      HasSubstr("takes 250 s (2.5 mm at 0.01 mm/s"));
}

TEST(Plan, WhatTheRigCannotDoIsRefused) {
  EXPECT_THAT(shipped("dynamic-cycles", weights_rig()).error().what,
              HasSubstr("zero of the force, which this rig cannot do"));
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
