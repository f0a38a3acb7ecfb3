// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "protocols/run/questions.hpp"

namespace lcrig {
namespace {

Question question_of(AnswerType type) {
  Question q;
  q.step_id = "gauge";
  q.text = "Thickness?";
  q.type = type;
  q.unit = type == AnswerType::number ? "um" : "";
  return q;
}

TEST(AnswerEvent, OfANumberHasTheUnitOfTheQuestion) {
  const GivenAnswer given{120.5, AnswerSource::person, "ann"};
  const AnswerEvent e = answer_event(question_of(AnswerType::number), given, 3);
  EXPECT_EQ(e.question, "Thickness?");
  EXPECT_EQ(e.type, "number");
  EXPECT_EQ(e.number, 120.5);
  EXPECT_EQ(e.unit, "um");
  EXPECT_FALSE(e.text);
  EXPECT_EQ(e.source, "person");
  EXPECT_EQ(e.by, "ann");
  EXPECT_EQ(e.repeat, 3);
  EXPECT_FALSE(e.from_run);
}

TEST(AnswerEvent, OfAPureNumberHasAnEmptyUnit) {
  Question q = question_of(AnswerType::number);
  q.unit.clear();
  EXPECT_EQ(answer_event(q, GivenAnswer{2.0, AnswerSource::fallback, ""}, 0).unit, "");
}

TEST(AnswerEvent, OfAChoiceOrALineIsItsText) {
  const GivenAnswer given{std::string("dusty"), AnswerSource::file, ""};
  for (const AnswerType type : {AnswerType::choice, AnswerType::line}) {
    const AnswerEvent e = answer_event(question_of(type), given, 0);
    EXPECT_EQ(e.text, "dusty");
    EXPECT_FALSE(e.number);
    EXPECT_FALSE(e.unit);
    EXPECT_EQ(e.source, "file");
  }
}

TEST(AnswerEvent, OfAConfirmationHasNeitherNumberNorText) {
  const GivenAnswer given{true, AnswerSource::person, "ann"};
  const AnswerEvent e = answer_event(question_of(AnswerType::confirmation), given, 0);
  EXPECT_EQ(e.type, "confirmation");
  EXPECT_FALSE(e.number);
  EXPECT_FALSE(e.text);
}

TEST(AnswerEvent, NamesNobodyWhereNobodyAnswered) {
  for (const AnswerSource source : {AnswerSource::fallback, AnswerSource::made_up}) {
    const GivenAnswer given{true, source, ""};
    const AnswerEvent e = answer_event(question_of(AnswerType::confirmation), given, 0);
    EXPECT_FALSE(e.by);
    EXPECT_EQ(e.source, to_string(source));
  }
}

}  // namespace
}  // namespace lcrig
