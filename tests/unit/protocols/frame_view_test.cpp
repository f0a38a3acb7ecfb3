// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_view.hpp"

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

class View : public RunFixture {
 protected:
  FrameView& view() { return parts().view; }
};

TEST_F(View, AForceOfLongAgoTellsNoWay) {
  EXPECT_EQ(view().present_force_N().error().code, Errc::no_reply) << "never seen";
  show(0.1, 1e-3);
  EXPECT_DOUBLE_EQ(view().present_force_N().value(), 0.1);
  clock.run_for(io, 1s);
  EXPECT_EQ(view().present_force_N().error().code, Errc::no_reply);
  EXPECT_DOUBLE_EQ(*view().force_N(), 0.1) << "the last one that was known";
}

TEST_F(View, WhereAMotionEndedIsNewerThanTheLastSample) {
  show(0.5, 1e-3);
  MotionOutcome end;
  end.force_N = 0.2;
  end.travel_m = 2e-3;
  view().take_standstill(end);
  EXPECT_DOUBLE_EQ(*view().force_N(), 0.2);
  EXPECT_DOUBLE_EQ(*view().travel_m(), 2e-3);
  EXPECT_DOUBLE_EQ(*view().shown_force_N(), 0.5) << "by its samples";
  EXPECT_DOUBLE_EQ(*view().shown_travel_m(), 1e-3);
}

TEST_F(View, AnOverloadOrSamplesWithoutAForceHideTheOneOfNow) {
  const auto dark = [this](std::uint32_t flags) {
    FrameSample s = frame.sample();
    s.force_N.reset();
    s.flags = flags;
    view().add(std::span(&s, 1));
  };
  EXPECT_FALSE(view().shows_force()) << "never seen";
  show(0.5, 1e-3);
  EXPECT_TRUE(view().shows_force());
  dark(frame_flag::kForceOverload);
  EXPECT_FALSE(view().shows_force());
  show(4.6, 1e-3);
  EXPECT_TRUE(view().shows_force());
  dark(0);
  EXPECT_TRUE(view().shows_force()) << "one sample without a force";
  clock.run_for(io, 1s);
  dark(0);
  EXPECT_FALSE(view().shows_force());
}

TEST_F(View, ACellThatShowsOneValueIsNotAlive) {
  feed();
  EXPECT_EQ(run(view().living_rest()).error().code, Errc::refused);
  frame.noise_N = 1e-4;
  const auto rest = run(view().living_rest());
  ASSERT_TRUE(rest) << rest.error().what;
  EXPECT_NEAR(rest->force_N(), 5e-5, 1e-5);
  EXPECT_DOUBLE_EQ(view().shown_force().wavers_N, rest->scatter_N());
}

TEST_F(View, SilenceIsNoReply) {
  EXPECT_EQ(run(view().watch_rest(500ms)).error().code, Errc::no_reply);
  EXPECT_EQ(run(view().await_samples(false)).error().code, Errc::no_reply);
  feed();
  EXPECT_TRUE(run(view().await_samples(true)));
}

TEST_F(View, AfterALossOnlyTheZeroIsRemembered) {
  show(0.5, 1e-3);
  view().forget(true);
  EXPECT_FALSE(view().travel_m());
  EXPECT_TRUE(view().memory().zeroed);
}

}  // namespace
}  // namespace lcrig
