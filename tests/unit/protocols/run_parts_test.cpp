// SPDX-License-Identifier: Apache-2.0
// What several kinds of steps do with the parts of a run.
#include "protocols/run/run_parts.hpp"

#include <gmock/gmock.h>

#include "base/either.hpp"
#include "protocols/steps/progress.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

class Parts : public RunFixture {
 protected:
  Parts() {
    frame.noise_N = 1e-4;
    frame.travel_m = 5e-3;
    feed();
    parts().log.begin_step(step(0));
    parts().watch.learn_zero(run(parts().meter.measure_alive()).value());
    frame.commands.clear();
  }
  Result<> move_to(TargetKind kind, double value) {
    Target to;
    to.kind = kind;
    to.value = Number(value);
    const Number speed(1e-3);
    return run(move_to_place(to, speed, 60, parts()));
  }
  // True if the wait ended by itself within `patience`.
  bool waits_out(double duration_s, TimeSpent& time, Duration patience) {
    return run(wait_beside(duration_s, time, patience)) == 0;
  }

 private:
  Task<std::size_t> wait_beside(double duration_s, TimeSpent& time, Duration patience) {
    auto r = co_await either(wait_out(duration_s, parts(), time), clock.wait_for(patience));
    co_return r.index();
  }
};

TEST_F(Parts, MoveToATravelOfTheMachine) {
  const auto moved = move_to(TargetKind::travel, 2e-3);
  ASSERT_TRUE(moved) << moved.error().what;
  EXPECT_DOUBLE_EQ(frame.travel_m, 2e-3);
}

TEST_F(Parts, MoveToAGapAboveContact) {
  parts().watch.place_contact(6e-3, 0);
  const auto moved = move_to(TargetKind::gap, 2e-3);
  ASSERT_TRUE(moved) << moved.error().what;
  EXPECT_DOUBLE_EQ(frame.travel_m, 4e-3);
}

TEST_F(Parts, DoNotMoveToAGapOfAnUnknownContact) {
  const auto moved = move_to(TargetKind::gap, 2e-3);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, Errc::invalid_request);
  EXPECT_THAT(moved.error().what, HasSubstr("step r"));
  EXPECT_THAT(frame.commands, IsEmpty());
}

TEST_F(Parts, WaitForTheWholeTime) {
  TimeSpent time;
  const MonoTime begun = clock.now();
  EXPECT_TRUE(waits_out(10, time, 60s));
  EXPECT_EQ(clock.now() - begun, 10s);
}

TEST_F(Parts, WaitForTheRestAfterAnInterruption) {
  TimeSpent time;
  EXPECT_FALSE(waits_out(10, time, 4s));
  time.end(clock.now());
  clock.run_for(io, 100s);  // the pause does not count
  const MonoTime again = clock.now();
  EXPECT_TRUE(waits_out(10, time, 60s));
  EXPECT_EQ(clock.now() - again, 6s);
}

TEST_F(Parts, WaitNoLongerWhenTheTimeIsOver) {
  TimeSpent time;
  time.begin(clock.now() - 11s, 10s);
  time.end(clock.now());
  const MonoTime begun = clock.now();
  EXPECT_TRUE(waits_out(10, time, 60s));
  EXPECT_EQ(clock.now(), begun);
}

TEST_F(Parts, WaitForTheWholeTimeWhenTheStepBeginsAgain) {
  TimeSpent time;
  EXPECT_FALSE(waits_out(10, time, 4s));
  time.end(clock.now());
  time.forget();
  const MonoTime again = clock.now();
  EXPECT_TRUE(waits_out(10, time, 60s));
  EXPECT_EQ(clock.now() - again, 10s);
}

TEST_F(Parts, PointSaysWhereARunWouldGoOn) {
  frame.zero_of = "3";
  parts().progress.count_step();
  parts().progress.count_step();
  parts().labels.enter_repeat(4);
  parts().watch.place_contact(6e-3, 0.02);
  parts().watch.take_over_zeros(true, 0.5);
  const RunPoint point = parts().point();
  EXPECT_EQ(point.steps_done, 2);
  EXPECT_EQ(point.contact_travel_m, 6e-3);
  EXPECT_EQ(point.travel_m, 5e-3);
  EXPECT_TRUE(point.zeroed);
  EXPECT_EQ(point.zeros_N, 0.5);
  EXPECT_EQ(point.origin, "3");
}

TEST_F(Parts, PointLetsLevelsCountOn) {
  parts().labels.next("s", 5, clock.now());
  const LoadLevel second = parts().labels.next("s", 5, clock.now());
  LevelLabels later(values, PressureArea(), 9.81);
  later.take_from(parts().point());
  EXPECT_EQ(later.next("s", 5, clock.now()).level, second.level + 1);
}

// Only the cursors of the run write the values; the setup keeps the parameters.
static_assert(std::is_same_v<decltype(RunParts::values), const Environment&>);
static_assert(std::is_same_v<decltype(RunParts::setup), const RunSetup&>);

TEST_F(Parts, SeeTheVariableOfASweepInEachPass) {
  Target force;
  force.kind = TargetKind::force;
  force.value.name = "f_N";
  Target gap = force;
  gap.kind = TargetKind::gap;
  parts().watch.place_contact(6e-3, 0);
  for (const double value : {1e-3, 2e-3}) {
    values.set("f_N", value);
    EXPECT_EQ(parts().get(force.value), value);
    EXPECT_EQ(parts().labels.force_of(force), value);
    EXPECT_DOUBLE_EQ(travel_of(gap, parts()).value(), 6e-3 - value);
  }
  EXPECT_TRUE(setup().environment.values().empty());
}

TEST_F(Parts, NeedForceUntilTheRunEnds) {
  EXPECT_TRUE(parts().needs_force());
  parts().interrupts.begin_finish(std::nullopt);
  EXPECT_FALSE(parts().needs_force()) << "the way back needs the travel only";
}

TEST_F(Parts, NeedNoForceOfAFrameThatTheyDoNotMove) {
  setup().commands = false;
  EXPECT_FALSE(parts().needs_force());
}

}  // namespace
}  // namespace lcrig
