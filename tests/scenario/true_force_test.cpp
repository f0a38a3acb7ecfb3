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
  EXPECT_THAT(beyond.text(said), HasSubstr("computed up to 1 N only"));
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

// A gel of 1 mm that is pressed to five times its modulus: at the force where it is flat, it is
// stiffer than one that cannot move sideways, which has been pressed less deep.
constexpr const char* kGel = R"({ "format": "specimen/1", "name": "gel", "disc_diameter_mm": 4,
  "faces": "free", "materials": { "P": { "relative_permittivity": 2.75,
  "youngs_modulus_kPa": 23.602, "poisson_ratio": 0.45 } },
  "capacitors": [ { "layers": [ { "material": "P", "thickness_um": 1000 } ] } ] })";
constexpr const char* kGelBench = R"({ "format": "bench/1", "name": "gel", "error_tolerance": 0.01,
  "fixture": { "probe_diameter_mm": 4 }, "frame": { "contact_travel_mm": 0.3452,
  "stiffness_N_mm": 28.54, "drive_lag_ms": 1.53, "deceleration_mm_s2": 5.34,
  "travel_resolution_um": 0.1, "force_noise_mN": 0.5, "rate_max_Hz": 50 }, "meter": {} })";
constexpr double kGelLimit_N = 1.5;

class GelWorld final : public SessionWorld {
 public:
  GelWorld(const std::string& speed_mm_s, std::int64_t with_seed)
      : SessionWorld(fmt::format(
            R"({{ "format": "load-protocol/1", "name": "gel", "limits": {{)"
            R"( "force_N": [-0.3, {}], "gap_mm": [-3, 4], "speed_mm_s": 5 }},)"
            R"( "sample": {{ "lcr": {{ "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1,)"
            R"( "aperture": "fast" }}, "frame": {{ "rate_Hz": 50 }} }}, "steps": [)"
            R"( {{ "id": "zero", "do": "zero", "force": true }},)"
            R"( {{ "id": "contact", "do": "find_contact", "speed_mm_s": 0.0248, "force_N": 0.08,)"
            R"( "back_off_mm": 0.217, "timeout_s": 600, "within_mm": 2 }},)"
            R"( {{ "id": "load", "do": "move_until", "speed_mm_s": {}, "timeout_s": 600,)"
            R"( "until": {{ "force_N": 0.754 }} }} ],)"
            R"( "finally": [ {{ "id": "clear", "do": "ramp", "to": {{ "gap_mm": 1 }},)"
            R"( "speed_mm_s": 0.3, "timeout_s": 250 }} ] }})",
            kGelLimit_N, speed_mm_s)),
        seed_(with_seed) {
    bench = *parse_bench(kGelBench, "gel");
    specimen_name = "gel";
    specimen_text = kGel;
  }
  double peak_N() const {
    return session->instruments().door()->plant()->peak_answered_N(clock.now());
  }

 private:
  void adjust(SimRequest& sim, Recorder::Options& /*recorder*/) override { sim.seed = seed_; }
  std::int64_t seed_;
};

TEST(TrueForce, OfASoftSpecimenThatIsPressedFlatStaysWithinTheLimit) {
  const auto refused = GelWorld("1.3", 1).run();
  ASSERT_FALSE(refused) << "it pressed 1.75 N";
  const std::string words = refused.error().what, place = "/steps/2/speed_mm_s: ";
  ASSERT_THAT(words, HasSubstr(place));
  const auto begin = words.find(place) + place.size();
  const std::string speed = words.substr(begin, words.find_first_of(",)", begin) - begin);
  EXPECT_GT(std::stod(speed), 0.5) << words;
  for (std::int64_t seed = 1; seed <= 3; ++seed) {
    GelWorld world(speed, seed);
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    const double uncertainty_N = world.real(
        "SELECT json_extract(detail, '$.force_uncertainty_N') FROM event "
        "WHERE kind = 'plan'");
    EXPECT_LT(world.peak_N(), kGelLimit_N + uncertainty_N);
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind = 'overshoot' AND "
                          "json_extract(detail, '$.predicted_N') < "
                          "json_extract(detail, '$.expected_N')"),
              0);
    EXPECT_GT(world.count("SELECT COUNT(*) FROM event WHERE kind = 'overshoot' AND "
                          "json_extract(detail, '$.expected_N') > 0"),
              0);
  }
}

}  // namespace
}  // namespace lcrig
