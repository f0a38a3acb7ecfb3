// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/finish.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "protocols/run/losses.hpp"
#include "protocols/run/take_over.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class End : public RunFixture {
 protected:
  End() {
    frame.noise_N = 1e-4;
    feed();
    parts().drive.set_prepared(true);
    clock.run_for(io, 1s);
  }
  RunResult end(std::optional<InterruptRequest> stop) { return run(finish.end(std::move(stop))); }
  RunResult end_by(Interrupt kind) { return end(InterruptRequest(kind, "test")); }
  Task<std::optional<InterruptRequest>> finally_steps() {
    ++finallies;
    if (during_finally) during_finally();
    if (finally_hangs) co_await clock.wait_until(MonoTime::max());
    co_return finally_stop;
  }

  int finallies = 0;
  bool finally_hangs = false;
  std::function<void()> during_finally;
  std::optional<InterruptRequest> finally_stop;
  Losses losses{parts()};
  TakeOver take_over{parts()};
  Finish finish{parts(), losses, take_over, [this] { return finally_steps(); }};
};

TEST_F(End, OfAllStepsIsASuccess) {
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(result.exit_status, ExitStatus::success);
  EXPECT_EQ(result.reason, "");
  EXPECT_EQ(finallies, 1);
  EXPECT_EQ(meter.made_safe, 1);
  EXPECT_EQ(frame.commands.front(), "stop");
  EXPECT_TRUE(parts().interrupts.over());
  EXPECT_EQ(parts().progress.state(), RunState::ended);
}

TEST_F(End, ByAnAbortRunsFinally) {
  const RunResult result = end_by(Interrupt::abort);
  EXPECT_EQ(result.exit_status, ExitStatus::abort);
  EXPECT_EQ(result.reason, "test");  // "abort" is already the status
  EXPECT_EQ(finallies, 1);
}

TEST_F(End, WhereSomebodyAskedIsAStopAndNoFailure) {
  const RunResult result = end_by(Interrupt::stop_after);
  EXPECT_EQ(result.exit_status, ExitStatus::stopped);
  EXPECT_EQ(result.reason, "test");
  EXPECT_FALSE(result.code);
  EXPECT_EQ(finallies, 1);
}

TEST_F(End, WhereSomebodyAskedIsAFailureWhenFinallyFails) {
  finally_stop = InterruptRequest(Interrupt::fault, Error(Errc::refused, "no"));
  const RunResult result = end_by(Interrupt::stop_after);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_EQ(result.code, Errc::refused);
  EXPECT_THAT(result.reason, HasSubstr("test; in `finally`: no"));
}

TEST_F(End, ByAFreezeLeavesTheFrameWhereItIs) {
  EXPECT_EQ(end_by(Interrupt::freeze).exit_status, ExitStatus::abort);
  EXPECT_EQ(finallies, 0);
}

TEST_F(End, ByALimitIsAFailure) {
  const RunResult result = end_by(Interrupt::limit);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_EQ(result.code, Errc::limit_tripped);
  EXPECT_EQ(finallies, 1);
}

TEST_F(End, WithoutStandstillMovesNothing) {
  frame.stop_says = fail(Errc::no_reply, "silent");
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(finallies, 0);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_EQ(result.code, Errc::not_standing);
  EXPECT_THAT(result.reason, HasSubstr("`finally` did not run: standstill not confirmed"));
}

TEST_F(End, WithHandsOffMovesNothingAndSaysSo) {
  parts().drive.keep_hands_off("the drive lies");
  const RunResult result = end(parts().interrupts.take());
  EXPECT_EQ(finallies, 0);
  EXPECT_THAT(result.reason, HasSubstr("`finally` did not run: nothing is moved any more until a "
                                       "person has looked at the rig"));
  EXPECT_THAT(result.reason, Not(HasSubstr("the drive lies; the drive lies"))) << "told once";
}

// A motion that was refused for this reason has already said why.
TEST_F(End, OfAMotionThatWasRefusedTellsHandsOffOnce) {
  parts().drive.keep_hands_off("the drive lies");
  const RunResult result = end(request_for(parts().drive.may_move().error()));
  EXPECT_THAT(result.reason, StartsWith("fault: the drive lies: nothing is moved any more; "
                                        "`finally` did not run"));
}

TEST_F(End, InFinallyWithHandsOffIsToldOnce) {
  during_finally = [this] {
    parts().drive.keep_hands_off("the drive lies");
    finally_stop = InterruptRequest(Interrupt::fault, *parts().drive.hands_off());
  };
  EXPECT_THAT(end(std::nullopt).reason,
              StartsWith("in `finally`: the drive lies; nothing is moved any more until a person "
                         "has looked at the rig"));
}

// The same letters do not count.
TEST_F(End, TellsHandsOffWhateverElseThePersonWrote) {
  parts().drive.keep_hands_off("lies");
  EXPECT_THAT(end(InterruptRequest(Interrupt::abort, "lies")).reason,
              StartsWith("lies; lies; `finally` did not run"));
}

TEST_F(End, TellsThatTheFrameMayMoveWhateverElseThePersonWrote) {
  frame.stop_says = fail(Errc::no_reply, "silent");
  const std::string typed = "why does it say standstill not confirmed: use the E-stop";
  EXPECT_THAT(end(InterruptRequest(Interrupt::freeze, typed)).reason,
              StartsWith("freeze: " + typed + "; standstill not confirmed: use the E-stop"));
}

TEST_F(End, ByAStopThatWasNotConfirmedSaysSoOnce) {
  frame.stop_says = fail(Errc::not_standing, "frame: standstill not confirmed: use the E-stop");
  parts().drive.set_prepared(false);
  const RunResult result = end(request_for(frame.stop_says.error()));
  EXPECT_EQ(result.reason, "fault: frame: standstill not confirmed: use the E-stop");
  EXPECT_EQ(result.code, Errc::not_standing);
}

TEST_F(End, OfAFrameFaultKeepsHandsOff) {
  end(InterruptRequest(Interrupt::fault, Error(Errc::frame_fault, "emergency stop")));
  EXPECT_TRUE(parts().drive.hands_off());
  EXPECT_EQ(finallies, 0);
}

TEST_F(End, BeforeAnythingWasAskedOfTheFrameRunsNoFinally) {
  parts().drive.set_prepared(false);
  EXPECT_EQ(end_by(Interrupt::fault).exit_status, ExitStatus::fail);
  EXPECT_EQ(finallies, 0);
}

TEST_F(End, OfAFrameThatIsGoneSaysThatFinallyDidNotRun) {
  frame.reconnect_says = fail(Errc::disconnected, "no port");
  losses.lose_frame(Error(Errc::disconnected, "gone"));
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_THAT(result.reason, HasSubstr("gone; `finally` did not run: the frame is not there"));
  EXPECT_EQ(finallies, 0);
}

TEST_F(End, WaitsForALostFrameSoThatFinallyCanUnload) {
  losses.lose_frame(Error(Errc::disconnected, "gone"));
  end(std::nullopt);
  EXPECT_FALSE(losses.is_away());
  EXPECT_EQ(finallies, 1);
}

TEST_F(End, OfAFinallyThatNeverEndsStopsTheFrameWhereItIs) {
  finally_hangs = true;
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_THAT(result.reason, HasSubstr("`finally` did not end in 300 s"));
  EXPECT_EQ(frame.commands.back(), "stop");
}

TEST_F(End, OfAFinallyThatFailedSaysWhy) {
  finally_stop = InterruptRequest(Interrupt::limit, "too far");
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_THAT(result.reason, HasSubstr("in `finally`: too far"));
}

TEST_F(End, WithASpecimenThatIsStillLoadedSaysSo) {
  frame.force_N = 0.5;
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(result.exit_status, ExitStatus::fail);
  EXPECT_THAT(result.reason, HasSubstr("the specimen is still loaded with about 0.500 N"));
  EXPECT_EQ(events_of("loaded"), 1);
}

// The filter of the cell still shows a force that is gone.
TEST_F(End, WaitsUntilTheCellShowsThatTheSpecimenIsUnloaded) {
  frame.abilities().reaction = 300ms;
  frame.force_at = [this, away = clock.now()](double) {
    return 0.9 * std::exp(-to_seconds(clock.now() - away) / 0.3);
  };
  const RunResult result = end(std::nullopt);
  EXPECT_EQ(result.exit_status, ExitStatus::success) << result.reason;
}

// A force below zero is a pull, or a zero that was taken under load. Nobody can tell which.
TEST_F(End, WithAForceBelowItsLimitMovesNothingAndBlamesNobody) {
  frame.force_N = -1.2;
  parts().watch.add(frame.sample());
  const RunResult result = end_by(Interrupt::limit);
  EXPECT_EQ(finallies, 0);
  EXPECT_THAT(result.reason, HasSubstr("the load cell shows -1.200 N: the specimen pulls at the "
                                       "probe, or the zero of the cell has moved"));
  EXPECT_THAT(result.reason, HasSubstr("about 1.200 N less than unloaded"));
}

TEST_F(End, OfAFrameOfSomebodyElseCommandsNothing) {
  setup().commands = false;
  EXPECT_EQ(end_by(Interrupt::abort).exit_status, ExitStatus::abort);
  EXPECT_TRUE(frame.commands.empty());
}

}  // namespace
}  // namespace lcrig
