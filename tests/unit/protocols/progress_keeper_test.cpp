// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/progress_keeper.hpp"

#include <gtest/gtest.h>

#include <type_traits>

#include "base/either.hpp"
#include "protocols/steps/ask.hpp"
#include "protocols/steps/place_weight.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// A state in which the run waits is not entered without the proof of a standstill.
template <RunState kState>
concept EnteredFreely = requires(ProgressKeeper& keeper) { keeper.enter<kState>(); };
template <RunState kState>
concept ShownFreely = requires(ProgressKeeper& keeper) { keeper.show<kState>(); };
static_assert(EnteredFreely<RunState::running> && ShownFreely<RunState::stopping>);
static_assert(!EnteredFreely<RunState::paused> && !ShownFreely<RunState::paused>);
static_assert(!ShownFreely<RunState::waiting_for_operator>);
static_assert(!ShownFreely<RunState::waiting_for_instrument>);
static_assert(!std::is_default_constructible_v<Stands>);

class Progress : public RunFixture {
 protected:
  ProgressKeeper& progress() { return parts().progress; }
  Task<> wait_as(RunState state) {
    const auto waiting = co_await parts().wait_as(state);
    co_await clock.wait_until(MonoTime::max());
  }
  Task<std::size_t> cut_off(RunState state) {
    auto r = co_await first_to_end(wait_as(state), interrupt());
    co_return r;
  }
  // Executes a step that something interrupts after 10 s.
  template <class S>
  Task<> carry_out(const S& what, typename S::Progress& remembered) {
    auto r = co_await either(what.execute(parts(), remembered), clock.wait_for(10s));
    static_cast<void>(r);
  }
  Task<> interrupt() {
    co_await clock.wait_for(1s);
    at_interrupt = progress().state();
  }

  std::optional<RunState> at_interrupt;
};

TEST_F(Progress, BeginsWithWhatTheRunIsAbout) {
  setup().run = 7;
  setup().specimen = "foam";
  setup().planned.total_s = 60;
  const RunProgress& now = progress().now();
  EXPECT_EQ(now.run, 7);
  EXPECT_EQ(now.protocol, "t");
  EXPECT_EQ(now.specimen, "foam");
  EXPECT_EQ(now.planned_s, 60);
  EXPECT_EQ(now.left_s, 60);
  EXPECT_EQ(now.state, RunState::preparing);
}

TEST_F(Progress, NamesTheStepTheRepeatAndWhatIsDone) {
  progress().enter_repeat(2, 3);
  progress().enter_step(step(1));
  progress().count_step();
  EXPECT_EQ(progress().now().repeat, 2);
  EXPECT_EQ(progress().now().repeats, 3);
  EXPECT_EQ(progress().now().step_id, "s");
  EXPECT_EQ(progress().now().step_kind, "measure");
  EXPECT_EQ(progress().steps_done(), 1);
}

TEST_F(Progress, AStateThatWasInterruptedComesBack) {
  progress().enter<RunState::running>();
  EXPECT_EQ(run(cut_off(RunState::waiting_for_operator)), 1U);
  EXPECT_EQ(at_interrupt, RunState::waiting_for_operator);
  EXPECT_EQ(progress().state(), RunState::running);
}

// An instrument is lost while somebody has paused the run.
TEST_F(Progress, AStateWithinAnotherEndsInThatOne) {
  progress().enter<RunState::running>();
  {
    const auto stopping = progress().show<RunState::stopping>();
    EXPECT_EQ(run(cut_off(RunState::waiting_for_instrument)), 1U);
    EXPECT_EQ(progress().state(), RunState::stopping);
  }
  EXPECT_EQ(progress().state(), RunState::running);
}

TEST_F(Progress, AWaitIsShownOnlyWhileTheFrameStands) {
  progress().enter<RunState::running>();
  bool done = false;
  start(wait_as(RunState::paused), done);
  clock.run_for(io, 1s);
  EXPECT_EQ(progress().state(), RunState::paused);
  EXPECT_EQ(progress().now().standstill, Standstill::confirmed);
  parts().drive.doubt_standstill();
  EXPECT_EQ(progress().state(), RunState::stopping);
  EXPECT_EQ(progress().now().standstill, Standstill::not_confirmed);
  parts().drive.lose_link();
  EXPECT_EQ(progress().now().standstill, Standstill::unknown);
}

TEST_F(Progress, AStopThatIsNotConfirmedIsRepeatedOnceASecondAndNothingWaitsMeanwhile) {
  frame.stop_says = fail(Errc::not_standing, "STOP twice -> standstill not confirmed");
  progress().enter<RunState::running>();
  bool done = false;
  start(wait_as(RunState::paused), done);
  clock.run_for(io, 900ms);
  EXPECT_EQ(progress().now().standstill, Standstill::awaited);
  clock.run_for(io, 200ms);
  EXPECT_EQ(progress().now().standstill, Standstill::not_confirmed);
  clock.run_for(io, 9s);
  EXPECT_EQ(progress().state(), RunState::stopping);
  EXPECT_EQ(progress().now().standstill, Standstill::not_confirmed);
  EXPECT_EQ(std::ranges::count(frame.commands, "stop"), 11);
  EXPECT_EQ(events_of("stop_failed"), 1) << "written once";
  frame.stop_says = Result<>();
  clock.run_for(io, 1s);
  EXPECT_EQ(progress().state(), RunState::paused);
}

TEST_F(Progress, ARunThatMovesNothingWaitsAtOnce) {
  setup().commands = false;
  progress().enter<RunState::running>();
  bool done = false;
  start(wait_as(RunState::paused), done);
  clock.run_for(io, 1ms);
  EXPECT_EQ(progress().state(), RunState::paused);
  EXPECT_EQ(progress().now().standstill, Standstill::cannot_move);
  EXPECT_TRUE(frame.commands.empty());
}

// `finally` may ask, too, and continues afterwards.
TEST_F(Progress, AQuestionOfFinallyLeavesTheRunFinishing) {
  AskStep ask;
  ask.text = "Lid open?";
  ask.timeout = Number(60);
  AskStep::Progress remembered;
  parts().log.begin_step(step(0));
  progress().enter<RunState::finishing>();
  bool done = false;
  start(carry_out(ask, remembered), done);
  clock.run_for(io, 1s);
  EXPECT_EQ(progress().state(), RunState::waiting_for_operator);
  EXPECT_TRUE(parts().questions.answer(true, "ann", std::nullopt));
  clock.run_for(io, 1s);
  EXPECT_TRUE(done);
  EXPECT_EQ(progress().state(), RunState::finishing);
}

TEST_F(Progress, AWeightThatAPersonPlacesIsWaitedForUntilSomethingInterrupts) {
  PlaceWeightStep place;
  place.load.kind = TargetKind::mass;
  place.load.value = Number(0.1);
  PlaceWeightStep::Progress remembered;
  frame.never_ends = true;
  progress().enter<RunState::running>();
  bool done = false;
  start(carry_out(place, remembered), done);
  clock.run_for(io, 5s);
  EXPECT_EQ(progress().state(), RunState::waiting_for_operator);
  clock.run_for(io, 10s);
  EXPECT_TRUE(done);
  EXPECT_EQ(progress().state(), RunState::running);
}

}  // namespace
}  // namespace lcrig
