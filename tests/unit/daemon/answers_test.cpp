// SPDX-License-Identifier: Apache-2.0
// The answers given to a rehearsal are checked like those of people, before anything runs.
#include "daemon/rig/answers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocols/file/parse.hpp"

namespace lcrig {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class AnswersFile : public testing::Test {
 protected:
  Result<Answers> parse(const std::string& answers) const {
    const std::string text = R"({ "format": "answers/1", "answers": )" + answers + " }";
    return parse_answers(text, "answers.json", protocol, environment);
  }
  Protocol protocol = load_protocol("protocols/library/inspection.json").value();
  Environment environment = bind_parameters(protocol, {}).value();
};

TEST_F(AnswersFile, HasOneValueForEachStep) {
  const auto answers = parse(R"({ "thickness": 125.5, "temperature": "21", "surface": "dusty",
                                  "placed": true })");
  ASSERT_TRUE(answers) << answers.error().what;
  EXPECT_EQ(answers->size(), 4U);
  EXPECT_EQ(answers->at("thickness"), AnswerValue(125.5));
  EXPECT_TRUE(parse("{}"));
}

TEST_F(AnswersFile, SaysAllThatIsWrongWithPlaceAndReason) {
  const auto answers = parse(
      R"({ "thickness_": 100, "rest": 1, "temperature": 400, "surface": "clena", "placed": false,
           "humidity": [50] })");
  ASSERT_FALSE(answers);
  const std::string all = answers.error().what + "\n" + answers.error().detail;
  EXPECT_THAT(all, AllOf(HasSubstr("answers.json:1:"),
                         HasSubstr("no step `thickness_` that asks, did you mean `thickness`?"),
                         HasSubstr("no step `rest` that asks"),
                         HasSubstr("\"400\" is out of range, expected a number from 10 to 40 degC"),
                         HasSubstr("did you mean `clean`"), HasSubstr("does not confirm"),
                         HasSubstr("expected a text, a number or true")));
}

TEST_F(AnswersFile, OfAnotherFormatIsRefused) {
  EXPECT_FALSE(parse_answers(R"({ "answers": {} })", "a.json", protocol, environment));
  EXPECT_FALSE(parse_answers("nonsense", "a.json", protocol, environment));
  EXPECT_FALSE(parse_answers(R"({ "format": "answers/1", "answers": {}, "more": 1 })", "a.json",
                             protocol, environment));
}

}  // namespace
}  // namespace lcrig
