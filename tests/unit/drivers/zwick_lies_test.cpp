// SPDX-License-Identifier: Apache-2.0
// What a lie of the simulated frame does to the values shown and to the true ones, over memory in
// virtual time. The scene: 10 N/mm behind a gap of 1 mm.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/frame_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

PlantConfig noisy() {
  PlantConfig c = LinearScene::quiet();
  c.force_noise_N = 0.002;
  c.force_offset_N = 0.4;
  return c;
}

struct LieBench : FrameBench {
  explicit LieBench(const PlantConfig& config = noisy()) : FrameBench(config) {
    armed();
    EXPECT_TRUE(run(frame->set_sample_rate(50)));
    EXPECT_TRUE(run(frame->zero(true, false)));
  }
  template <class F>
  void lie(F change) {
    change(sim->faults.lies);
    sim->poke();
    settle();
  }
  // From here on the listener hears only what is new.
  void listen() {
    pass(200ms);
    listener.samples.clear();
  }
  double true_N() const { return scene.force_N(clock.now()); }
  double true_mm() const { return scene.travel_m(clock.now()) * 1e3; }
  double shown_N() const { return listener.samples.back().force_N.value(); }
  double shown_mm() const { return listener.samples.back().travel_m.value() * 1e3; }
  bool stands(Duration d) {
    const double before = true_mm();
    pass(d);
    return before == true_mm();
  }
};

TEST(ZwickLies, AFrozenCellRepeatsItsLastValueAndTheDeviceBelievesIt) {
  LieBench b;
  const auto press = b.begin(b.frame->move_until_force(1.0_N, 0.1_mm_s, 1.4_mm));
  b.pass(10500ms);  // 50 um inside the specimen
  b.lie([](ZwickSimLies& l) { l.force_frozen = true; });
  b.listen();
  const auto r = b.await(*press);
  EXPECT_EQ(r->reason, MotionEnd::travel_limit);
  EXPECT_NEAR(b.true_N(), 4, 0.05);
  for (const FrameSample& s : b.listener.samples) EXPECT_EQ(s.force_N, b.shown_N());
  EXPECT_NEAR(b.shown_N(), 0.5, 0.05);
  b.lie([](ZwickSimLies& l) { l.force_frozen = false; });
  b.pass(1s);
  EXPECT_NEAR(b.shown_N(), 4, 0.05);
}

TEST(ZwickLies, AForceWithTheWrongSignStopsTheDeviceAtTheOtherLimit) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.force_reversed = true; });
  const auto press = b.begin(b.frame->move_until_force(1.0_N, 0.1_mm_s, 1.4_mm));
  const auto r = b.await(*press);
  EXPECT_EQ(r->reason, MotionEnd::force_limit);
  b.pass(1s);
  EXPECT_NEAR(b.true_N(), 1, 0.05);
  EXPECT_NEAR(b.shown_N(), -1, 0.05);
}

TEST(ZwickLies, ADriftStaysAndTheDeviceTakesItForForce) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.force_drift_N_s = 0.1; });
  b.pass(2s);
  b.lie([](ZwickSimLies& l) { l.force_drift_N_s = 0; });
  b.pass(1s);
  EXPECT_NEAR(b.shown_N(), 0.2, 0.02);
  const auto press = b.begin(b.frame->move_until_force(1.0_N, 0.1_mm_s, 1.4_mm));
  const auto r = b.await(*press);
  EXPECT_EQ(r->reason, MotionEnd::target);
  EXPECT_NEAR(b.true_N(), 0.8, 0.03);
  b.lie([](ZwickSimLies& l) { l.force_drift_N_s = 5; });
  const auto up = b.begin(b.frame->move_to(1.3_mm, 0.01_mm_s));
  EXPECT_EQ(b.await(*up)->reason, MotionEnd::force_limit);
  EXPECT_LT(b.true_N(), 1.1);
}

TEST(ZwickLies, ScatterGrows) {
  LieBench b;
  const auto spread = [&b] {
    b.listen();
    b.pass(10s);
    double sum = 0;
    for (const FrameSample& s : b.listener.samples) sum += *s.force_N * *s.force_N;
    return std::sqrt(sum / static_cast<double>(b.listener.samples.size()));
  };
  const double before = spread();
  b.lie([](ZwickSimLies& l) { l.force_scatter = 10; });
  EXPECT_NEAR(spread() / before, 10, 1);
}

TEST(ZwickLies, AReversedDriveLeavesItsTargetAndShowsIt) {
  LieBench b;
  const auto move = b.begin(b.frame->move_to(0.5_mm, 0.1_mm_s));
  b.pass(1s);
  b.lie([](ZwickSimLies& l) { l.drive_reversed = true; });
  b.pass(3s);
  EXPECT_NEAR(b.shown_mm(), -0.2, 0.02);
  EXPECT_NEAR(b.true_mm(), -0.2, 0.02);
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::stopped);
  EXPECT_TRUE(b.stands(1s));
  // The device checks both limits, whichever way it was told to go.
  const auto away = b.begin(b.frame->move_to(-1.0_mm, 0.1_mm_s));
  EXPECT_EQ(b.await(*away)->reason, MotionEnd::force_limit);
  EXPECT_NEAR(b.true_N(), 10, 0.1);
}

TEST(ZwickLies, AMirroredDriveLeavesItsTargetAndShowsThatItObeys) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.drive_mirrored = true; });
  const double before_mm = b.true_mm();
  const auto move = b.begin(b.frame->move_to(0.2_mm, 0.1_mm_s));
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::target);
  EXPECT_NEAR(b.shown_mm(), 0.2, 3e-3);
  EXPECT_NEAR(b.true_mm(), before_mm - 0.2, 3e-3);
}

TEST(ZwickLies, TheAxisCreepsAfterItsMotionUntilItIsStopped) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.creep_m_s = 5e-6; });
  const auto move = b.begin(b.frame->move_to(0.5_mm, 0.1_mm_s));
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::target);
  EXPECT_FALSE(b.sim->is_moving());
  b.pass(10s);
  EXPECT_NEAR(b.true_mm(), 0.55, 0.001);
  EXPECT_NEAR(b.shown_mm(), 0.55, 0.002);
  EXPECT_EQ(b.listener.samples.back().flags & frame_flag::kMoving, 0);
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_TRUE(b.stands(2s));
}

TEST(ZwickLies, DoneComesHalfWayWithTheTargetsOwnValues) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.done_early = true; });
  const auto move = b.begin(b.frame->move_to(0.8_mm, 0.1_mm_s));
  const auto r = b.await(*move);
  EXPECT_EQ(r->reason, MotionEnd::target);
  EXPECT_DOUBLE_EQ(r->travel_m.value(), 0.8e-3);
  EXPECT_NEAR(b.true_mm(), 0.4, 0.01);
  EXPECT_FALSE(b.sim->is_moving());
  b.pass(5s);
  EXPECT_NEAR(b.true_mm(), 0.8, 1e-6) << "it went on";
  // During a motion it takes effect at once.
  b.lie([](ZwickSimLies& l) { l.done_early = false; });
  const auto press = b.begin(b.frame->move_until_force(1.0_N, 0.1_mm_s, 1.4_mm));
  b.pass(1s);
  b.lie([](ZwickSimLies& l) { l.done_early = true; });
  EXPECT_TRUE(press->done());
  EXPECT_DOUBLE_EQ(b.await(*press)->force_N.value(), 1);
  EXPECT_LT(b.true_N(), 0.1);
}

TEST(ZwickLies, AfterAnEarlyDoneTheNextOrderIsObeyed) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.done_early = true; });
  const auto move = b.begin(b.frame->move_to(0.8_mm, 0.1_mm_s));
  EXPECT_TRUE(b.await(*move));
  b.lie([](ZwickSimLies& l) { l.done_early = false; });
  const auto back = b.begin(b.frame->move_to(0.0_mm, 0.1_mm_s));
  EXPECT_EQ(b.await(*back)->reason, MotionEnd::target);
  EXPECT_NEAR(b.true_mm(), 0, 1e-6);
}

TEST(ZwickLies, DoneClaimsAMotionThatNeverWas) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.done_unmoved = true; });
  const auto press = b.begin(b.frame->move_until_force(1.0_N, 0.1_mm_s, 1.4_mm));
  const auto r = b.await(*press);
  EXPECT_EQ(r->reason, MotionEnd::target);
  EXPECT_DOUBLE_EQ(r->force_N.value(), 1);
  EXPECT_EQ(b.true_mm(), 0);
}

TEST(ZwickLies, DoneComesLateAndAStopFetchesIt) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.done_late_s = 3; });
  const auto move = b.begin(b.frame->move_to(0.1_mm, 0.1_mm_s));
  b.pass(3900ms);
  EXPECT_FALSE(move->done());
  b.pass(200ms);
  EXPECT_TRUE(move->done());
  const auto again = b.begin(b.frame->move_to(0.2_mm, 0.1_mm_s));
  b.pass(1500ms);
  EXPECT_FALSE(again->done());
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_TRUE(again->done());
}

TEST(ZwickLies, AnOrderIsObeyedLateThoughAStopCameInBetween) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.order_late_s = 3; });
  const auto move = b.begin(b.frame->move_to(0.5_mm, 0.1_mm_s));
  b.pass(1s);
  EXPECT_FALSE(move->done());
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::stopped);
  EXPECT_EQ(b.true_mm(), 0);
  b.pass(4s);
  EXPECT_GT(b.true_mm(), 0.15);
  EXPECT_TRUE(b.sim->is_moving());
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_TRUE(b.stands(5s));
}

TEST(ZwickLies, TheDeviceClockStandsStillOrRunsTwiceAsFast) {
  LieBench b;
  b.pass(1s);
  const double before = b.listener.samples.back().device_time_s.value();
  b.lie([](ZwickSimLies& l) { l.clock_rate = 0; });
  b.pass(2s);
  EXPECT_NEAR(b.listener.samples.back().device_time_s.value(), before, 0.2);
  b.lie([](ZwickSimLies& l) { l.clock_rate = 2; });
  b.pass(2s);
  EXPECT_NEAR(b.listener.samples.back().device_time_s.value(), before + 4, 0.4);
  b.lie([](ZwickSimLies& l) { l.clock_rate = 1; });
  b.pass(2s);
  EXPECT_NEAR(b.listener.samples.back().device_time_s.value(), before + 6, 0.4);
}

TEST(ZwickLies, ATareIsLostWithAndWithoutAWord) {
  for (const bool tells : {false, true}) {
    LieBench b;
    b.pass(1s);
    EXPECT_NEAR(b.shown_N(), 0, 0.02);
    b.sim->faults.lose_tare = true;
    b.sim->faults.tell_origin = tells;
    b.sim->poke();
    b.pass(1s);
    EXPECT_NEAR(b.shown_N(), 0.4, 0.02);
    EXPECT_EQ(std::ranges::any_of(b.listener.events,
                                  [](const auto& e) { return e.find("origin") != e.npos; }),
              tells);
  }
}

TEST(ZwickLies, AnEStopEndsTheMotionAndOthersAreRefusedUntilItIsTurnedBack) {
  LieBench b;
  const auto move = b.begin(b.frame->move_to(0.5_mm, 0.1_mm_s));
  b.pass(1s);
  b.lie([](ZwickSimLies& l) { l.estop = true; });
  const auto r = b.await(*move);
  EXPECT_EQ(r->reason, MotionEnd::fault);
  EXPECT_EQ(r->detail, "E-stop");
  b.settle();
  EXPECT_TRUE(std::ranges::any_of(b.listener.events,
                                  [](const auto& e) { return e.find("estop") != e.npos; }));
  const auto no = b.run(b.frame->move_to(0.6_mm, 0.1_mm_s));
  ASSERT_FALSE(no);
  EXPECT_EQ(no.error().code, Errc::frame_fault);
  EXPECT_TRUE(b.stands(1s));
  b.lie([](ZwickSimLies& l) { l.estop = false; });
  EXPECT_TRUE(b.run(b.frame->move_to(0.6_mm, 0.1_mm_s)));
}

TEST(ZwickLies, AStopIsConfirmedLateOrNever) {
  LieBench b;
  b.lie([](ZwickSimLies& l) { l.stop_late_s = 0.5; });
  const auto move = b.begin(b.frame->move_to(0.5_mm, 0.1_mm_s));
  b.pass(1s);
  const MonoTime asked = b.clock.now();
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_GE(b.clock.now() - asked, 500ms);
  EXPECT_EQ(b.await(*move)->reason, MotionEnd::stopped);
  // It also does so if something is moving again by then.
  b.lie([](ZwickSimLies& l) { l.stop_late_s = 5; });
  EXPECT_FALSE(b.run(b.frame->stop()));
  const auto on = b.begin(b.frame->move_to(0.9_mm, 0.05_mm_s));
  b.pass(10s);
  b.lie([](ZwickSimLies& l) { l.stop_late_s = 0; });
  EXPECT_TRUE(b.run(b.frame->stop()));
  EXPECT_TRUE(b.await(*on));
  b.lie([](ZwickSimLies& l) { l.stop_unconfirmed = true; });
  const auto again = b.begin(b.frame->move_to(0.5_mm, 0.1_mm_s));
  b.pass(1s);
  EXPECT_FALSE(b.run(b.frame->stop()));
  EXPECT_TRUE(b.stands(1s));
}

TEST(ZwickLies, AStopThatIsIgnoredStopsNothing) {
  LieBench b;
  const auto move = b.begin(b.frame->move_to(0.9_mm, 0.01_mm_s));
  b.pass(1s);
  b.lie([](ZwickSimLies& l) { l.stop_ignored = true; });
  EXPECT_FALSE(b.run(b.frame->stop()));
  EXPECT_FALSE(b.stands(1s));
  b.lie([](ZwickSimLies& l) { l.stop_ignored = false; });
  EXPECT_TRUE(b.run(b.frame->stop()));
}

TEST(ZwickLies, AForceLoopBelievesItsCell) {
  LieBench frozen;
  const auto ramp = frozen.begin(frozen.frame->ramp_force(1.0_N, ForceRate::from_si(0.1)));
  frozen.pass(15s);  // 1 mm at 0.1 mm/s, and half of the ramp
  const double before = frozen.true_N();
  EXPECT_GT(before, 0.2);
  EXPECT_LT(before, 0.8);
  frozen.lie([](ZwickSimLies& l) { l.force_frozen = true; });
  frozen.pass(20s);
  EXPECT_NEAR(frozen.true_N(), before + 2, 0.1);
  EXPECT_FALSE(ramp->done());
  EXPECT_TRUE(frozen.run(frozen.frame->stop()));

  LieBench drifting;
  const auto up = drifting.begin(drifting.frame->ramp_force(1.0_N, ForceRate::from_si(0.2)));
  EXPECT_TRUE(drifting.await(*up));
  EXPECT_NEAR(drifting.true_N(), 1, 0.02);
  drifting.lie([](ZwickSimLies& l) { l.force_drift_N_s = -0.05; });
  drifting.pass(10s);
  EXPECT_NEAR(drifting.true_N(), 1.5, 0.05);
  EXPECT_NEAR(drifting.shown_N(), 1, 0.05);
}

TEST(ZwickLies, CapabilitiesChangeWithTheNextSession) {
  LieBench b;
  const auto before = b.frame->capabilities();
  b.lie([](ZwickSimLies& l) { l.other_caps = true; });
  ASSERT_TRUE(b.run(b.frame->observe(10)));
  EXPECT_DOUBLE_EQ(b.frame->capabilities().deceleration.si(), before.deceleration.si() / 2);
}

}  // namespace
}  // namespace lcrig
