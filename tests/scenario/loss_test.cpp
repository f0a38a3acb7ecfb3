// SPDX-License-Identifier: Apache-2.0
// Instruments that vanish in the middle of a run and come back, in virtual time.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"
#include "storage/run_summary.hpp"
#include "tests/support/loss_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

struct LossCase {
  const char* step;
  Which which;
  const char* policy;
};

std::string name_of_loss(const ::testing::TestParamInfo<LossCase>& c) {
  return std::string(c.param.which == Which::meter ? "meter_" : "frame_") + c.param.step + "_" +
         c.param.policy;
}

std::vector<LossCase> every_case() {
  std::vector<LossCase> out;
  for (const Which which : {Which::meter, Which::frame}) {
    for (const char* step :
         {"zero", "contact", "load", "settle", "level", "record", "set", "unload"}) {
      for (const char* policy : {"wait", "repeat_step", "abort"}) {
        out.push_back({step, which, policy});
      }
    }
  }
  return out;
}

class Loss : public ::testing::TestWithParam<LossCase> {};

TEST_P(Loss, InAStepIsSurvivedOrEndsTheRunAsTheProtocolSays) {
  const auto [step, which, policy] = GetParam();
  SessionWorld world(loss_protocol(policy, kEveryKind));
  world.in_memory = true;
  away(world, step, which, 300ms, 3s);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  expect_invariants(world);
  expect_cleared(world);
  EXPECT_EQ(events(world, "loss"), 1);
  if (std::string(policy) == "abort") {
    EXPECT_EQ(r->exit_status, ExitStatus::fail);
    EXPECT_EQ(r->code, Errc::disconnected) << r->reason;
    return;
  }
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(events(world, "gap"), 1);
  EXPECT_EQ(events(world, "reconnected"), 1);
  EXPECT_EQ(events(world, "repeat"), std::string(policy) == "repeat_step" ? 1 : 0);
  // A setting that is brought back has to settle.
  const double settles_s = which == Which::meter && std::string(step) == "set" ? 1.2 : 0;
  EXPECT_NEAR(world.real("SELECT json_extract(detail, '$.seconds') FROM event WHERE kind = 'gap'"),
              3.5 + settles_s, 1.0);
  // The force that the protocol asked for was reached, and the whole level was measured there.
  const auto summary = summarise_run(world.open(), 1);
  ASSERT_TRUE(summary) << summary.error().what;
  EXPECT_EQ(summary->measure_readings, 20);
  EXPECT_NEAR(world.real("SELECT AVG(force_N) FROM frame_sample WHERE received_mono_ns BETWEEN "
                         "(SELECT MIN(asked_mono_ns) FROM lcr_reading WHERE reading_index = 1) AND "
                         "(SELECT MAX(last_byte_mono_ns) FROM lcr_reading WHERE reading_index = "
                         "20) AND flags & 2"),
              0.5, 0.02);
}

INSTANTIATE_TEST_SUITE_P(EveryStep, Loss, ::testing::ValuesIn(every_case()), name_of_loss);

// Fewer in builds that run ten times slower (LCRIG_REPLUGS).
int replugs() {
  const char* wanted = std::getenv("LCRIG_REPLUGS");
  return wanted != nullptr ? std::max(1, std::atoi(wanted)) : 100;
}

std::string long_record(int count) {
  return fmt::format(R"({{ "id": "record", "do": "record", "for_s": {} }})", 100 + 20 * count);
}

// Nobody confirms.
class Unattended final : public SessionWorld {
 public:
  using SessionWorld::SessionWorld;

 private:
  struct Nobody final : Operator {
    explicit Nobody(Clock& c) : clock(c) {}
    Task<Result<>> confirm(std::string) override {
      co_await clock.wait_until(MonoTime::max());
      co_return Result<>();
    }
    const std::string& prompt() const override { return shown; }
    Clock& clock;
    std::string shown;
  };
  void adjust(SimRequest& sim, Recorder::Options&) override { sim.person = &nobody_; }
  Nobody nobody_{clock};
};

constexpr const char* kUntilConfirmed =
    R"({ "id": "record", "do": "record", "until": "confirmed", "timeout_s": 20 })";

double recorded_s(const SessionWorld& world) {
  return world.real(
      "SELECT (MAX(at_mono_ns) FILTER (WHERE kind = 'step_end') - "
      "MIN(at_mono_ns) FILTER (WHERE kind = 'step_begin')) * 1e-9 FROM event "
      "WHERE step_id = 'record'");
}

TEST(RecordUntilConfirmed, TakesNoLongerThanItsTimeOutBesideAPause) {
  Unattended world(loss_protocol("abort", kUntilConfirmed));
  world.in_memory = true;
  for (const Duration at : {5s, 45s}) {
    world.acts.push_back({"record", at, [](auto& w) { w.interrupt(Interrupt::pause); }});
    world.acts.push_back({"record", at + 30s, [](auto& w) { w.session->run()->resume(); }});
  }
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_NEAR(recorded_s(world), 20 + 2 * 30, 0.5);
  EXPECT_EQ(events(world, "late"), 1);
}

TEST(RecordUntilConfirmed, GoesOnWithTheRestOfItsTimeAfterALossOrBeginsAgain) {
  for (const Which which : {Which::meter, Which::frame}) {
    for (const char* policy : {"wait", "repeat_step"}) {
      Unattended world(loss_protocol(policy, kUntilConfirmed));
      world.in_memory = true;
      away(world, "record", which, 15s, 30s);
      const auto r = world.run();
      ASSERT_TRUE(r) << r.error().what;
      EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
      const double again_s = std::string(policy) == "wait" ? 0 : 15;
      EXPECT_NEAR(recorded_s(world), 20 + 30 + again_s, 1.5) << policy;
    }
  }
}

TEST(Reconnect, MeterIsBackWithinASecondOfTheReplugAHundredTimes) {
  const int count = replugs();
  SessionWorld world(loss_protocol("wait", long_record(count)));
  std::mt19937_64 random(20261121);
  std::uniform_real_distribution<double> jitter(0, 3);
  std::vector<MonoTime> plugged;
  for (int i = 0; i < count; ++i) {
    const Duration at = from_seconds(5 + 20.0 * i + jitter(random));
    world.acts.push_back({"record", at, [](SessionWorld& w) { unplug(w, Which::meter); }});
    world.acts.push_back({"record", at + 3s, [&](SessionWorld& w) {
                            plugged.push_back(w.clock.now());
                            plug(w, Which::meter);
                          }});
  }
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  ASSERT_EQ(std::ssize(plugged), count);
  EXPECT_EQ(events(world, "reconnected"), count);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM lcr_reading WHERE flags & 16"), count);
  double worst_s = 0;
  for (const MonoTime t : plugged) {
    const auto ns = t.time_since_epoch().count();
    const double s = world.real(
        "SELECT (MIN(last_byte_mono_ns) - " + std::to_string(ns) +
        ") * 1e-9 FROM lcr_reading WHERE flags & 16 AND last_byte_mono_ns > " + std::to_string(ns));
    EXPECT_LT(s, 1.0);
    worst_s = std::max(worst_s, s);
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM lcr_reading WHERE last_byte_mono_ns BETWEEN " +
                          std::to_string(ns - 2'990'000'000) + " AND " + std::to_string(ns)),
              0)
        << "a reading of a meter that was not there";
  }
  RecordProperty("worst_s", std::to_string(worst_s));
  std::printf("meter: good readings at most %.3f s after the replug\n", worst_s);
  expect_invariants(world);
}

TEST(Reconnect, FrameIsBackWithinASecondOfTheReplugAHundredTimes) {
  const int count = replugs();
  SessionWorld world(loss_protocol("wait", long_record(count)));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> jitter(0, 3);
  std::vector<MonoTime> plugged;
  for (int i = 0; i < count; ++i) {
    const Duration at = from_seconds(5 + 20.0 * i + jitter(random));
    world.acts.push_back({"record", at, [](SessionWorld& w) { unplug(w, Which::frame); }});
    world.acts.push_back({"record", at + 3s, [&](SessionWorld& w) {
                            plugged.push_back(w.clock.now());
                            plug(w, Which::frame);
                          }});
  }
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  ASSERT_EQ(std::ssize(plugged), count);
  double worst_s = 0;
  for (const MonoTime t : plugged) {
    const auto ns = std::to_string(t.time_since_epoch().count());
    const double s = world.real("SELECT (MIN(received_mono_ns) - " + ns +
                                ") * 1e-9 FROM frame_sample WHERE received_mono_ns > " + ns);
    EXPECT_LT(s, 1.0);
    worst_s = std::max(worst_s, s);
  }
  std::printf("frame: good samples at most %.3f s after the replug\n", worst_s);
  EXPECT_EQ(events(world, "reconnected"), count);
  expect_invariants(world);
}

TEST(Reconnect, AMeterThatLostItsSettingsGetsThemAgainBeforeItIsRead) {
  SessionWorld world(loss_protocol("wait", R"({ "id": "record", "do": "record", "for_s": 20 })"));
  world.acts.push_back({"record", 2s, [](SessionWorld& w) { unplug(w, Which::meter); }});
  world.acts.push_back({"record", 5s, [](SessionWorld& w) {
                          w.session->instruments().door()->meter_sim().power_on();
                          plug(w, Which::meter);
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  // Without its settings a conversion would take 380 ms; with them the meter makes 15 readings a
  // second.
  EXPECT_GT(world.count("SELECT COUNT(*) FROM lcr_reading WHERE last_byte_mono_ns > (SELECT "
                        "MAX(last_byte_mono_ns) FROM lcr_reading) - 5000000000"),
            70);
}

TEST(Reconnect, AnotherSerialNumberIsRefusedAndNamed) {
  SessionWorld world(
      loss_protocol("wait", R"({ "id": "record", "do": "record", "for_s": 200 })", "30"));
  world.acts.push_back({"record", 2s, [](SessionWorld& w) { unplug(w, Which::meter); }});
  world.acts.push_back({"record", 5s, [](SessionWorld& w) {
                          w.session->instruments().door()->meter_sim().power_on(
                              "LCR-6100,REV E8.13,OTHER0007,Good Will Instrument Co., Ltd.");
                          plug(w, Which::meter);
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("OTHER0007"));
  EXPECT_THAT(r->reason, HasSubstr("SIM000001"));
  EXPECT_EQ(events(world, "refused"), 1) << "said once, not at every attempt";
  EXPECT_EQ(events(world, "reconnected"), 0);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM lcr_reading WHERE last_byte_mono_ns > (SELECT "
                        "at_mono_ns FROM event WHERE kind = 'loss')"),
            0)
      << "a reading of the wrong meter";
  expect_invariants(world);
}

TEST(Reconnect, WaitingHasALimit) {
  for (const Which which : {Which::meter, Which::frame}) {
    SessionWorld world(
        loss_protocol("wait", R"({ "id": "record", "do": "record", "for_s": 200 })", "20"));
    world.acts.push_back({"record", 2s, [=](SessionWorld& w) { unplug(w, which); }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::fail);
    EXPECT_EQ(r->code, Errc::disconnected);
    EXPECT_THAT(r->reason, HasSubstr("did not come back within 20 s"));
    EXPECT_EQ(r->stands, which == Which::meter)
        << "nobody knows what a frame does that is not there";
    if (which == Which::meter) {
      expect_invariants(world);
    } else {
      EXPECT_THAT(r->reason, HasSubstr("`finally` did not run"));
    }
    EXPECT_EQ(world.clock.pending(), 0U);
  }
}

TEST(Reconnect, AbortActsWhileAnInstrumentIsAway) {
  SessionWorld world(loss_protocol("wait", kEveryKind));
  MonoTime asked;
  world.acts.push_back({"settle", 300ms, [](SessionWorld& w) { unplug(w, Which::meter); }});
  world.acts.push_back({"settle", 2s, [&](SessionWorld& w) {
                          asked = w.clock.now();
                          EXPECT_EQ(w.session->status().state, RunState::holding_force);
                          w.interrupt(Interrupt::abort, "a person");
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::abort);
  EXPECT_THAT(r->reason, HasSubstr("a person"));
  expect_cleared(world);
  expect_invariants(world);
}

TEST(Reconnect, TheForceIsHeldAndGuardedWhileTheMeterIsAway) {
  SessionWorld world(loss_protocol("wait", kEveryKind));
  MonoTime gone;
  world.acts.push_back({"settle", 500ms, [&](SessionWorld& w) {
                          gone = w.clock.now();
                          unplug(w, Which::meter);
                        }});
  world.acts.push_back({"settle", 30500ms, [](SessionWorld& w) { plug(w, Which::meter); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  const auto ns = std::to_string(gone.time_since_epoch().count());
  const std::string meanwhile =
      " FROM frame_sample WHERE received_mono_ns BETWEEN " + ns + " AND " + ns + " + 30000000000";
  EXPECT_NEAR(static_cast<double>(world.count("SELECT COUNT(*)" + meanwhile)), 1500, 10);
  EXPECT_EQ(world.count("SELECT COUNT(*)" + meanwhile + " AND NOT flags & 2"), 0);
}

TEST(Reconnect, RepeatStepWritesASecondLevelAndCountsItsReadingsOnce) {
  SessionWorld world(loss_protocol("repeat_step", kEveryKind));
  away(world, "level", Which::meter, 2100ms, 3s);
  std::int64_t shown = -1;
  world.acts.push_back(
      {"unload", 0ms, [&](SessionWorld& w) { shown = w.session->status().measure_readings; }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM level"), 2);
  EXPECT_EQ(world.count("SELECT COUNT(DISTINCT level_index) FROM level"), 1) << "the same place";
  const auto cut = world.count("SELECT COUNT(*) FROM lcr_reading WHERE level = 1");
  EXPECT_NEAR(static_cast<double>(cut), 11, 1);
  EXPECT_EQ(world.count("SELECT json_extract(detail, '$.readings') FROM event WHERE kind = "
                        "'level_abandoned'"),
            cut);
  EXPECT_EQ(world.count("SELECT COUNT(DISTINCT reading_index) FROM lcr_reading WHERE level = 2"),
            20);
  EXPECT_EQ(shown, 20);
  const auto summary = summarise_run(world.open(), 1);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->measure_readings, 20);
}

TEST(Reconnect, APluckedCableThatNeverHoldsEndsTheRun) {
  SessionWorld world(loss_protocol("wait", R"({ "id": "record", "do": "record", "for_s": 200 })"));
  for (int i = 0; i < 12; ++i) away(world, "record", Which::meter, 2s + i * 4s, 1s);
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("lost 5 times within a minute"));
  expect_invariants(world);
}

TEST(Reconnect, AFrameThatForgotItsZeroIsNotMovedAgain) {
  SessionWorld world(loss_protocol("wait", kEveryKind));
  world.acts.push_back({"settle", 300ms, [](SessionWorld& w) {
                          unplug(w, Which::frame);
                          // The clock starts again, as after the frame was switched off and on.
                          frame(w).faults.clock_jump_s = -1e4;
                        }});
  world.acts.push_back({"settle", 3s, [](SessionWorld& w) { plug(w, Which::frame); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_THAT(r->reason, HasSubstr("may have forgotten its zero"));
  EXPECT_THAT(r->reason, HasSubstr("`finally` did not run"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id = 'clear'"), 0);
}

}  // namespace
}  // namespace lcrig
