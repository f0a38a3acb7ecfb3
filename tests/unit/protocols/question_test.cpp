// SPDX-License-Identifier: Apache-2.0
// Which answers a question accepts, and what it says about the others.
#include "protocols/question.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lcrig {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Question thickness() {
  Question q;
  q.step_id = "thickness";
  q.text = "Thickness by gauge";
  q.type = AnswerType::number;
  q.min = 20;
  q.max = 400;
  q.unit = "um";
  return q;
}

Question surface() {
  Question q;
  q.step_id = "surface";
  q.text = "The surface";
  q.type = AnswerType::choice;
  q.choices = {"clean", "dusty", "10 %"};
  return q;
}

Question of_type(AnswerType type) {
  Question q;
  q.step_id = "q";
  q.text = "?";
  q.type = type;
  return q;
}

AnswerValue read(const Question& q, const AnswerValue& given) {
  auto value = read_answer(q, given);
  EXPECT_TRUE(value) << value.error().what;
  return value.value_or(AnswerValue(std::string("refused")));
}

std::string refusal(const Question& q, const AnswerValue& given) {
  const auto value = read_answer(q, given);
  EXPECT_FALSE(value) << answer_words(*value, q.unit);
  return value ? "" : value.error().what;
}

TEST(Question, TakesANumberAsItIsAndAsItWasTyped) {
  EXPECT_EQ(read(thickness(), 125.5), AnswerValue(125.5));
  EXPECT_EQ(read(thickness(), std::string("125.5")), AnswerValue(125.5));
  EXPECT_EQ(read(thickness(), std::string(" 20 \n")), AnswerValue(20.0));
  EXPECT_EQ(read(thickness(), 400.0), AnswerValue(400.0));
}

TEST(Question, SaysOfAWrongNumberWhatItIsAndWhatIsExpected) {
  EXPECT_EQ(refusal(thickness(), std::string("401")),
            "step thickness: \"401\" is out of range, expected a number from 20 to 400 um");
  EXPECT_THAT(refusal(thickness(), 19.999), HasSubstr("is out of range"));
  EXPECT_THAT(refusal(thickness(), std::string("12,5")), HasSubstr("with a point: 12.5"));
  for (const char* none : {"", "thick", "125 um", "1e", "0x10", "nan", "inf", "--5"}) {
    EXPECT_THAT(refusal(thickness(), std::string(none)),
                AllOf(HasSubstr("is no number"), HasSubstr("from 20 to 400 um")))
        << none;
  }
  EXPECT_THAT(refusal(thickness(), true), HasSubstr("\"true\" is no number"));
}

TEST(Question, TakesAChoiceByItsWholeName) {
  EXPECT_EQ(read(surface(), std::string(" dusty")), AnswerValue(std::string("dusty")));
  EXPECT_EQ(read(surface(), std::string("10 %")), AnswerValue(std::string("10 %")));
  EXPECT_THAT(refusal(surface(), std::string("dutsy")),
              HasSubstr("is no choice, did you mean `dusty`? expected one of: clean, dusty, 10 %"));
  EXPECT_THAT(refusal(surface(), std::string("1")), HasSubstr("is no choice"));
  EXPECT_THAT(refusal(surface(), 1.0), HasSubstr("is no text"));
}

TEST(Question, IsConfirmedByYesAndByNothingElse) {
  const Question q = of_type(AnswerType::confirmation);
  for (const char* yes : {"", "yes", "y", " ok\n", "true"}) {
    EXPECT_EQ(read(q, std::string(yes)), AnswerValue(true)) << yes;
  }
  EXPECT_EQ(read(q, true), AnswerValue(true));
  EXPECT_THAT(refusal(q, false), HasSubstr("lcrig abort ends the run"));
  EXPECT_THAT(refusal(q, std::string("no")), HasSubstr("does not confirm"));
  EXPECT_THAT(refusal(q, 1.0), HasSubstr("does not confirm"));
}

TEST(Question, TakesALineOfText) {
  const Question q = of_type(AnswerType::line);
  EXPECT_EQ(read(q, std::string("ein Kratzer, 2 µm\n")),
            AnswerValue(std::string("ein Kratzer, 2 µm")));
  EXPECT_THAT(refusal(q, std::string(" \t")), HasSubstr("is empty"));
  EXPECT_THAT(refusal(q, std::string("two\nlines")), HasSubstr("has several lines"));
  EXPECT_THAT(refusal(q, std::string(5000, 'x')), HasSubstr("bytes"));
  EXPECT_THAT(refusal(q, std::string("\xff")), HasSubstr("step q"));
  EXPECT_THAT(refusal(q, std::string("a\0b", 3)), HasSubstr("step q"));
  EXPECT_THAT(refusal(q, 3.0), HasSubstr("is no text"));
}

TEST(Question, SaysWhatItAsks) {
  EXPECT_EQ(prompt_words(thickness()), "Thickness by gauge (a number from 20 to 400 um)");
  EXPECT_EQ(prompt_words(surface()), "The surface (one of: clean, dusty, 10 %)");
  Question clean = of_type(AnswerType::confirmation);
  clean.text = "Clean the probe.";
  EXPECT_EQ(prompt_words(clean), "Clean the probe.");
}

}  // namespace
}  // namespace lcrig
