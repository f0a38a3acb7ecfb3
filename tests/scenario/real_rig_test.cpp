// SPDX-License-Identifier: Apache-2.0
// Properties that must hold on a real rig that is not known in advance: origins of travel,
// overloads and ways back, stops that are not confirmed, stops at any moment, and a frame that
// somebody else uses.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/rig/bench_door.hpp"
#include "drivers/zwick/sim.hpp"
#include "tests/support/daemon_world.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

// From this step on, the device's own stop is late by this time.
void stop_late(SessionWorld& world, const std::string& step_id, double late_s) {
  world.acts.push_back({step_id, 10ms, [late_s](SessionWorld& w) {
                          frame(w).faults.late_stop_s = late_s;
                          frame(w).poke();
                        }});
}

// A bench whose cell errs within its class.
class CellWorld final : public SessionWorld {
 public:
  CellWorld(std::string text, ForceClass cell, std::uint64_t seed)
      : SessionWorld(std::move(text)), seed_(seed) {
    bench.plant.force_class = cell;
    bench.plant.force_nominal_N = 5;
    bench.errors = ErrorScope::everything;
    bench.fixture.stray_limit_F = 3e-13;
  }

 private:
  void adjust(SimRequest& sim, Recorder::Options&) override {
    sim.seed = static_cast<std::int64_t>(seed_);
  }
  std::uint64_t seed_;
};

void expect_unloaded(const SessionWorld& world) {
  EXPECT_LT(world.real("SELECT force_N FROM frame_sample ORDER BY seq DESC"), 0.02);
}

// Travel from 0 to 60 mm with the specimen at 30 mm, which no file says.
TEST(RealRig, ShippedProtocolsRunWhereverContactIs) {
  const std::map<std::string, ParameterValues> shorter{
      {"static-frame", {{"repeats", "1"}, {"levels", "3"}}},
      {"dynamic-cycles", {{"cycles", "1"}, {"gap_mm", "0.2"}}},
      {"preconditioning", {{"cycles", "2"}, {"rest_s", "1"}}},
      {"creep", {{"hold_s", "5"}, {"recovery_s", "5"}}},
      {"follow", {{"duration_s", "5"}}}};
  for (const auto& [name, parameters] : shorter) {
    SCOPED_TRACE(name);
    SessionWorld world(library(name));
    world.parameters = parameters;
    world.bench.plant.travel_min_m = 0;
    world.bench.plant.travel_max_m = 60e-3;
    world.bench.plant.contact_travel_m = 30e-3;
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    expect_unloaded(world);
  }
}

// The cells err as their class allows, in gain and in the zero that a tare leaves. The range is
// that of a cell whose zero is good enough for the contact force of these files (0.02 N).
TEST(RealRig, ShippedProtocolsSucceedOnACellOfAnyClass) {
  const std::map<std::string, ParameterValues> shorter{
      {"static-frame", {{"repeats", "1"}, {"levels", "3"}}},
      {"dynamic-cycles", {{"cycles", "1"}, {"gap_mm", "0.2"}}},
      {"preconditioning", {{"cycles", "2"}, {"rest_s", "1"}}},
      {"creep", {{"hold_s", "5"}, {"recovery_s", "5"}}}};
  for (const double percent : kForceClasses) {
    for (const auto& [name, parameters] : shorter) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(fmt::format("class {}, {}, seed {}", percent, name, seed));
        CellWorld world(library(name), ForceClass(percent), seed);
        world.parameters = parameters;
        const auto r = world.run();
        ASSERT_TRUE(r) << r.error().what;
        EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
        const auto stored =
            nlohmann::json::parse(world.text("SELECT frame_capabilities_json FROM run"));
        EXPECT_EQ(stored.at("force_class_percent"), percent);
        const auto meter = nlohmann::json::parse(world.text("SELECT correction_json FROM run"));
        EXPECT_EQ(meter.at("stray_limit_F"), 3e-13);
      }
    }
  }
}

// The positions stay the same; only the numbers for them change.
TEST(RealRig, ANewZeroOfTravelMovesNoLimit) {
  std::string text =
      with(kLoad, R"("gap_mm": [-1, 10])", R"("travel_mm": [0, 40], "gap_mm": [-1, 40])");
  text = with(
      text, R"("steps": [)",
      R"("steps": [ { "id": "near", "do": "ramp", "to": { "travel_mm": 25 }, "speed_mm_s": 0.5, "timeout_s": 60 },
    { "id": "here", "do": "zero", "travel": true },)");
  text = with(text, R"("to": { "gap_mm": 2 }, "speed_mm_s": 0.5)",
              R"("to": { "travel_mm": -20 }, "speed_mm_s": 2)");
  SessionWorld world(text);
  world.bench.plant.travel_min_m = 0;
  world.bench.plant.travel_max_m = 60e-3;
  world.bench.plant.contact_travel_m = 30e-3;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_NEAR(world.real("SELECT travel_m FROM frame_sample ORDER BY seq DESC"), -20e-3, 1e-6);
  SessionWorld beyond(with(text, R"("travel_mm": -20)", R"("travel_mm": -26)"));
  beyond.bench = world.bench;
  const auto refused = beyond.run();
  ASSERT_FALSE(refused) << "1 mm out of the limits";
  EXPECT_THAT(refused.error().what, HasSubstr("-25 to 15 mm"));
}

TEST(RealRig, AStrokeWithoutClearanceIsNoticedBeforeAnythingIsPressed) {
  SessionWorld world(library("dynamic-cycles"));
  world.bench.plant.travel_min_m = 0;
  world.bench.plant.travel_max_m = 60e-3;
  world.bench.plant.contact_travel_m = 3e-3;  // `finally` asks for a gap of 5 mm
  const auto r = world.run();
  ASSERT_FALSE(r) << "the bench says where contact is expected";
  EXPECT_THAT(r.error().what, HasSubstr("the frame reaches 0 to 60 mm"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM run"), 0);
}

TEST(RealRig, AGapThatAPersonStatesNeedsNoSearch) {
  SessionWorld world(with(
      with(
          kLoad,
          R"({ "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 600 })",
          R"({ "id": "stated", "do": "set_gap", "gap_mm": 3.2 })"),
      R"("speed_mm_s": 0.01)", R"("speed_mm_s": 0.1)"));
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_NEAR(world.real("SELECT travel_m FROM frame_sample ORDER BY seq DESC"), 1.2e-3, 1e-6);
}

// The device's own stop is late, and the force goes far beyond the limit. The broken limit must not
// keep the frame on the specimen.
TEST(RealRig, AnOverloadIsLeftByTheWayItCame) {
  SessionWorld world(with(kLoad, R"("until": { "force_N": 0.5 }, "speed_mm_s": 0.01)",
                          R"("until": { "force_N": 0.9 }, "speed_mm_s": 0.1)"));
  stop_late(world, "load", 0.3);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_GT(world.real("SELECT MAX(force_N) FROM frame_sample"), 1.2) << "nothing was overloaded";
  EXPECT_THAT(r->reason, Not(HasSubstr("in `finally`")));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id='clear' AND kind='motion' AND "
                        "detail LIKE '%\"target\"%'"),
            1);
  expect_unloaded(world);
}

// The cell shows nothing at the turn, so the first force on the way back is higher than the last
// one before it.
TEST(RealRig, AnOverloadOfTheCellIsLeftByTheWayItCame) {
  const std::string fast = with(kLoad, R"("until": { "force_N": 0.5 }, "speed_mm_s": 0.01)",
                                R"("until": { "force_N": 0.3 }, "speed_mm_s": 0.5)");
  SessionWorld world(
      with(fast, R"("gap_mm": 2 }, "speed_mm_s": 0.5)", R"("gap_mm": 0.5 }, "speed_mm_s": 0.05)"));
  world.bench.plant.force_nominal_N = 1.3;
  stop_late(world, "load", 0.3);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_GT(world.count("SELECT COUNT(*) FROM frame_sample WHERE force_N IS NULL"), 0);
  EXPECT_THAT(r->reason, Not(HasSubstr("in `finally`")));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='contradiction'"), 0);
  expect_unloaded(world);
}

TEST(RealRig, AnOverloadInTheSearchIsLeftThoughContactWasNeverFound) {
  SessionWorld world(kLoad);
  stop_late(world, "contact", 5);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_GT(r->peak_force_N, 1.0);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='contact'"), 0);
  expect_unloaded(world);
}

// The search overruns its contact by more than the way back. What the cell shows there must not be
// taken as its zero: once the specimen is unloaded, it would look as if the specimen pulled.
TEST(RealRig, AWayBackThatStillPressesIsNoZero) {
  SessionWorld world(with(kLoad, R"("back_off_mm": 0.1)", R"("back_off_mm": 0.0005)"));
  world.bench.plant.drive_lag_s = 0.01;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_GT(
      world.real("SELECT f.force_N FROM frame_sample AS f, event AS e WHERE e.kind = 'stiffness' "
                 "AND f.received_mono_ns < e.at_mono_ns ORDER BY f.seq DESC"),
      0.03)
      << "it did not press there";
  expect_unloaded(world);
}

// A threshold that lies 0.7 mm inside a soft contact.
class DeepContact : public SessionWorld {
 public:
  DeepContact(const std::string& back_off, const std::string& clear)
      : SessionWorld(with(with(with(with(kLoad, R"("gap_mm": [-1, 10])", R"("gap_mm": [-3, 10])"),
                                    R"("force_N": 0.02, "back_off_mm": 0.1)",
                                    R"("force_N": 0.35, "back_off_mm": )" + back_off),
                               R"("gap_mm": 2 })", R"("gap_mm": )" + clear + " }"),
                          R"("speed_mm_s": 0.01)", R"("speed_mm_s": 0.05)")) {
    bench.plant.frame_stiffness_N_m = 500;
  }
  double left_N() const { return real("SELECT force_N FROM frame_sample ORDER BY seq DESC"); }
};

TEST(RealRig, AGapInsideASoftSpecimenIsNotCalledClear) {
  DeepContact world("1", "0.12");
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_GT(world.left_N(), 0.08) << "it does not press there";
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("the specimen is still loaded with about 0.2"));
  EXPECT_THAT(r->reason, Not(HasSubstr("check its zero")));
}

TEST(RealRig, AWayBackThatEndsInASoftSpecimenIsRefusedAndNoZero) {
  DeepContact world("0.3", "2");
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("back_off_mm is too small"));
  EXPECT_THAT(r->reason, Not(HasSubstr("pulls")));
  EXPECT_THAT(r->reason, Not(HasSubstr("loaded")));
  expect_unloaded(world);
}

TEST(RealRig, ADeepContactWithAWayBackThatIsLongEnoughSucceeds) {
  DeepContact world("1", "2");
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
}

TEST(RealRig, ASpecimenThatPullsIsLeftToAPerson) {
  SessionWorld world(kLoad);
  world.acts.push_back({"level", 500ms, [](SessionWorld& w) {
                          frame(w).faults.spike_N = -2;
                          frame(w).faults.spike_samples = 1'000'000;
                          frame(w).poke();
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("the specimen pulls at the probe"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id='clear'"), 0);
}

TEST(RealRig, AStopThatIsNotConfirmedFailsTheRunWithACodeOfItsOwn) {
  SessionWorld world(kLoad);
  world.acts.push_back({"clear", 500ms, [](SessionWorld& w) {
                          frame(w).faults.lose_stopped = 1000;
                          frame(w).poke();
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_EQ(r->code, Errc::not_standing);
  EXPECT_THAT(r->reason, HasSubstr("standstill not confirmed: use the E-stop"));
}

TEST(RealRig, AFrozenRunSaysThatTheSpecimenIsLoaded) {
  SessionWorld world(kLoad);
  world.acts.push_back({"level", 500ms, [](SessionWorld& w) { w.interrupt(Interrupt::freeze); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::abort);
  EXPECT_THAT(r->reason, HasSubstr("the specimen is still loaded with about 0.5"));
}

TEST(RealRig, ACellThatNeverChangesIsNotApproachedWith) {
  SessionWorld world(kLoad);
  world.bench.plant.force_noise_N = 0;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_THAT(r->reason, HasSubstr("it is frozen or not connected"));
  EXPECT_EQ(world.real("SELECT MAX(travel_m) FROM frame_sample"), 0) << "nothing moved";
}

// When the run begins after the look at the resting frame, s.
double begins_after_s(int rate_Hz, double noise_N) {
  struct World final : SessionWorld {
    using SessionWorld::SessionWorld;
    void began() override { begun_s = to_seconds(clock.now() - MonoTime()); }
    double begun_s = 0;
  } world(with(kLoad, R"("rate_Hz": 50)", fmt::format(R"("rate_Hz": {})", rate_Hz)));
  world.bench.plant.force_noise_N = noise_N;
  const auto r = world.run();
  EXPECT_TRUE(r) << r.error().what;
  return world.begun_s;
}

// Ten samples may see a third of the scatter, and one value tells nothing of it.
TEST(RealRig, TheLookBeforeARunSeesEnoughOfTheNoiseOfTheCell) {
  const double fast_s = begins_after_s(50, 0.0005);
  EXPECT_NEAR(begins_after_s(20, 0.0005) - fast_s, 0.5, 0.15) << "20 samples";
  EXPECT_NEAR(begins_after_s(2, 0.0005) - fast_s, 3.5, 0.15) << "not longer than 4 s";
  EXPECT_NEAR(begins_after_s(50, 0) - fast_s, 3.5, 0.15) << "the force does not change";
}

TEST(RealRig, ThePredictionIsComparedAndStoredAfterEveryStop) {
  SessionWorld world(kLoad);
  ASSERT_TRUE(world.run());
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='overshoot'"), 2);
  EXPECT_EQ(
      world.count("SELECT COUNT(*) FROM event WHERE kind='overshoot' AND "
                  "json_extract(detail,'$.observed_N') > json_extract(detail,'$.predicted_N') "
                  "+ 0.005"),
      0);
  EXPECT_GT(
      world.real("SELECT json_extract(detail,'$.worst_force_N') FROM event WHERE kind='plan'"),
      0.5);
  EXPECT_THAT(world.text("SELECT detail FROM event WHERE kind='plan'"),
              HasSubstr("frame and cell are at most 200 N/mm stiff, as stated"));
}

// The frame is ten times as stiff as its file says.
TEST(RealRig, AfterAPredictionThatWasExceededNothingIsPressedAnyMore) {
  SessionWorld world(with(kLoad, R"("speed_mm_s": 0.2, "force_N": 0.02)",
                          R"("speed_mm_s": 0.5, "force_N": 0.02)"));
  world.bench.plant.deceleration_m_s2 = 0.5;
  world.bench.plant.drive_lag_s = 1e-3;
  stop_late(world, "contact", 0.01);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("nothing is pressed any more"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='overshoot_exceeded'"), 1);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id='load' AND kind='motion'"), 0);
  expect_unloaded(world);
}

TEST(RealRig, SamplesThatComeLateStopAMotion) {
  SessionWorld world(with(kLoad, R"("name": "load",)", R"("name": "load", "on_loss": "abort",)"));
  world.acts.push_back({"load", 100ms, [](SessionWorld& w) {
                          ZwickSimHooks hooks;
                          hooks.sends = [] {
                            LineFault late;
                            late.delay = 350ms;
                            return late;
                          };
                          frame(w).hooks = std::move(hooks);
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("old when they arrive"));
  EXPECT_GE(world.count("SELECT COUNT(*) FROM event WHERE kind='late_samples'"), 1);
}

using nlohmann::json;

using StopDaemon = support::DaemonWorld;

TEST_F(StopDaemon, AnAbortWhileARunIsPreparedIsObeyed) {
  for (const char* stop : {"run.abort", "run.freeze"}) {
    SCOPED_TRACE(stop);
    support::PlainClient starter(socket_path()), stopper(socket_path());
    starter.call("run.start", start_request());
    clock.run_for(io, 20ms);
    const json stopped = answer(stopper, stop);
    EXPECT_EQ(stopped["result"]["state"], "not_begun") << stopped;
    const json started = wait_for(starter, [](const json& m) { return m.contains("id"); });
    EXPECT_EQ(started["error"]["data"]["errc"], "aborted") << started;
    EXPECT_EQ(count("SELECT COUNT(*) FROM frame_sample WHERE travel_m <> 0"), 0);
    EXPECT_EQ(answer(stopper, "run.abort")["error"]["data"]["errc"], "invalid_request");
  }
}

// Stops from the first byte of the request to the first step: nothing may move afterwards.
TEST_F(StopDaemon, AtAnyInstantOfThePreparationAStopIsObeyed) {
  for (int ms = 0; ms < 1200; ms += 37) {
    SCOPED_TRACE(ms);
    support::PlainClient starter(socket_path()), stopper(socket_path());
    starter.call("run.start", start_request());
    clock.run_for(io, std::chrono::milliseconds(ms));
    const json stopped = answer(stopper, "run.freeze");
    ASSERT_TRUE(stopped.contains("result")) << stopped;
    wait_for(starter, [](const json& m) { return m.contains("id"); });
    clock.run(io, [&] { return answer(stopper, "status")["result"]["run"].is_null(); });
    EXPECT_EQ(count("SELECT COUNT(*) FROM frame_sample WHERE travel_m <> 0"), 0);
  }
}

TEST_F(StopDaemon, AnAbortInFinallySaysThatItGoesOnAndFreezeStopsIt) {
  support::PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "run.start", start_request()).contains("result"));
  clock.run_for(io, 30s);
  EXPECT_EQ(answer(client, "run.abort")["result"]["state"], "standing");
  clock.run_for(io, 200ms);
  const json again = answer(client, "run.abort")["result"];
  EXPECT_EQ(again["state"], "finally") << again;
  EXPECT_EQ(again["standing"], false);
  EXPECT_THAT(again["note"].get<std::string>(), HasSubstr("freeze"));
  EXPECT_EQ(answer(client, "run.freeze")["result"]["state"], "standing");
  json last;
  clock.run(io, [&] {
    last = answer(client, "status")["result"]["last_run"];
    return !last.is_null();
  });
  EXPECT_THAT(last["reason"].get<std::string>(), HasSubstr("freeze"));
}

TEST_F(StopDaemon, APlanForThisRigStartsNothing) {
  support::PlainClient client(socket_path());
  const json plan = answer(client, "run.plan", start_request());
  ASSERT_TRUE(plan.contains("result")) << plan;
  EXPECT_GE(plan["result"]["worst_force_N"], 0.4);
  EXPECT_EQ(count("SELECT COUNT(*) FROM run"), 0);
  EXPECT_TRUE(answer(client, "run.start", start_request()).contains("result"));
}

// The cell is tared while it presses, and shows 0.5 N less from then on.
TEST(RealRig, ATareAtThePanelUnderLoadEndsTheRunByTheWayAway) {
  SessionWorld world(kLoad);
  world.acts.push_back({"level", 100ms, [](SessionWorld& w) {
                          auto& faults = frame(w).faults;
                          faults.spike_N = -0.5;
                          faults.spike_samples = 1'000'000;
                          faults.say =
                              "EVENT kind=origin origin=\"99\" text=\"tared at the panel\"\n";
                          frame(w).poke();
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("zero of force or travel was changed"));
  EXPECT_THAT(r->reason, HasSubstr("whether the specimen is still loaded is not known"));
  EXPECT_NEAR(world.real("SELECT force_N FROM frame_sample ORDER BY seq DESC"), -0.5, 0.01)
      << "nothing presses";
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id='clear' AND kind='motion' AND "
                        "detail LIKE '%\"target\"%'"),
            1);
}

}  // namespace
}  // namespace lcrig
