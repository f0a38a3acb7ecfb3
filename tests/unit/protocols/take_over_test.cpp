// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/take_over.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;

class Person final : public Operator {
 public:
  explicit Person(Clock& clock) : clock_(clock) {}
  Result<> says;
  bool is_away = false;
  std::string asked;
  Task<Result<>> confirm(std::string prompt) override {
    asked = std::move(prompt);
    if (is_away) co_await clock_.wait_until(MonoTime::max());
    co_return says;
  }
  const std::string& prompt() const override { return asked; }

 private:
  Clock& clock_;
};

class GoOn : public RunFixture {
 protected:
  explicit GoOn(const std::string& first_step = "") {
    if (!first_step.empty()) protocol = parse_protocol(beginning_with(first_step), "t").value();
    Continuation from;
    from.run = 7;
    from.step_id = "s";
    from.point.steps_done = 1;
    from.point.levels = 4;
    from.point.travel_m = 1e-3;
    from.frame.force_N = 0;
    from.frame.travel_m = frame.travel_m = 1e-3;
    setup().continues = from;
    setup().person = &person;
    frame.noise_N = 1e-4;
    feed();
  }
  static std::string beginning_with(const std::string& step) {
    std::string text(kProtocol);
    const auto begin = text.find("{ \"id\": \"r\""), end = text.find("{ \"id\": \"s\"");
    return text.replace(begin, end - begin, step + ", ");
  }
  Result<> pass() {
    StepCursor cursor(protocol.steps, values);
    return run(take_over.pass_done_steps(cursor));
  }

  Person person{clock};
  TakeOver take_over{parts()};
};

TEST_F(GoOn, APersonLooksAtTheSpecimenFirst) {
  EXPECT_FALSE(run(take_over.confirm_specimen()));
  EXPECT_THAT(person.asked, HasSubstr("Run 7 stopped in step s."));
  EXPECT_FALSE(take_over.unconfirmed());
}

TEST_F(GoOn, WithoutThatPersonItIsStoppedAndStaysUnconfirmed) {
  person.is_away = true;
  parts().interrupts.ask(InterruptRequest(Interrupt::abort, "test"));
  EXPECT_EQ(run(take_over.confirm_specimen())->kind, Interrupt::abort);
  EXPECT_TRUE(take_over.unconfirmed());
}

TEST_F(GoOn, APauseMeanwhileStopsIt) {
  person.is_away = true;
  parts().interrupts.ask(InterruptRequest(Interrupt::pause, "test"));
  EXPECT_EQ(run(take_over.confirm_specimen())->kind, Interrupt::fault);
}

TEST_F(GoOn, StepsThatWereDoneArePassedOver) {
  const auto passed = pass();
  ASSERT_TRUE(passed) << passed.error().what;
  EXPECT_EQ(parts().progress.steps_done(), 1);
  EXPECT_EQ(parts().labels.next("s", 5, clock.now()).level, 5);
  EXPECT_DOUBLE_EQ(*take_over.take_left_off().start_travel_m, 1e-3);
  EXPECT_FALSE(take_over.take_left_off().start_travel_m) << "of the first step only";
}

struct GoOnAfterAHold : GoOn {
  GoOnAfterAHold()
      : GoOn(R"({ "id": "h", "do": "hold", "hold": "force", "force_N": 0.3, "for_s": 5 })") {}
};

TEST_F(GoOnAfterAHold, TheForceIsHeldAgain) {
  ASSERT_TRUE(pass());
  EXPECT_EQ(parts().drive.held_force_N(), 0.3);
  EXPECT_THAT(frame.commands, Contains("hold_force"));
  EXPECT_EQ(parts().labels.next("s", 5, clock.now()).target_force_N, 0.3);
}

struct GoOnAfterSetLcr : GoOn {
  GoOnAfterSetLcr()
      : GoOn(R"({ "id": "m", "do": "set_lcr", "average": 4, "frequency_Hz": 2000 })") {}
};

TEST_F(GoOnAfterSetLcr, TheMeterIsSetAsItWas) {
  ASSERT_TRUE(pass());
  EXPECT_EQ(parts().sampler.settings().average, 4);
  EXPECT_EQ(parts().sampler.settings().frequency.si(), 2000);
}

TEST_F(GoOn, AFrameThatWasMovedMeanwhileIsNotMovedAgain) {
  frame.travel_m = 5e-3;
  const auto passed = pass();
  ASSERT_FALSE(passed);
  EXPECT_TRUE(passed.error().hands_off) << "the reason of the run tells it once";
  EXPECT_FALSE(parts().drive.may_move());
}

}  // namespace
}  // namespace lcrig
