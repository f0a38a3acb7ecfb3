// SPDX-License-Identifier: Apache-2.0
#include "budget/planned_run.hpp"

#include <gtest/gtest.h>

#include "tests/unit/protocols/planned.hpp"

namespace lcrig {
namespace {

PlannedRun readings_of(const std::string& steps) {
  const auto protocol = parse_protocol(with_steps(steps), "t.json");
  if (!protocol) throw std::runtime_error(protocol.error().what);
  const auto plan = plan_of(*protocol, frame_rig());
  if (!plan) throw std::runtime_error(plan.error().what);
  SpecimenCurve curve;
  curve.c0_F = 4e-12;
  curve.delta_C_fF = [](double kPa) { return 2 * kPa; };
  auto run = plan_readings(*protocol, Environment(), frame_rig(), *plan, curve);
  if (!run) throw std::runtime_error(run.error().what);
  return *run;
}

// The run labels its levels with the forces that are held, and so does the budget.
TEST(PlannedRunOf, AHoldThatGoesToItsForceMakesALevel) {
  const std::string ramp = R"({"id":"l","do":"ramp","to":{"force_N":0.4},"force_rate_N_s":0.1,
                               "timeout_s":60},)",
                    first = R"({"id":"h1","do":"hold","hold":"force","for_s":1},
                               {"id":"m1","do":"measure","count":10,"within_s":10},)",
                    second = R"({"id":"h2","do":"hold","hold":"force","force_N":0.8,"for_s":1},
                                {"id":"m2","do":"measure","count":10,"within_s":10})";
  const PlannedRun run = readings_of(ramp + first + second);
  ASSERT_EQ(run.levels.size(), 2U);
  const double kPa_per_N = 1e-3 / run.area_m2;
  EXPECT_NEAR(run.levels[0].pressure_kPa, 0.4 * kPa_per_N, 1e-9);
  EXPECT_NEAR(run.levels[1].pressure_kPa, 0.8 * kPa_per_N, 1e-9);
  ASSERT_EQ(run.cycles.size(), 1U);
  EXPECT_NEAR(run.cycles[0].peak_kPa, 0.8 * kPa_per_N, 1e-9);
}

// Of 0.02 and 0.8 N the first is below a twentieth of the largest: no loading, but a level.
TEST(PlannedRunOf, ALevelBelowTheEdgeOfACycleIsOne) {
  const std::string levels = R"({"id":"g","do":"set_gap","gap_mm":0.1},
        {"id":"pass","do":"repeat","count":2,"steps":[
        {"id":"low","do":"ramp","to":{"force_N":0.02},"force_rate_N_s":0.1,"timeout_s":60},
        {"id":"m1","do":"measure","count":10,"within_s":10},
        {"id":"high","do":"ramp","to":{"force_N":0.8},"force_rate_N_s":0.1,"timeout_s":60},
        {"id":"m2","do":"measure","count":10,"within_s":10},
        {"id":"up","do":"ramp","to":{"gap_mm":0.1},"speed_mm_s":0.05,"timeout_s":60},
        {"id":"rest","do":"hold","hold":"travel","for_s":5}]})";
  const PlannedRun run = readings_of(levels);
  ASSERT_EQ(run.levels.size(), 4U);
  const double kPa_per_N = 1e-3 / run.area_m2;
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(run.levels[k].pressure_kPa, (k % 2 == 0 ? 0.02 : 0.8) * kPa_per_N, 1e-9);
    EXPECT_EQ(run.levels[k].repeat, k < 2 ? 1 : 2);
  }
  EXPECT_EQ(run.cycles.size(), 2U);
}

TEST(PlannedRunOf, StepsInsideOfLoopsGetTheTimeThatTheirReadingsTake) {
  const auto protocol = parse_protocol(with_steps(R"({"id":"r","do":"repeat","count":2,"steps":[
        {"id":"s","do":"sweep","name":"n","values":[1,2],"steps":[
          {"id":"m","do":"measure","count":10,"within_s":1}]}]})"),
                                       "t.json");
  ASSERT_TRUE(protocol) << protocol.error().what;
  const Variant slow = with_settings(*protocol, Environment(), frame_rig(), Aperture::slow,
                                     Frequency::from_si(1000));
  EXPECT_EQ(slow.note, "within_s of step m must be 3.9");  // 10 of 380 ms, and 2 %
  EXPECT_FALSE(slow.by_parameters);
  const Steps& inside = facts_of(slow.protocol.steps[0]).loop->steps;
  const Readings* measure = facts_of(facts_of(inside[0]).loop->steps[0]).measures;
  EXPECT_DOUBLE_EQ(measure->within.value, 3.9);
}

}  // namespace
}  // namespace lcrig
