// SPDX-License-Identifier: Apache-2.0
// Whole runs on the simulated bench in virtual time: bounds and invariants.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/rig/bench_door.hpp"
#include "drivers/zwick/sim.hpp"
#include "storage/chain.hpp"
#include "storage/run_summary.hpp"
#include "tests/support/loss_world.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

// A short loading with every important part: contact, load, hold, measure, unload, finally.
constexpr const char* kShort = R"({ "format": "load-protocol/1", "name": "short",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.01, "timeout_s": 60 },
    { "id": "settle", "do": "hold", "hold": "force", "force_N": 0.5, "for_s": 2 },
    { "id": "level", "do": "measure", "count": 20, "within_s": 4 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 0.1, "timeout_s": 60 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 2 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

TEST(Run, ReadsExactlyWhatTheStaticExperimentPlans) {
  SessionWorld world(library("static-frame"));
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(world.count("SELECT COUNT(reading_index) FROM lcr_reading WHERE fresh"), 14 * 30 * 4);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM level"), 14 * 4);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM (SELECT level FROM lcr_reading WHERE reading_index "
                        "IS NOT NULL GROUP BY level HAVING COUNT(*) = 30)"),
            14 * 4);
  EXPECT_EQ(world.clock.pending(), 0U);
}

TEST(Run, KeepsTheDynamicExperimentBelowItsOvershootAndAllReadingsFresh) {
  SessionWorld world(library("dynamic-cycles"));
  world.parameters = {{"cycles", "1"}};
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_NEAR(r->peak_force_N, 1.0, 0.01);
  // 15.4 conversions a second, none of them lost and none stored twice.
  const double seconds = world.real(
      "SELECT (MAX(last_byte_mono_ns) - MIN(last_byte_mono_ns)) * "
      "1e-9 FROM lcr_reading");
  EXPECT_NEAR(static_cast<double>(world.count("SELECT COUNT(*) FROM lcr_reading WHERE fresh")),
              seconds / 0.065, 0.01 * seconds / 0.065);
  const auto summary = summarise_run(world.open(), 1);
  ASSERT_TRUE(summary);
  EXPECT_NEAR(*summary->c0_F, 3.6457e-12, 0.01e-12);
}

// kShort with a thousand samples a second.
std::string fast_text() {
  std::string text = kShort;
  const std::string slow = R"("rate_Hz": 50)";
  return text.replace(text.find(slow), slow.size(), R"("rate_Hz": 1000)");
}

TEST(Run, StoresAThousandSamplesASecondWithoutAGapWhereTheBenchSendsThem) {
  SessionWorld world(fast_text());
  world.bench.frame_rate_max_Hz = 1000;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  const auto samples = world.count("SELECT COUNT(*) FROM frame_sample");
  EXPECT_GT(samples, 10'000);
  EXPECT_EQ(samples, world.count("SELECT MAX(device_seq) - MIN(device_seq) + 1 FROM frame_sample"));
  EXPECT_NEAR(world.real("SELECT (MAX(device_time_s) - MIN(device_time_s)) * 1000 + 1 "
                         "FROM frame_sample"),
              static_cast<double>(samples), 0.5);
}

TEST(Run, GetsNoMoreSamplesThanTheBenchSends) {
  SessionWorld world(fast_text());
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_NEAR(world.real("SELECT (COUNT(*) - 1) / (MAX(device_time_s) - MIN(device_time_s)) "
                         "FROM frame_sample"),
              500, 0.1);
}

TEST(Run, PlacesWeightsWithAnOperator) {
  SessionWorld world(library("static-weights"));
  world.parameters = {{"repeats", "1"}};
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(world.count("SELECT COUNT(reading_index) FROM lcr_reading"), 14 * 30);
  EXPECT_NEAR(world.real("SELECT MAX(force_N) FROM frame_sample"), 100e3 * 12.566370614e-6, 1e-6);
}

TEST(Run, ShowsThePromptWhileItWaitsForTheOperator) {
  SessionWorld world(library("static-weights"));
  world.parameters = {{"repeats", "1"}};
  std::string waiting, measuring = "not looked at";
  world.acts = {{"place", 10ms, [&](SessionWorld& w) { waiting = w.session->status().prompt; }},
                {"level", 10ms, [&](SessionWorld& w) { measuring = w.session->status().prompt; }}};
  ASSERT_TRUE(world.run());
  EXPECT_THAT(waiting, HasSubstr("12.8141 g"));  // 10 kPa on a disc of 4 mm
  EXPECT_EQ(measuring, "");
}

TEST(Run, IsTheSameTwiceForOneSeed) {
  SessionWorld a(kShort), b(kShort);
  ASSERT_TRUE(a.run());
  ASSERT_TRUE(b.run());
  const char* sum = "SELECT SUM(capacitance_F) FROM lcr_reading";
  EXPECT_EQ(a.real(sum), b.real(sum));
  const char* last = "SELECT MAX(received_mono_ns) FROM frame_sample";
  EXPECT_EQ(a.count(last), b.count(last));
}

struct StopCase {
  const char* step;
  Interrupt kind;
};

class Stop : public ::testing::TestWithParam<StopCase> {};

TEST_P(Stop, InTheMiddleOfAStepStopsTheFrameAndClosesTheRun) {
  const auto [step, kind] = GetParam();
  SessionWorld world(kShort);
  MonoTime asked;
  world.acts.push_back({step, 300ms, [&, k = kind](SessionWorld& w) {
                          asked = w.clock.now();
                          w.interrupt(k, "a person");
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::abort);
  EXPECT_THAT(r->reason, HasSubstr("a person"));
  expect_invariants(world);
  const auto stopped =
      world.count("SELECT MIN(at_mono_ns) FROM event WHERE kind='stopped' AND at_mono_ns >= " +
                  std::to_string(asked.time_since_epoch().count()));
  EXPECT_LT(Duration(stopped) - asked.time_since_epoch(), 100ms);
  if (kind == Interrupt::freeze) {
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id='clear'"), 0);
  } else if (std::string(step) != "zero" && std::string(step) != "contact") {
    expect_cleared(world);  // before contact is known, nothing can be cleared
  }
}

INSTANTIATE_TEST_SUITE_P(
    EveryStep, Stop,
    ::testing::Values(StopCase{"zero", Interrupt::abort}, StopCase{"contact", Interrupt::abort},
                      StopCase{"load", Interrupt::abort}, StopCase{"settle", Interrupt::abort},
                      StopCase{"level", Interrupt::abort}, StopCase{"unload", Interrupt::abort},
                      StopCase{"contact", Interrupt::freeze}, StopCase{"load", Interrupt::freeze},
                      StopCase{"level", Interrupt::freeze}),
    [](const auto& c) {
      return std::string(to_string(event_of(c.param.kind))) + "_" + c.param.step;
    });

TEST(Run, GoesOnAfterAPauseWithoutLosingOrRepeatingReadings) {
  for (const char* step : {"contact", "load", "settle", "level", "unload"}) {
    SCOPED_TRACE(step);
    SessionWorld world(kShort);
    world.acts.push_back({step, 300ms, [](SessionWorld& w) { w.interrupt(Interrupt::pause); }});
    world.acts.push_back(
        {step, 5300ms, [](SessionWorld& w) { EXPECT_TRUE(w.session->run()->resume()); }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    EXPECT_EQ(world.count("SELECT COUNT(DISTINCT reading_index) FROM lcr_reading"), 20);
    EXPECT_EQ(world.count("SELECT COUNT(reading_index) FROM lcr_reading"), 20);
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind IN ('pause', 'resume')"), 2);
    // Recording goes on during the pause.
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM (SELECT received_mono_ns - LAG(received_mono_ns) "
                          "OVER (ORDER BY seq) AS d FROM frame_sample) WHERE d > 250000000"),
              0);
    expect_invariants(world);
  }
}

TEST(Run, ASecondAbortNeverInterruptsFinally) {
  SessionWorld world(kShort);
  world.acts.push_back({"load", 300ms, [](SessionWorld& w) { w.interrupt(Interrupt::abort); }});
  world.acts.push_back({"clear", 100ms, [](SessionWorld& w) { w.interrupt(Interrupt::abort); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  expect_cleared(world);
  expect_invariants(world);
}

TEST(Run, AForceLimitStopsTheRunAndUnloads) {
  // Like somebody leaning on the table, which a plan cannot know.
  SessionWorld world(with(kShort, "[-0.2, 1.0]", "[-0.2, 0.7]"));
  world.acts.push_back({"settle", 100ms, [](SessionWorld& w) {
                          auto& faults = frame(w).faults;
                          faults.spike_N = 0.3;
                          faults.spike_samples = 1;
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_EQ(r->code, Errc::limit_tripped);
  EXPECT_THAT(r->reason, HasSubstr("limit"));
  expect_cleared(world);
  expect_invariants(world);
}

TEST(Run, AProbeThatAlreadyTouchesIsNotZeroed) {
  SessionWorld world(with(kShort, R"("max_offset_N": 0.5)", R"("max_offset_N": 0.001)"));
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("already touch"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='zero'"), 0);
}

TEST(Run, NothingIsStoredOrMovedWhenThePlanIsRefused) {
  SessionWorld world(
      with(kShort, R"("count": 20, "within_s": 4)", R"("count": 200, "within_s": 4)"));
  const auto r = world.run();
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Errc::invalid_request);
  EXPECT_THAT(r.error().what, HasSubstr("/steps/4"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM run"), 0);
}

TEST(Run, FinallyThatTakesTooLongLeavesTheFrameStanding) {
  // From the planned position, `finally` takes 3 s; from the loaded specimen it takes 4 s.
  SessionWorld world(with(kShort, R"("finally": [)", R"("finally_timeout_s": 3.5, "finally": [)"));
  world.acts.push_back({"settle", 300ms, [](SessionWorld& w) { w.interrupt(Interrupt::abort); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::abort);
  EXPECT_THAT(r->reason, HasSubstr("`finally` did not end"));
  expect_invariants(world);
}

}  // namespace
}  // namespace lcrig
