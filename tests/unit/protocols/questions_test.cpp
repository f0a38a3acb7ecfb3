// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/questions.hpp"

#include <gmock/gmock.h>

#include "tests/support/run_fixture.hpp"

namespace lcrig {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class QuestionsTest : public RunFixture {
 protected:
  Questions& questions() { return parts().questions; }
  void ask(const std::string& step) {
    Question q;
    q.step_id = step;
    q.text = "Thickness by gauge";
    q.type = AnswerType::number;
    q.min = 20;
    q.max = 400;
    q.unit = "um";
    wait_.reset();
    wait_.emplace(questions(), q, 0, clock.now());
  }
  void stop_waiting() { wait_.reset(); }
  Result<Answered> answer(double value, std::optional<std::int64_t> number = std::nullopt) {
    return questions().answer(value, "ann", number);
  }

 private:
  std::optional<Questions::Wait> wait_;
};

TEST_F(QuestionsTest, TakeTheFirstAnswerThatFits) {
  bool answered = false;
  ask("gauge");
  start(questions().answered(), answered);
  EXPECT_FALSE(answer(10));
  io.poll();
  EXPECT_FALSE(answered);
  EXPECT_TRUE(questions().open());
  EXPECT_THAT(sink.kinds(), IsEmpty());

  const auto taken = answer(120);
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->question.step_id, "gauge");
  EXPECT_FALSE(questions().open());
  EXPECT_THAT(sink.kinds(), ElementsAre("answer"));
  io.restart();
  io.poll();
  EXPECT_TRUE(answered);
  EXPECT_TRUE(questions().take());
  EXPECT_FALSE(questions().take());
}

TEST_F(QuestionsTest, WhoComesLaterIsToldWhoAnswered) {
  EXPECT_EQ(answer(120).error().what, "no question waits for an answer");
  ask("gauge");
  ASSERT_TRUE(answer(120));
  const auto late = answer(130);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Errc::invalid_request);
  EXPECT_THAT(late.error().what, HasSubstr("step gauge was answered by ann: 120 um"));
}

TEST_F(QuestionsTest, AnAnswerToAnEarlierOneIsNotTakenForTheOpenOne) {
  ask("gauge");
  const auto first = questions().open()->number;
  ASSERT_TRUE(answer(120, first));
  ask("again");
  const auto late = answer(130, first);
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().what, HasSubstr("step again asks now"));
  EXPECT_TRUE(answer(130, questions().open()->number));
}

TEST_F(QuestionsTest, AreNotOpenAfterTheStepOrWhenWithdrawn) {
  ask("gauge");
  stop_waiting();
  EXPECT_FALSE(questions().open());
  ask("gauge");
  questions().withdraw("its time is over");
  EXPECT_THAT(answer(120).error().what, HasSubstr("its time is over"));
}

TEST_F(QuestionsTest, AnAnswerThatNobodyHeardDoesNotAnswerTheNext) {
  bool answered = false;
  ask("gauge");
  ASSERT_TRUE(answer(120));
  ask("again");
  start(questions().answered(), answered);
  io.poll();
  EXPECT_FALSE(answered);
}

}  // namespace
}  // namespace lcrig
