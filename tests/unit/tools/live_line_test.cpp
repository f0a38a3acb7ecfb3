// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/live_line.hpp"
#include "base/clock.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>

namespace lcrig::cli {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

class FixedClock final : public Clock {
 public:
  MonoTime now() const override { return at; }
  std::int64_t unix_ns() const override { return 0; }
  MonoTime at{};

 private:
  Task<bool> wait(MonoTime, Wakeup*) override { co_return false; }
};

RunStatus cycle() {
  RunStatus s;
  s.run = 1;
  s.state = RunState::running;
  s.step_id = "load";
  s.repeat = 3;
  s.repeats = 5;
  s.capacitance_F = 1.84249e-11;
  s.force_N = 0.5321;
  s.elapsed_s = 50;
  s.planned_s = 200;
  s.left_s = 150;
  s.travel_m = 3.01104e-3;
  return s;
}

TEST(LiveLine, ShowsEverythingAtEightyColumns) {
  const auto line = format_live_line(cycle(), 80);
  EXPECT_THAT(line, HasSubstr("load  3/5  C 18.4249 pF  F 0.532 N  x 3.011 mm  ["));
  EXPECT_THAT(line, EndsWith("]  25%  left 2:30"));
  EXPECT_LE(line.size(), 79U);
}

TEST(LiveLine, ATimeThatDoesNotCountDownIsMarked) {
  RunStatus s = cycle();
  s.overdue = true;
  EXPECT_THAT(format_live_line(s, 80), EndsWith("left >2:30"));
  EXPECT_THAT(format_plain_line(s), EndsWith("left >2:30"));
  s.left_s = 0;  // in the last step
  EXPECT_THAT(format_live_line(s, 80), EndsWith("overdue"));
}

TEST(LiveLine, KeepsStepAndCapacitanceAtFortyColumns) {
  const auto line = format_live_line(cycle(), 40);
  EXPECT_LE(line.size(), 39U);
  EXPECT_THAT(line, AllOf(HasSubstr("load"), HasSubstr("C 18.4249 pF"), HasSubstr("F 0.532 N"),
                          Not(HasSubstr("["))));
}

TEST(LiveLine, TheBarDoesNotGrowWithoutEnd) {
  const auto line = format_live_line(cycle(), 200);
  EXPECT_LT(line.size(), 122U);
  EXPECT_EQ(std::count(line.begin(), line.end(), '#'), 9);  // a quarter of 38
}

TEST(LiveLine, NeverWrapsAndNeverCarriesControlCharacters) {
  auto s = cycle();
  s.step_id = "x\x1b[31m\xc2\xb5\n" + std::string(300, 'y');
  for (int width = 0; width <= 250; ++width) {
    const auto line = format_live_line(s, width);
    EXPECT_LT(static_cast<int>(line.size()), std::max(width, 2));
    EXPECT_TRUE(std::all_of(line.begin(), line.end(), [](char c) { return c >= 32 && c < 127; }));
  }
}

TEST(LiveLine, HasForcePressureAndTravelAtEightyColumns) {
  auto s = cycle();
  s.pressure_Pa = 42350;
  const auto line = format_live_line(s, 80);
  EXPECT_THAT(line, HasSubstr("F 0.532 N  P 42.35 kPa  x 3.011 mm  25%  left 2:30"));
  EXPECT_LE(line.size(), 79U);
}

TEST(LiveLine, LeavesOutWhatIsNotKnown) {
  RunStatus s;
  EXPECT_EQ(format_live_line(s, 80), "preparing");
  s.state = RunState::paused;
  s.step_id = "hold";
  EXPECT_EQ(format_live_line(s, 80), "PAUSED at hold");
}

TEST(LiveLine, ShowsAFrameThatMayMoveWhateverTheRunDoes) {
  RunStatus s;
  s.step_id = "load";
  s.state = RunState::stopping;
  EXPECT_EQ(format_live_line(s, 80), "stopping at load");
  for (const RunState state : {RunState::stopping, RunState::finishing}) {
    s.state = state;
    s.standstill = Standstill::not_confirmed;
    EXPECT_EQ(format_live_line(s, 80), "STANDSTILL NOT CONFIRMED: use the E-stop; load");
    s.standstill = Standstill::unknown;
    EXPECT_EQ(format_live_line(s, 80), "STANDSTILL UNKNOWN: frame away; load");
  }
}

TEST(LiveLine, NamesNoStepThatThereIsNot) {
  RunStatus s;
  s.state = RunState::waiting_for_operator;
  EXPECT_EQ(format_live_line(s, 80), "WAITING");
  s.state = RunState::finishing;
  EXPECT_EQ(format_live_line(s, 80), "finishing");
}

// The run was aborted before it reached that end.
TEST(LiveLine, StopsAfterNothingOnceItFinishes) {
  RunStatus s;
  s.state = RunState::running;
  s.step_id = "load";
  s.stops_after = "step";
  EXPECT_EQ(format_live_line(s, 80), "load, stops after this step");
  s.state = RunState::finishing;
  s.step_id = "clear";
  EXPECT_EQ(format_live_line(s, 80), "finishing: clear");
}

TEST(LiveLine, LongerThanPlannedIsFull) {
  auto s = cycle();
  s.elapsed_s = 900;
  s.left_s = 0;
  EXPECT_THAT(format_live_line(s, 80), AllOf(HasSubstr("100%"), EndsWith("left 0:00")));
}

TEST(LiveLine, TimesAreReadable) {
  EXPECT_EQ(format_time(0), "0:00");
  EXPECT_EQ(format_time(185.4), "3:05");
  EXPECT_EQ(format_time(3727), "1:02:07");
  EXPECT_EQ(format_time(-3), "0:00");
}

class Shown : public ::testing::Test {
 protected:
  std::ostringstream out, err;
  Console console{out, err};
  FixedClock clock;
};

TEST_F(Shown, OffTheTerminalALineASecondOrAStepWithoutEscapeCodes) {
  LiveLine line(console, clock);
  auto s = cycle();
  for (int i = 0; i < 100; ++i) {  // 2.5 s of 25 ms
    line.show(s);
    clock.at += std::chrono::milliseconds(25);
  }
  s.step_id = "unload";
  line.show(s);
  line.finish();
  const auto text = err.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);  // at 0, 1 and 2 s, and the step
  EXPECT_THAT(text, AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\r")), HasSubstr("unload")));
  EXPECT_EQ(out.str(), "");
}

TEST_F(Shown, OnATerminalOneLineIsRewritten) {
  console.err_tty = true;
  console.width = [] { return 60; };
  LiveLine line(console, clock);
  auto s = cycle();
  for (int i = 0; i < 100; ++i) {
    s.step_id = "step" + std::to_string(i);
    line.show(s);
    clock.at += std::chrono::milliseconds(10);
  }
  const auto text = err.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 0);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\r'), 20);  // one in 50 ms
}

TEST_F(Shown, AnEventTakesOneLineOfTheTerminal) {
  console.err_tty = true;
  console.width = [] { return 40; };
  LiveLine line(console, clock);
  line.say_one_line(std::string(200, 'w'));
  EXPECT_EQ(err.str(), std::string(36, 'w') + "...\n");
  err.str("");
  console.err_tty = false;
  line.say_one_line(std::string(200, 'w'));
  EXPECT_EQ(err.str(), std::string(200, 'w') + "\n");
}

TEST_F(Shown, APromptIsSaidOnceWithHowToConfirm) {
  LiveLine line(console, clock);
  auto s = cycle();
  s.state = RunState::waiting_for_operator;
  s.prompt = "place 50 g on the rod";
  line.show(s);
  line.show(s);
  const auto text = err.str();
  EXPECT_THAT(text, HasSubstr("place 50 g on the rod  (type: lcrig confirm when done)"));
  EXPECT_EQ(text.find("place 50 g"), text.rfind("place 50 g"));
}

TEST_F(Shown, AQuestionIsSaidWithHowToAnswer) {
  LiveLine line(console, clock);
  auto s = cycle();
  s.state = RunState::waiting_for_operator;
  s.prompt = "Thickness (a number from 20 to 400 um)";
  s.question.emplace().question.type = AnswerType::number;
  line.show(s);
  EXPECT_THAT(err.str(), HasSubstr("(a number from 20 to 400 um)  (type: lcrig answer VALUE)"));
}

TEST(LiveLine, NothingIsLessThanZeroByLessThanItShows) {
  RunStatus s = cycle();
  s.force_N = -0.0004;
  s.travel_m = -4e-7;
  s.pressure_Pa = -1;
  EXPECT_THAT(format_live_line(s, 200),
              AllOf(HasSubstr("F 0.000 N"), HasSubstr("x 0.000 mm"), HasSubstr("P 0.00 kPa")));
  EXPECT_EQ(format_fixed(-0.0006, 3), "-0.001");
  EXPECT_EQ(format_fixed(-10, 0), "-10");
}

}  // namespace
}  // namespace lcrig::cli
