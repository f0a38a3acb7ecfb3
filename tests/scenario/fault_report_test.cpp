// SPDX-License-Identifier: Apache-2.0
// A frame that reports a fault itself, that comes back as another one, or that does not confirm a
// STOP. Nothing moves any more, and the run says whether the specimen is still loaded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/zwick/sim.hpp"
#include "tests/support/loss_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::AnyOf;
using ::testing::HasSubstr;

// Number of motions of any kind that began after this event.
std::int64_t motions_after(const SessionWorld& world, const std::string& kind) {
  return world.count(
      "SELECT COUNT(*) FROM event WHERE (kind = 'step_begin' OR (kind = 'motion' AND detail LIKE "
      "'%\"target\"%')) AND seq > (SELECT "
      "MIN(seq) FROM event WHERE kind = '" +
      kind + "')");
}

// Range of the travel in the samples from 0.3 s after this event on, mm.
double way_after_mm(const SessionWorld& world, const std::string& kind) {
  return 1e3 * world.real(
                   "SELECT MAX(travel_m) - MIN(travel_m) FROM frame_sample WHERE received_mono_ns "
                   "> (SELECT MIN(at_mono_ns) FROM event WHERE kind = '" +
                   kind + "') + 300000000");
}

void expect_hands_off(const SessionWorld& world, const RunResult& r, Errc code) {
  EXPECT_EQ(r.exit_status, ExitStatus::fail);
  EXPECT_EQ(r.code, code) << r.reason;
  EXPECT_THAT(r.reason, HasSubstr("nothing is moved any more until a person has looked"));
  EXPECT_THAT(r.reason, HasSubstr("loaded"));
  EXPECT_EQ(motions_after(world, "hands_off"), 0);
  EXPECT_EQ(world.text("SELECT kind FROM event WHERE kind LIKE 'stop%' ORDER BY seq DESC"),
            "stopped");
  EXPECT_EQ(world.clock.pending(), 0U);
}

struct Trip {
  const char* step;
  const char* kind;
  bool held;
};

TEST(FaultReport, NothingMovesAfterAFaultThatTheFrameReports) {
  for (const Trip& trip :
       {Trip{"load", "estop", false}, Trip{"load", "estop", true}, Trip{"contact", "shield", false},
        Trip{"settle", "drive_off", true}, Trip{"level", "drive_fault", false},
        Trip{"load", "", false}, Trip{"clear", "estop", false}, Trip{"zero", "estop", true}}) {
    SCOPED_TRACE(std::string(trip.step) + " " + trip.kind + (trip.held ? " held" : " pulsed"));
    SessionWorld world(loss_protocol("wait", kEveryKind));
    world.acts.push_back({trip.step, 300ms, [&](SessionWorld& w) {
                            frame(w).faults.not_ready = trip.held;
                            frame(w).trip(trip.kind, "somebody was there");
                          }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_THAT(r->reason, HasSubstr("somebody was there"));
    EXPECT_THAT(r->reason, HasSubstr(*trip.kind != '\0' ? trip.kind : "a fault"));
    expect_hands_off(world, *r, Errc::frame_fault);
    EXPECT_LT(way_after_mm(world, "hands_off"), 1e-3);
  }
}

TEST(FaultReport, ALoadedSpecimenIsNamed) {
  SessionWorld world(loss_protocol("wait", kEveryKind));
  world.acts.push_back(
      {"level", 500ms, [](SessionWorld& w) { frame(w).trip("estop", "pressed"); }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_THAT(r->reason, HasSubstr("the specimen is still loaded with about 0.5"));
  EXPECT_THAT(r->reason, HasSubstr("estop (pressed)"));
}

TEST(FaultReport, AFrameThatIsNotReadyIsLeftToAPerson) {
  SessionWorld world(loss_protocol("wait", kEveryKind));
  world.acts.push_back(
      {"contact", 300ms, [](SessionWorld& w) { frame(w).faults.not_ready = true; }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_THAT(r->reason, HasSubstr("not_ready"));
  expect_hands_off(world, *r, Errc::frame_fault);
}

// Also checked while the run is paused or being aborted.
TEST(FaultReport, AFaultWhileTheRunIsBeingStoppedCountsAsOne) {
  for (const Interrupt kind : {Interrupt::pause, Interrupt::abort}) {
    SCOPED_TRACE(to_string(event_of(kind)));
    SessionWorld world(loss_protocol("wait", kEveryKind));
    world.acts.push_back({"load", 300ms, [=](SessionWorld& w) {
                            w.interrupt(kind);
                            frame(w).trip("estop", "pressed");
                          }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id = 'clear'"), 0);
    EXPECT_THAT(r->reason, HasSubstr("the frame reports estop (pressed)"));
    EXPECT_EQ(motions_after(world, "hands_off"), 0);
  }
}

// The tare is lost, but neither the serial number nor the clock reveals it.
void forget_quietly(SessionWorld& w) {
  frame(w).forget();
  frame(w).faults.clock_jump_s = 1e4;
}

TEST(LostOrigin, EndsTheRunBeforeAnythingIsArmed) {
  for (const char* step : {"load", "settle", "level", "clear"}) {
    SCOPED_TRACE(step);
    SessionWorld world(loss_protocol("wait", kEveryKind));
    world.bench.plant.force_offset_N = 0.4;
    bool armed = false;
    world.acts.push_back({step, 300ms, [](SessionWorld& w) {
                            unplug(w, Which::frame);
                            forget_quietly(w);
                          }});
    world.acts.push_back({step, 3s, [](SessionWorld& w) { plug(w, Which::frame); }});
    world.acts.push_back({step, 3300ms, [&](SessionWorld& w) { armed = frame(w).is_armed(); }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_FALSE(armed);
    EXPECT_THAT(r->reason, HasSubstr("the zero of force or travel was lost or changed"));
    EXPECT_THAT(r->reason, HasSubstr("whether the specimen is still loaded is not known"));
    EXPECT_EQ(events(world, "reconnected"), 1);
    EXPECT_EQ(motions_after(world, "hands_off"), 0);
    EXPECT_LT(world.real("SELECT MAX(at_mono_ns) FROM event") -
                  world.real("SELECT MIN(at_mono_ns) FROM event WHERE kind = 'loss'"),
              10e9)
        << "the time-out was waited for";
  }
}

// An old gateway cannot report faults.
struct OldWorld final : SessionWorld {
  using SessionWorld::SessionWorld;
  void built() override { frame(*this).settings().revision = 1; }
};

TEST(LostOrigin, IsSeenInTheForceWhenTheGatewayCannotSayIt) {
  for (const double offset_N : {0.0, -0.6}) {
    SCOPED_TRACE(offset_N);
    std::string text = loss_protocol("wait", R"(
      { "id": "zero", "do": "zero", "force": true, "max_offset_N": 2 },
      { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
      { "id": "load", "do": "move_until", "until": { "force_N": 0.5 }, "speed_mm_s": 0.002, "timeout_s": 600 })");
    const std::string least = R"("force_N": [-0.2,)";
    text.replace(text.find(least), least.size(), R"("force_N": [-1,)");
    OldWorld world(text);
    world.bench.plant.force_offset_N = offset_N;
    bool moved = false;
    world.acts.push_back({"load", 300ms, [&](SessionWorld& w) {
                            moved = frame(w).is_moving();
                            unplug(w, Which::frame);
                            forget_quietly(w);
                          }});
    world.acts.push_back({"load", 3s, [](SessionWorld& w) { plug(w, Which::frame); }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_TRUE(moved) << "the frame stood";
    if (offset_N == 0) {
      EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
      continue;
    }
    EXPECT_THAT(r->reason, HasSubstr("no contact does that"));
    expect_hands_off(world, *r, Errc::refused);
  }
}

TEST(LostOrigin, AnotherMachineOrOtherCapabilitiesEndTheWaitAtOnce) {
  const std::vector<std::pair<const char*, std::function<void(ZwickSimSettings&)>>> cases{
      {"OTHER", [](ZwickSimSettings& s) { s.serial = "OTHER"; }},
      {"other capabilities", [](ZwickSimSettings& s) { s.rate_max_Hz = 400; }}};
  for (const auto& [name, change] : cases) {
    SCOPED_TRACE(name);
    SessionWorld world(loss_protocol("wait", kEveryKind));
    world.acts.push_back({"load", 300ms, [&](SessionWorld& w) {
                            unplug(w, Which::frame);
                            change(frame(w).settings());
                          }});
    world.acts.push_back({"load", 3s, [](SessionWorld& w) { plug(w, Which::frame); }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::fail);
    EXPECT_EQ(r->code, Errc::refused);
    EXPECT_THAT(r->reason, HasSubstr(name));
    EXPECT_THAT(r->reason, HasSubstr("nothing is moved any more"));
    EXPECT_EQ(motions_after(world, "hands_off"), 0);
    EXPECT_LT(world.real("SELECT MAX(at_mono_ns) FROM event") -
                  world.real("SELECT MIN(at_mono_ns) FROM event WHERE kind = 'loss'"),
              15e9);
  }
}

TEST(StopReport, WithoutAConfirmedStandstillFinallyDoesNotBegin) {
  SessionWorld world(loss_protocol("wait", kEveryKind));
  world.acts.push_back({"level", 500ms, [](SessionWorld& w) {
                          frame(w).faults.lose_stopped = 1000;
                          w.interrupt(Interrupt::abort);
                        }});
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::fail);
  EXPECT_EQ(r->code, Errc::not_standing);
  EXPECT_THAT(r->reason, HasSubstr("standstill not confirmed: use the E-stop"));
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id = 'clear'"), 0);
}

// The force exceeds its limit after STOP was sent and before the frame says that it stands.
TEST(StopReport, ALimitThatTripsWhileTheFrameStopsDoesNotKillFinally) {
  for (const Interrupt kind : {Interrupt::abort, Interrupt::pause, Interrupt::limit}) {
    SCOPED_TRACE(to_string(event_of(kind)));
    SessionWorld world(loss_protocol("wait", kEveryKind));
    world.acts.push_back({"load", 300ms, [=](SessionWorld& w) {
                            frame(w).faults.lose_stopped = 1;
                            w.interrupt(kind);
                          }});
    world.acts.push_back({"load", 600ms, [](SessionWorld& w) {
                            frame(w).faults.spike_N = 1.5;
                            frame(w).faults.spike_samples = 3;
                          }});
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_GT(world.real("SELECT MAX(force_N) FROM frame_sample"), 1.4);
    EXPECT_NE(r->exit_status, ExitStatus::success);
    EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE step_id = 'clear' AND kind = 'motion' "
                          "AND detail LIKE '%\"target\"%'"),
              1)
        << r->reason;
  }
}

}  // namespace
}  // namespace lcrig
