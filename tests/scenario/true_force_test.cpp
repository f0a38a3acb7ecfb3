// SPDX-License-Identifier: Apache-2.0
// How the force on the specimen could exceed what the protocol allows without tripping a limit: two
// speeds, repeated zeros, and a bench beyond its model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/rig/bench_door.hpp"
#include "drivers/zwick/sim.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

// kLoad, whose measurement at 0.5 N is followed by these steps.
std::string load_then(const std::string& steps) {
  return with(kLoad, R"("within_s": 4 } ])", R"("within_s": 4 }, )" + steps + " ]");
}

std::string two_speeds(double force_N) {
  return load_then(fmt::format(
      R"({{ "id": "two", "do": "move_until", "until": {{ "force_N": {} }}, "speed_mm_s": 0.01,)"
      R"( "final_speed_mm_s": 0.002, "final_from": 0.7, "timeout_s": 60 }})",
      force_N));
}

// A figure of the samples during step `two`.
double while_two(const SessionWorld& world, const std::string& of_force) {
  const auto at = [](const std::string& kind) {
    return "(SELECT at_mono_ns FROM event WHERE step_id = 'two' AND kind = '" + kind + "')";
  };
  return world.real("SELECT " + of_force + " FROM frame_sample WHERE received_mono_ns BETWEEN " +
                    at("step_begin") + " AND " + at("step_end"));
}

std::int64_t motions_of_two(const SessionWorld& world) {
  return world.count("SELECT COUNT(*) FROM event WHERE step_id = 'two' AND kind = 'motion'");
}

TEST(TrueForce, UnloadingWithTwoSpeedsEndsAtItsForceAndNotBelow) {
  SessionWorld world(two_speeds(0.3));
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(motions_of_two(world), 2);
  EXPECT_GT(while_two(world, "MIN(force_N)"), 0.28);
  EXPECT_LT(while_two(world, "MAX(force_N)"), 0.52) << "it does not press again";
}

TEST(TrueForce, LoadingOnWithTwoSpeedsDoesNotGoBackFirst) {
  SessionWorld world(two_speeds(0.6));  // seven tenths of that are reached already
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(motions_of_two(world), 1);
  EXPECT_GT(while_two(world, "MIN(force_N)"), 0.48);
  EXPECT_NEAR(while_two(world, "MAX(force_N)"), 0.6, 0.03);
}

// Presses to 0.4 N as the cell shows it, and zeroes there, again and again. The limit is 1 N.
TEST(TrueForce, ZerosUnderLoadDoNotMoveTheLimitAgainAndAgain) {
  const std::string zeros = load_then(
      R"({ "id": "again", "do": "repeat", "count": 5, "steps": [)"
      R"( { "id": "press", "do": "move_until", "until": { "force_N": 0.4 }, "speed_mm_s": 0.002,)"
      R"( "timeout_s": 60 }, { "id": "tare", "do": "zero", "force": true } ] })");
  SessionWorld world(zeros);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_EQ(r->code, Errc::limit_tripped);
  EXPECT_THAT(r->reason, HasSubstr("the zeros of this run"));
  EXPECT_LE(world.real("SELECT SUM(json_extract(detail, '$.force_before_N')) FROM event "
                       "WHERE kind = 'zero'"),
            1.0);
  EXPECT_GT(world.count("SELECT COUNT(*) FROM event WHERE kind = 'zero' AND step_id = 'tare'"), 1)
      << "one zero is allowed";
}

// Without load the cell then shows the negative of the force that the zero hid. This is not a pull.
TEST(TrueForce, AZeroUnderLoadLeavesTheSpecimenUnloaded) {
  SessionWorld world(load_then(R"({ "id": "tare", "do": "zero", "force": true })"));
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_LT(world.real("SELECT MIN(force_N) FROM frame_sample"), -0.4) << "it was zeroed at 0.5 N";
  const Plant& plant = *world.session->instruments().door()->plant();
  EXPECT_EQ(plant.force_N(world.clock.now()), 0);
}

// The cell is zeroed at 0.5 N, and its force falls further when the probe is clear.
TEST(TrueForce, AZeroUnderLoadHidesNoPull) {
  SessionWorld world(load_then(R"({ "id": "tare", "do": "zero", "force": true })"));
  world.acts.push_back({"clear", 3s, [](SessionWorld& w) {
                          ZwickSim& frame = *w.session->instruments().door()->frame_sim();
                          frame.faults.lies.force_drift_N_s = -0.3;
                          frame.poke();
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_LT(world.real("SELECT MIN(force_N) FROM frame_sample"), -0.7);
}

// A cell that drifts is zeroed before each of many cycles.
TEST(TrueForce, ZerosOfACellThatDriftsAreNotRefused) {
  const std::string often = with(
      kLoad, R"({ "id": "contact")",
      R"({ "id": "often", "do": "repeat", "count": 40, "steps": [ { "id": "tare", "do": "zero",)"
      R"( "force": true } ] }, { "id": "contact")");
  SessionWorld world(often);
  world.bench.plant.force_offset_N = 0.15;
  world.bench.plant.force_drift_N_s = 2e-4;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind = 'zero'"), 41);
}

TEST(TrueForce, ABenchBeyondItsModelSaysSo) {
  const std::string text = with(kLoad, R"("until": { "force_N": 0.5 }, "speed_mm_s": 0.01)",
                                R"("until": { "force_N": 0.9 }, "speed_mm_s": 0.1)");
  const std::string said = "SELECT detail FROM event WHERE kind = 'extrapolated'";
  SessionWorld within(text);
  ASSERT_TRUE(within.run());
  EXPECT_EQ(within.text(said), "");
  SessionWorld beyond(text);  // its table ends at the limit, 1 N; the device's own stop is late
  beyond.acts.push_back({"load", 10ms, [](SessionWorld& w) {
                           ZwickSim& frame = *w.session->instruments().door()->frame_sim();
                           frame.faults.late_stop_s = 0.3;
                           frame.poke();
                         }});
  ASSERT_TRUE(beyond.run());
  EXPECT_THAT(beyond.text(said), HasSubstr("reckoned up to 1 N only"));
}

TEST(TrueForce, ABenchBeyondItsModelSaysSoThoughTheCellShowsLess) {
  SessionWorld world(with(kLoad, R"("until": { "force_N": 0.5 }, "speed_mm_s": 0.01)",
                          R"("until": { "force_N": 0.7 }, "speed_mm_s": 0.01)"));
  world.bench.plant.force_gain = 0.5;
  ASSERT_TRUE(world.run());
  EXPECT_LT(world.real("SELECT MAX(force_N) FROM frame_sample"), 1);
  EXPECT_THAT(world.text("SELECT detail FROM event WHERE kind = 'extrapolated'"),
              HasSubstr("the bench went to 1.4"));
}

}  // namespace
}  // namespace lcrig
