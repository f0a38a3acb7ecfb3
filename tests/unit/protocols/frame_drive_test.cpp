// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/frame_drive.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

class Drive : public RunFixture {
 protected:
  FrameDrive& drive() { return parts().drive; }
  void stop() {
    bool ended = false;
    start(drive().stop(), ended);
    clock.run_for(io, 1s);
    EXPECT_TRUE(ended);
  }
};

TEST_F(Drive, AStopSaysWhetherTheFrameStands) {
  stop();
  EXPECT_TRUE(drive().standing());
  EXPECT_EQ(drive().stands(), 1U);
  frame.stop_says = fail(Errc::no_reply, "silent");
  stop();
  EXPECT_FALSE(drive().standing());
  EXPECT_EQ(drive().failed_stops(), 1U);
  EXPECT_THAT(sink.kinds(), ElementsAre("stopped", "stop_failed"));
}

TEST_F(Drive, AFrameOfSomebodyElseIsOnlyObserved) {
  setup().commands = false;
  EXPECT_TRUE(run(drive().take_command()));
  stop();
  EXPECT_THAT(frame.commands, ElementsAre("observe"));
  EXPECT_EQ(drive().stands(), 1U) << "it counts as told";
}

TEST_F(Drive, NothingMovesAFrameOfSomebodyElse) {
  setup().commands = false;
  const auto may = drive().may_move();
  ASSERT_FALSE(may);
  EXPECT_EQ(may.error().code, Errc::bug);
  EXPECT_FALSE(run(drive().arm(FrameLimits())));
  EXPECT_FALSE(run(drive().hold_force(0.5)));
  EXPECT_THAT(frame.commands, IsEmpty());
}

TEST_F(Drive, LimitsAreSentWhenTheyChange) {
  FrameLimits limits;
  EXPECT_TRUE(run(drive().arm(limits)));
  EXPECT_TRUE(run(drive().arm(limits)));
  EXPECT_THAT(frame.commands, ElementsAre("arm"));
  limits.force_max = Force::from_si(0.5);
  EXPECT_TRUE(run(drive().arm(limits)));
  drive().forget_limits();
  EXPECT_TRUE(run(drive().arm(limits)));
  EXPECT_THAT(frame.commands, ElementsAre("arm", "arm", "arm"));
}

TEST_F(Drive, HandsOffMeansNothingMoves) {
  drive().will_hold(0.5);
  drive().keep_hands_off("it lies");
  EXPECT_FALSE(drive().may_move());
  EXPECT_FALSE(run(drive().arm(FrameLimits())));
  EXPECT_FALSE(run(drive().hold_force(0.5)));
  EXPECT_TRUE(run(drive().restore_hold())) << "there is none any more";
  EXPECT_THAT(frame.commands, IsEmpty());
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::fault);
  drive().keep_hands_off("again");
  EXPECT_EQ(drive().hands_off()->what, "it lies");
  EXPECT_THAT(sink.kinds(), ElementsAre("hands_off", "fault"));
}

TEST_F(Drive, AHoldIsRestored) {
  EXPECT_TRUE(run(drive().restore_hold()));
  EXPECT_THAT(frame.commands, IsEmpty());
  drive().will_hold(0.5);
  EXPECT_TRUE(run(drive().restore_hold()));
  EXPECT_TRUE(run(drive().hold_travel()));
  EXPECT_FALSE(drive().held_force_N());
  EXPECT_THAT(frame.commands, ElementsAre("hold_force", "hold_travel"));
}

}  // namespace
}  // namespace lcrig
