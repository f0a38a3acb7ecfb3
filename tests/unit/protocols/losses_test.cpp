// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/losses.hpp"

#include <gmock/gmock.h>

#include "protocols/steps/ask.hpp"
#include "protocols/steps/find_contact.hpp"
#include "protocols/steps/measure.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

class Loss : public RunFixture {
 protected:
  Loss() {
    protocol.on_loss = OnLoss::wait;
    frame.noise_N = 1e-4;
    feed();
    parts().progress.enter<RunState::running>();
    parts().drive.set_prepared(true);
    parts().log.begin_step(step(0));
    parts().watch.learn_zero(run(parts().meter.measure_alive()).value());
  }
  std::optional<InterruptRequest> survive() {
    parts().interrupts.take();  // the loss itself
    return run(losses.survive(progress));
  }
  static Error gone() { return Error(Errc::disconnected, "gone"); }

  Losses losses{parts()};
  MeasureStep::Progress progress;
};

TEST_F(Loss, IsToldOnce) {
  losses.lose_frame(gone());
  losses.lose_frame(gone());
  EXPECT_EQ(events_of("loss"), 1);
  EXPECT_EQ(parts().interrupts.take().kind, Interrupt::loss);
  EXPECT_TRUE(parts().interrupts.empty());
  EXPECT_EQ(losses.frame_away()->what, "gone");
}

TEST_F(Loss, OfAMeterIsSurvivedOnceItIsBack) {
  losses.lose_meter(gone());
  EXPECT_FALSE(survive());
  EXPECT_FALSE(losses.is_away());
  EXPECT_EQ(parts().progress.state(), RunState::running);
  EXPECT_EQ(events_of("gap"), 1);
  EXPECT_EQ(events_of("reconnected"), 1);
}

TEST_F(Loss, OfAFrameIsSurvivedWhereItStandsWhereItWas) {
  losses.lose_frame(gone());
  const auto stop = survive();
  EXPECT_FALSE(stop) << stop->why;
  EXPECT_TRUE(parts().drive.standing());
  EXPECT_THAT(frame.commands, ElementsAre("stop", "reconnect", "stop", "arm", "rate", "stop"))
      << "the samples after the last one show that it stands";
}

TEST_F(Loss, OfAFrameThatWasMovedMeanwhileEndsTheRunWithHandsOff) {
  losses.lose_frame(gone());
  frame.travel_m += 1e-3;
  const auto stop = survive();
  ASSERT_TRUE(stop);
  EXPECT_THAT(stop->why, HasSubstr("it was moved meanwhile"));
  EXPECT_TRUE(stop->hands_off) << "the reason of the run tells it once";
  EXPECT_FALSE(parts().drive.may_move());
}

TEST_F(Loss, OfItsZeroEndsTheRunBeforeAnythingIsArmed) {
  frame.zero_of = "1";
  losses.lose_frame(gone());
  frame.zero_of = "2";
  EXPECT_THAT(survive()->why, HasSubstr("(origin 2, before it was 1)"));
  EXPECT_EQ(std::ranges::count(frame.commands, "arm"), 0);
}

TEST_F(Loss, EndsTheRunWhereTheProtocolSaysSo) {
  protocol.on_loss = OnLoss::abort;
  losses.lose_meter(gone());
  EXPECT_EQ(survive()->kind, Interrupt::fault);
}

TEST_F(Loss, ThatLastsTooLongEndsTheRun) {
  protocol.on_loss_timeout = 10s;
  frame.reconnect_says = fail(Errc::disconnected, "no port");
  losses.lose_frame(gone());
  EXPECT_THAT(survive()->why, HasSubstr("it did not come back within 10 s"));
}

TEST_F(Loss, AFifthTimeWithinAMinuteEndsTheRun) {
  for (int i = 0; i < 4; ++i) {
    losses.lose_meter(gone());
    EXPECT_FALSE(survive());
  }
  losses.lose_meter(gone());
  EXPECT_THAT(survive()->why, HasSubstr("(lost 5 times within a minute)"));
}

TEST_F(Loss, BeginsTheStepAgainWhereTheProtocolSaysSo) {
  protocol.on_loss = OnLoss::repeat_step;
  progress.level = parts().labels.next("s", 5, clock.now());
  progress.readings = 3;
  losses.lose_meter(gone());
  EXPECT_FALSE(survive());
  EXPECT_EQ(events_of("level_abandoned"), 1);
  EXPECT_FALSE(progress.level);
  EXPECT_EQ(progress.readings, 0);
  EXPECT_EQ(parts().labels.next("s", 5, clock.now()).index, 1);
}

TEST_F(Loss, LeavesAStepThatBeginsAgainWhatItMayNotForget) {
  protocol.on_loss = OnLoss::repeat_step;
  FindContactStep::Progress search;
  search.start_travel_m = 1e-3;
  AskStep::Progress ask;
  ask.answered = true;
  ask.time.begin(clock.now() - 5s, 60s);
  for (StepProgress* of : {static_cast<StepProgress*>(&search), static_cast<StepProgress*>(&ask)}) {
    losses.lose_meter(gone());
    parts().interrupts.take();
    EXPECT_FALSE(run(losses.survive(*of)));
  }
  EXPECT_TRUE(search.start_travel_m) << "where it began";
  EXPECT_TRUE(ask.answered) << "nobody is asked twice";
  EXPECT_EQ(ask.time.begin(clock.now(), 60s), clock.now() + 60s);
}

TEST_F(Loss, AStopMeanwhileIsTaken) {
  frame.reconnect_says = fail(Errc::disconnected, "no port");
  losses.lose_frame(gone());
  parts().interrupts.take();
  parts().interrupts.ask(InterruptRequest(Interrupt::abort, "test"));
  EXPECT_EQ(run(losses.survive(progress))->kind, Interrupt::abort);
}

TEST_F(Loss, APauseMeanwhileIsRemembered) {
  losses.lose_frame(gone());
  parts().interrupts.take();
  parts().interrupts.ask(InterruptRequest(Interrupt::pause, "test"));
  EXPECT_FALSE(run(losses.survive(progress)));
  EXPECT_TRUE(losses.take_pause());
  EXPECT_FALSE(losses.take_pause());
}

TEST_F(Loss, OfTheMeterMattersToNoStepOfFinally) {
  parts().interrupts.begin_finish(std::nullopt);
  losses.lose_meter(gone());
  EXPECT_TRUE(parts().interrupts.empty());
  EXPECT_FALSE(losses.is_of_loss(step(1), gone()));
}

TEST_F(Loss, ExplainsTheFailureOfAStepThatNeededTheInstrument) {
  EXPECT_FALSE(losses.is_of_loss(step(1), gone()));
  losses.lose_meter(gone());
  EXPECT_TRUE(losses.is_of_loss(step(1), gone())) << "it measures";
  EXPECT_FALSE(losses.is_of_loss(step(0), gone())) << "it only moves";
  losses.lose_frame(gone());
  EXPECT_TRUE(losses.is_of_loss(step(0), gone()));
  EXPECT_FALSE(losses.is_of_loss(step(0), Error(Errc::limit_tripped, "too far")));
}

}  // namespace
}  // namespace lcrig
