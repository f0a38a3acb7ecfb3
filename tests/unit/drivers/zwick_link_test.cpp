// SPDX-License-Identifier: Apache-2.0
// Driver and simulated gateway together, over memory in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/frame_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(ZwickLink, IdentifiesAndTakesOverTheCapabilities) {
  FrameBench b;
  const auto identity = b.run(b.frame->identify());
  ASSERT_TRUE(identity) << identity.error().what;
  EXPECT_EQ(identity->model, "simulated frame");
  EXPECT_THAT(identity->text, HasSubstr("HELLO proto=1"));
  const auto& c = b.frame->capabilities();
  EXPECT_TRUE(c.motion && c.device_stop && c.force_hold && c.force_channel);
  EXPECT_EQ(c.force_max, 20.0_N);
  EXPECT_EQ(c.reaction, 1ms);
}

TEST(ZwickLink, MovesToATravelInTheTimeItTakes) {
  FrameBench b;
  b.armed();
  const MonoTime begin = b.clock.now();
  const auto done = b.run(b.frame->move_to(0.5_mm, 0.1_mm_s));
  ASSERT_TRUE(done) << done.error().what;
  EXPECT_EQ(done->reason, MotionEnd::target);
  EXPECT_EQ(done->travel_m, 0.5e-3);
  EXPECT_NEAR(to_seconds(b.clock.now() - begin), 5.0, 1e-3);
}

TEST(ZwickLink, StopsAtAForceInTheDeviceAndOvershootsAsPredicted) {
  FrameBench b;
  b.armed();
  const auto& c = b.frame->capabilities();
  const auto done = b.run(b.frame->move_until_force(1.0_N, 0.5_mm_s, 3.0_mm));
  ASSERT_TRUE(done) << done.error().what;
  EXPECT_EQ(done->reason, MotionEnd::target);
  // k (v tau + v^2/2a) on 10 N/mm: docs/frame-link.md, section 2.
  const double v = 0.5e-3, a = c.deceleration.si();
  const double predicted_N = 10e3 * (v * to_seconds(c.reaction) + v * v / (2 * a));
  EXPECT_GT(predicted_N, 0.02);
  EXPECT_NEAR(done->force_N.value(), 1.0 + predicted_N, 2e-4);
  EXPECT_EQ(b.scene.halts, 1);
}

TEST(ZwickLink, ReleasesDownToAForceFromAbove) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->move_until_force(1.0_N, 0.5_mm_s, 3.0_mm)));
  const auto half = b.run(b.frame->move_until_force(0.5_N, -0.01_mm_s, -2.0_mm));
  ASSERT_TRUE(half);
  EXPECT_EQ(half->reason, MotionEnd::target);
  EXPECT_NEAR(half->force_N.value(), 0.5, 2e-3);
  const auto off = b.run(b.frame->move_until_force(Force(), -0.5_mm_s, -2.0_mm));
  ASSERT_TRUE(off);
  EXPECT_EQ(off->reason, MotionEnd::target);
  EXPECT_EQ(off->force_N, 0.0);
  EXPECT_NEAR(off->travel_m.value(), 1e-3, 1e-5);
}

TEST(ZwickLink, TheGuardEndsAMotionThatFindsNoForce) {
  FrameBench b;
  b.armed();
  const auto done = b.run(b.frame->move_until_force(1.0_N, 0.5_mm_s, 0.9_mm));
  ASSERT_TRUE(done);
  EXPECT_EQ(done->reason, MotionEnd::travel_limit);
  EXPECT_EQ(done->travel_m, 0.9e-3);
}

TEST(ZwickLink, TheDeviceEndsAMotionAtTheForceLimit) {
  FrameBench b;
  b.armed();
  auto limits = wide_limits();
  limits.force_max = 2.0_N;
  ASSERT_TRUE(b.run(b.frame->arm(limits)));
  const auto done = b.run(b.frame->move_to(3.0_mm, 0.1_mm_s));
  ASSERT_TRUE(done);
  EXPECT_EQ(done->reason, MotionEnd::force_limit);
  EXPECT_NEAR(done->force_N.value(), 2.0, 0.01);
  const auto deeper = b.run(b.frame->move_to(3.0_mm, 0.1_mm_s));
  ASSERT_FALSE(deeper);
  EXPECT_EQ(deeper.error().code, Errc::refused);
  EXPECT_TRUE(b.run(b.frame->move_to(0.0_mm, 1.0_mm_s)));
}

TEST(ZwickLink, RampsTheForceAfterFeelingForContact) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->move_to(0.95_mm, 1.0_mm_s)));
  const auto done = b.run(b.frame->ramp_force(1.0_N, 0.5_N_s));
  ASSERT_TRUE(done) << done.error().what;
  EXPECT_EQ(done->reason, MotionEnd::target);
  EXPECT_EQ(done->force_N, 1.0);
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(50)));
  b.pass(200ms);
  EXPECT_EQ(b.listener.samples.back().flags, frame_flag::kForceControl);
  ASSERT_TRUE(b.run(b.frame->hold_travel()));
  b.pass(200ms);
  EXPECT_EQ(b.listener.samples.back().flags, 0U);
}

TEST(ZwickLink, ARampThatWouldLeaveTheTravelWindowEndsThere) {
  FrameBench b;
  b.armed();
  auto limits = wide_limits();
  limits.travel_max = 1.05_mm;
  ASSERT_TRUE(b.run(b.frame->arm(limits)));
  const auto done = b.run(b.frame->ramp_force(1.0_N, 0.5_N_s));
  ASSERT_TRUE(done);
  EXPECT_EQ(done->reason, MotionEnd::travel_limit);
  EXPECT_NEAR(done->travel_m.value(), 1.05e-3, 1e-6);
}

TEST(ZwickLink, SamplesAreContinuousAndCarryDeviceTimeAndFlags) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(50)));
  ASSERT_TRUE(b.run(b.frame->move_to(0.2_mm, 0.1_mm_s)));
  b.pass(1s);
  const auto& s = b.listener.samples;
  ASSERT_GE(s.size(), 145U);
  EXPECT_LE(s.size(), 150U);
  for (std::size_t i = 1; i < s.size(); ++i) {
    ASSERT_EQ(s[i].device_seq, s[i - 1].device_seq + 1);
    ASSERT_NEAR(*s[i].device_time_s - *s[i - 1].device_time_s, 0.02, 1e-6);
    ASSERT_LE(to_seconds(s[i].received.time_since_epoch()) - *s[i].device_time_s, 0.1);
  }
  EXPECT_EQ(s[10].flags, frame_flag::kMoving);
  EXPECT_EQ(s.back().flags, 0U);
  EXPECT_NEAR(static_cast<double>(b.listener.batches), static_cast<double>(s.size()) / 5, 2);
  EXPECT_TRUE(b.listener.events.empty()) << b.listener.events.front();
}

TEST(ZwickLink, LostSamplesAreAGapWithItsSize) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(50)));
  b.pass(500ms);
  b.sim->faults.lose_samples = 7;
  b.pass(500ms);
  EXPECT_TRUE(b.listener.has_event("gap: sim:frame: 7 samples missing"));
  const auto gaps = std::ranges::count_if(
      b.listener.samples, [](const auto& s) { return (s.flags & frame_flag::kAfterGap) != 0; });
  EXPECT_EQ(gaps, 1);
}

TEST(ZwickLink, AJumpOfTheDeviceClockIsAnEvent) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(50)));
  b.pass(500ms);
  b.sim->faults.clock_jump_s = -3600;
  b.pass(500ms);
  EXPECT_TRUE(b.listener.has_event("device_clock_jump"));
}

TEST(ZwickLink, ForceBeyondTheCellIsAbsentAndFlagged) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(50)));
  b.scene.move_to(b.clock.now(), 3.5e-3, 1.0);  // somebody leans on it: 25 N on a 20 N cell
  b.pass(300ms);
  const auto& s = b.listener.samples.back();
  EXPECT_FALSE(s.force_N);
  EXPECT_NE(s.flags & frame_flag::kForceOverload, 0U);
}

TEST(ZwickLink, ZeroMovesTheOriginOfForceAndTravel) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->move_to(1.1_mm, 1.0_mm_s)));
  ASSERT_TRUE(b.run(b.frame->zero(true, true)));
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(10)));
  b.pass(500ms);
  EXPECT_EQ(b.listener.samples.back().force_N, 0.0);
  EXPECT_EQ(b.listener.samples.back().travel_m, 0.0);
  const auto done = b.run(b.frame->move_to(0.1_mm, 1.0_mm_s));
  ASSERT_TRUE(done);
  EXPECT_EQ(done->travel_m, 0.1e-3);
  EXPECT_NEAR(done->force_N.value(), 1.0, 1e-6);
}

TEST(ZwickReplay, PlaysRowsVerbatimAndRefusesMotion) {
  std::vector<RecordedRow> rows(3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].t_s = 0.2 + 0.1 * static_cast<double>(i);
    rows[i].force_N = 0.123457 * static_cast<double>(i + 1);
    rows[i].travel_m = static_cast<double>(12345 + 10000 * i) / 1e4 / 1e3;
  }
  rows[1].force_N.reset();
  FrameBench b(rows);
  ASSERT_TRUE(b.run(b.frame->identify()));
  EXPECT_FALSE(b.frame->capabilities().motion);
  EXPECT_FALSE(b.run(b.frame->arm(wide_limits())));
  EXPECT_FALSE(b.run(b.frame->move_to(1.0_mm, 1.0_mm_s)));
  EXPECT_TRUE(b.run(b.frame->set_sample_rate(50)));
  b.pass(1s);
  EXPECT_TRUE(b.listener.samples.empty());
  b.sim->start_recording();
  b.pass(1s);
  ASSERT_EQ(b.listener.samples.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(b.listener.samples[i].force_N, rows[i].force_N);
    EXPECT_EQ(b.listener.samples[i].travel_m, rows[i].travel_m);
    EXPECT_EQ(b.listener.samples[i].device_time_s, rows[i].t_s);
  }
  EXPECT_TRUE(b.sim->is_recording_over());
  EXPECT_TRUE(b.listener.has_event("device_recording_end"));
  EXPECT_TRUE(b.run(b.frame->stop()));
}

TEST(ZwickLink, LosesNoSampleInTwentySixMinutes) {
  FrameBench b;
  b.armed();
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(50)));
  b.pass(26min);
  EXPECT_NEAR(static_cast<double>(b.listener.samples.size()), 78'000, 10);
}

// Somebody moves the machine at its panel, or testXpert runs a test of its own.
TEST(ZwickObserver, LeavesAMotionAloneWhateverItDoes) {
  FrameBench b;
  b.scene.move_to(b.clock.now(), 0.9e-3, 1e-5);
  const auto arrival = b.scene.arrival();
  ASSERT_TRUE(b.run(b.frame->observe(50)));
  b.pass(5s);
  EXPECT_GE(b.listener.samples.size(), 240U);
  ASSERT_TRUE(b.run(b.frame->observe(10)));
  b.pass(1s);
  b.frame->close();
  b.pass(5s);
  EXPECT_EQ(b.scene.halts, 0);
  EXPECT_EQ(b.scene.arrival(), arrival);
}

TEST(ZwickObserver, CommandsNothing) {
  FrameBench b;
  ASSERT_TRUE(b.run(b.frame->observe(0)));
  const auto armed = b.run(b.frame->arm(wide_limits()));
  ASSERT_FALSE(armed);
  EXPECT_EQ(armed.error().code, Errc::bug);
  EXPECT_FALSE(b.sim->is_armed());
}

TEST(ZwickObserver, BecomesACommanderOnTheSameLink) {
  FrameBench b;
  ASSERT_TRUE(b.run(b.frame->observe(50)));
  b.pass(1s);
  b.armed();
  b.listener.samples.clear();
  b.pass(1s);
  EXPECT_TRUE(b.listener.samples.empty()) << "a new session sends none until it is asked";
  const auto done = b.run(b.frame->move_to(0.5_mm, 0.5_mm_s));
  ASSERT_TRUE(done) << done.error().what;
  EXPECT_TRUE(b.listener.lost.empty());
}

TEST(ZwickObserver, IsNotGreetedInAnotherWayByAGatewayThatDoesNotKnowIt) {
  ZwickSimSettings old;
  old.revision = 1;
  FrameBench b(old);
  b.scene.move_to(b.clock.now(), 0.9e-3, 1e-5);
  const auto seen = b.run(b.frame->observe(50));
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error().code, Errc::unsupported);
  EXPECT_THAT(seen.error().what, HasSubstr("revision 1"));
  EXPECT_EQ(b.scene.halts, 0) << "nobody said HELLO";
  const auto identity = b.run(b.frame->identify());
  ASSERT_TRUE(identity) << identity.error().what;
  EXPECT_FALSE(b.frame->capabilities().force_loop);
  b.pass(3s);
  EXPECT_TRUE(b.listener.lost.empty());
}

TEST(ZwickLink, TakesOverWhatBoundsTheForceLoop) {
  FrameBench b;
  ASSERT_TRUE(b.run(b.frame->identify()));
  const auto& loop = b.frame->capabilities().force_loop;
  ASSERT_TRUE(loop);
  EXPECT_EQ(loop->approach, 0.1_mm_s);
  EXPECT_EQ(loop->contact, Force::from_si(5e-4));
}

TEST(ZwickLink, TakesOverWhatEachRevisionStates) {
  for (const int revision : {1, 2, 3}) {
    ZwickSimSettings settings;
    settings.revision = revision;
    FrameBench b(settings);
    ASSERT_TRUE(b.run(b.frame->identify()));
    const FrameCapabilities& c = b.frame->capabilities();
    EXPECT_EQ(c.force_loop.has_value(), revision >= 2);
    EXPECT_EQ(c.travel_step && c.force_step && c.filter && c.play, revision >= 3);
    EXPECT_EQ(c.travel_step || c.force_step || c.filter || c.play, revision >= 3);
    b.armed();
    EXPECT_TRUE(b.run(b.frame->move_to(0.1_mm, 0.5_mm_s))) << revision;
  }
}

TEST(ZwickLink, GivesASlowMachineTheTimeThatItNeedsToStand) {
  PlantConfig slow = LinearScene::quiet();
  slow.deceleration_m_s2 = 0.5e-3;
  slow.contact_travel_m = 1;
  FrameBench b(slow);
  b.armed();
  const auto moving = b.begin(b.frame->move_to(4.0_mm, 2.0_mm_s));
  b.pass(500ms);
  const MonoTime begin = b.clock.now();
  const auto stopped = b.run(b.frame->stop());
  EXPECT_TRUE(stopped) << stopped.error().what;
  EXPECT_NEAR(to_seconds(b.clock.now() - begin), 4.0, 0.1);
}

}  // namespace
}  // namespace lcrig
