// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/rest_meter.hpp"

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

class Meter : public RunFixture {
 protected:
  RestMeter& meter() { return parts().meter; }
  const FrameState& shown() { return parts().rig.frame; }
  Task<> slow_samples() {  // five a second
    for (int i = 0; i < 20; ++i) {
      co_await clock.wait_for(200ms);
      show(1e-4 * (i % 3), 1e-3);
    }
  }
};

TEST_F(Meter, AForceOfLongAgoTellsNoWay) {
  EXPECT_EQ(meter().present_force_N().error().code, Errc::no_reply) << "never seen";
  show(0.1, 1e-3);
  EXPECT_DOUBLE_EQ(meter().present_force_N().value(), 0.1);
  clock.run_for(io, 1s);
  EXPECT_EQ(meter().present_force_N().error().code, Errc::no_reply);
  EXPECT_DOUBLE_EQ(*shown().force_N, 0.1) << "the last one that was known";
}

// Half a second of a slow frame is one sample or two: it is measured until there are ten.
TEST_F(Meter, ARestMeasurementHasTenForcesAtLeast) {
  asio::co_spawn(io, slow_samples(), asio::detached);
  const auto rest = run(meter().measure(500ms));
  ASSERT_TRUE(rest) << rest.error().what;
  EXPECT_GE(rest->forces(), 10);
  EXPECT_LE(rest->forces(), 11);
}

TEST_F(Meter, WhereAMotionEndedIsNewerThanTheLastSample) {
  show(0.5, 1e-3);
  MotionOutcome end;
  end.force_N = 0.2;
  end.travel_m = 2e-3;
  parts().watch.motion_stood(end);
  EXPECT_DOUBLE_EQ(*shown().force_N, 0.2);
  EXPECT_DOUBLE_EQ(*shown().seen.travel_m, 2e-3);
  EXPECT_DOUBLE_EQ(*shown().shown_force_N, 0.5) << "by its samples";
  EXPECT_DOUBLE_EQ(*shown().shown_travel_m, 1e-3);
}

TEST_F(Meter, AnOverloadOrSamplesWithoutAForceHideTheOneOfNow) {
  const auto dark = [this](std::uint32_t flags) {
    FrameSample s = frame.sample();
    s.force_N.reset();
    s.flags = flags;
    parts().watch.add(s);
  };
  EXPECT_FALSE(parts().rig.shows_force()) << "never seen";
  show(0.5, 1e-3);
  EXPECT_TRUE(parts().rig.shows_force());
  dark(frame_flag::kForceOverload);
  EXPECT_FALSE(parts().rig.shows_force());
  show(4.6, 1e-3);
  EXPECT_TRUE(parts().rig.shows_force());
  dark(0);
  EXPECT_TRUE(parts().rig.shows_force()) << "one sample without a force";
  clock.run_for(io, from_seconds(3 / parts().rig.facts.rate_Hz));
  dark(0);
  EXPECT_FALSE(parts().rig.shows_force()) << "and more than two";
  show(4.6, 1e-3);
  clock.run_for(io, 1s);
  dark(0);
  EXPECT_FALSE(parts().rig.shows_force());
}

TEST_F(Meter, ACellThatShowsOneValueIsNotAlive) {
  feed();
  EXPECT_EQ(run(meter().measure_alive()).error().code, Errc::refused);
  frame.noise_N = 1e-4;
  const auto rest = run(meter().measure_alive());
  ASSERT_TRUE(rest) << rest.error().what;
  EXPECT_NEAR(rest->force_N(), 5e-5, 1e-5);
  EXPECT_DOUBLE_EQ(meter().noise_N(), rest->scatter_N());
}

TEST_F(Meter, SilenceIsNoReply) {
  EXPECT_EQ(run(meter().measure(500ms)).error().code, Errc::no_reply);
  EXPECT_EQ(run(meter().await_samples(false)).error().code, Errc::no_reply);
  feed();
  EXPECT_TRUE(run(meter().await_samples(true)));
}

TEST_F(Meter, AfterALossOnlyTheZeroIsRemembered) {
  show(0.5, 1e-3);
  parts().watch.take_over_zeros(true, std::nullopt);
  parts().watch.link_back();
  EXPECT_FALSE(shown().seen.travel_m);
  EXPECT_TRUE(shown().seen.zeroed);
}

}  // namespace
}  // namespace lcrig
