// SPDX-License-Identifier: Apache-2.0
// How much of its duration or time-out a step has left after an interruption.
#include <gmock/gmock.h>

#include "base/either.hpp"
#include "protocols/steps/ask.hpp"
#include "protocols/steps/find_contact.hpp"
#include "protocols/steps/hold.hpp"
#include "protocols/steps/measure.hpp"
#include "protocols/steps/move_until.hpp"
#include "protocols/steps/ramp.hpp"
#include "protocols/steps/record.hpp"
#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class NobodyConfirms final : public Operator {
 public:
  explicit NobodyConfirms(Clock& clock) : clock_(clock) {}
  Task<Result<>> confirm(std::string) override {
    co_await clock_.wait_until(MonoTime::max());
    co_return Result<>();
  }
  const std::string& prompt() const override { return prompt_; }

 private:
  Clock& clock_;
  std::string prompt_;
};

template <class Step>
Task<std::optional<Result<>>> execute_for(const Step& step, typename Step::Progress& progress,
                                          RunParts& run, Duration patience) {
  auto task = step.execute(run, progress);
  auto r = co_await either(std::move(task), run.setup.clock.wait_for(patience));
  std::optional<Result<>> out;
  if (r.index() == 0) out = std::move(std::get<0>(r));
  co_return out;
}

// Each step has ten seconds, is interrupted after four, and goes on a hundred seconds later.
class StepTimes : public RunFixture {
 protected:
  StepTimes() {
    setup().person = &nobody_;
    frame.noise_N = 1e-4;
    frame.travel_m = 5e-3;
    frame.set_listener(&view_);
    asio::co_spawn(io, frame.send_samples(), asio::detached);
    parts().log.begin_step(step(0));
    parts().watch.learn_zero(run(parts().meter.measure_alive()).value());
    frame.force_N = 0.5;
    frame.never_ends = true;
    clock.run_for(io, 1s);
  }

  template <class Step>
  void interrupt(const Step& step, typename Step::Progress& progress) {
    EXPECT_FALSE(run(execute_for(step, progress, parts(), 4s))) << "it ended too early";
    progress.interrupt(clock.now());
    clock.run_for(io, 100s);
  }
  // How long it takes until the step ends.
  template <class Step>
  Duration lasts(const Step& step, typename Step::Progress& progress) {
    const MonoTime begin = clock.now();
    const auto ended = run(execute_for(step, progress, parts(), 600s));
    EXPECT_TRUE(ended) << "it never ended";
    if (ended && !*ended) why = ended->error().what;
    return clock.now() - begin;
  }
  template <class Step>
  Duration goes_on(const Step& step) {
    typename Step::Progress progress;
    interrupt(step, progress);
    return lasts(step, progress);
  }
  template <class Step>
  Duration begins_again(const Step& step) {
    typename Step::Progress progress;
    interrupt(step, progress);
    progress.begin_again(parts());
    return lasts(step, progress);
  }
  // In a run that continues one that was cut off in this step.
  template <class Step>
  Duration is_continued(const Step& step) {
    typename Step::Progress progress;
    progress.go_on_from(LeftOff());
    return lasts(step, progress);
  }
  template <class Step>
  void expect_rest_or_all(const Step& step) {
    EXPECT_EQ(goes_on(step), 6s);
    EXPECT_EQ(begins_again(step), 10s);
    EXPECT_EQ(is_continued(step), 10s);
  }
  static Target at(TargetKind kind, double value) {
    Target out;
    out.kind = kind;
    out.value = Number(value);
    return out;
  }

  std::string why;  // the last step failed

 private:
  struct View final : LoadFrame::Listener {
    explicit View(StepTimes& t) : test(t) {}
    void on_samples(std::span<const FrameSample> s) override {
      test.parts().meter.add(s);
      for (const FrameSample& sample : s) test.parts().watch.add(sample);
    }
    void on_frame_event(EventName, std::string) override {}
    void on_frame_lost(Error) override {}
    StepTimes& test;
  };
  View view_{*this};
  NobodyConfirms nobody_{clock};
};

TEST_F(StepTimes, ARecordingForATime) {
  RecordStep step;
  step.duration = Number(10);
  expect_rest_or_all(step);
}

TEST_F(StepTimes, ARecordingThatNobodyConfirms) {
  RecordStep step;
  step.until_confirmed = true;
  step.timeout = Number(10);
  expect_rest_or_all(step);
  EXPECT_EQ(events_of("late"), 3);
}

TEST_F(StepTimes, AHold) {
  HoldStep step;
  step.duration = Number(10);
  expect_rest_or_all(step);
}

TEST_F(StepTimes, AQuestionThatNobodyAnswers) {
  AskStep step;
  step.type = AnswerType::line;
  step.default_text = "nothing";
  step.on_timeout = OnTimeout::use_default;
  step.timeout = Number(10);
  expect_rest_or_all(step);
}

// Nobody is asked while something may move, and a run that nobody watches ends all the same.
TEST_F(StepTimes, AQuestionThatNobodyIsAskedBecauseTheFrameDoesNotStand) {
  frame.stop_says = fail(Errc::not_standing, "STOP twice -> standstill not confirmed");
  AskStep step;
  step.type = AnswerType::line;
  step.default_text = "nothing";
  step.timeout = Number(10);
  for (const OnTimeout then : {OnTimeout::use_default, OnTimeout::abort}) {
    step.on_timeout = then;
    parts().drive.note_order(1e-3);
    expect_rest_or_all(step);
    EXPECT_THAT(why, HasSubstr("nobody was asked, because standstill of the frame was not"));
  }
  RecordStep record;
  record.until_confirmed = true;
  record.timeout = Number(10);
  expect_rest_or_all(record);
  EXPECT_THAT(why, HasSubstr("nobody was asked"));
  EXPECT_FALSE(parts().questions.open());
}

TEST_F(StepTimes, ARampToATravel) {
  RampStep step;
  step.to = at(TargetKind::travel, 1e-3);
  step.speed = Number(1e-3);
  step.timeout = Number(10);
  expect_rest_or_all(step);
  EXPECT_THAT(why, HasSubstr("the motion did not end within 10 s"));
}

TEST_F(StepTimes, ARampToAForce) {
  RampStep step;
  step.to = at(TargetKind::force, 0.2);
  step.speed = Number(1e-4);
  step.timeout = Number(10);
  expect_rest_or_all(step);
}

TEST_F(StepTimes, ARampOfTheForceLoop) {
  RampStep step;
  step.to = at(TargetKind::force, 0.2);
  step.force_rate = Number(0.01);
  step.timeout = Number(10);
  expect_rest_or_all(step);
}

TEST_F(StepTimes, AMotionUntilATravel) {
  MoveUntilStep step;
  step.until = at(TargetKind::travel, 1e-3);
  step.speed = Number(1e-3);
  step.timeout = Number(10);
  expect_rest_or_all(step);
}

TEST_F(StepTimes, AMotionUntilAForce) {
  MoveUntilStep step;
  step.until = at(TargetKind::force, 0.2);
  step.speed = Number(1e-4);
  step.timeout = Number(10);
  expect_rest_or_all(step);
}

// The plan compares the sum of both with the time-out.
TEST_F(StepTimes, AMotionAtTwoSpeedsHasOneTimeOut) {
  MoveUntilStep step;
  step.until = at(TargetKind::force, 0.2);
  step.speed = Number(1e-4);
  step.final_speed = Number(1e-5);
  step.final_from = Number(0.5);
  step.timeout = Number(10);
  parts().watch.invalidate_force();  // this frame does not move, and its ends are not compared
  frame.never_ends = false;
  frame.motion_lasts = 6s;
  EXPECT_EQ(is_continued(step), 10s);
  EXPECT_THAT(why, HasSubstr("the motion did not end within 10 s"));
}

TEST_F(StepTimes, AMotionWhoseTimeIsUsedUpDoesNotBegin) {
  RampStep step;
  step.to = at(TargetKind::travel, 1e-3);
  step.speed = Number(1e-3);
  step.timeout = Number(10);
  RampStep::Progress progress;
  progress.time.begin(clock.now() - 10s, 10s);
  progress.interrupt(clock.now());
  EXPECT_EQ(lasts(step, progress), 0s);
  EXPECT_THAT(why, HasSubstr("did not end within 10 s"));
  EXPECT_THAT(frame.commands, Not(Contains("move_to")));
}

// The search goes back to its start, so its time begins there, too.
TEST_F(StepTimes, ASearchForContactBeginsAgain) {
  frame.force_N = 0;
  FindContactStep step;
  step.speed = Number(1e-5);
  step.force = Number(0.02);
  step.back_off = Number(1e-3);
  step.timeout = Number(10);
  const Duration whole = is_continued(step);
  EXPECT_GE(whole, 10s);
  EXPECT_EQ(goes_on(step), whole);
  EXPECT_EQ(begins_again(step), whole);
}

// The planned instants of a level's readings stay as far apart as they were.
TEST_F(StepTimes, ALevelTakesTheRestOfItsReadings) {
  MeasureStep step;
  step.count = Number(5);
  step.within = Number(10);
  const Duration whole = is_continued(step);
  EXPECT_GT(whole, 8s);
  EXPECT_EQ(goes_on(step), whole - 4s);
  EXPECT_EQ(begins_again(step), whole);
}

}  // namespace
}  // namespace lcrig
