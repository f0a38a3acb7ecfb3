// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "base/decimal.hpp"
#include "daemon/control/messages.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

TEST(ControlMessages, EveryStructSurvivesTheWire) {
  DaemonStatus s;
  s.version = "1.2";
  s.database = "/x.db";
  s.instruments.resize(1);
  s.instruments[0].which = Instrument::frame;
  s.instruments[0].condition = InstrumentCondition::absent;
  s.instruments[0].learned_by = LearnedBy::run;
  s.instruments[0].run = 3;
  s.instruments[0].since_s = 28;
  s.run.emplace();
  s.run->run = 4;
  s.run->state = RunState::waiting_for_operator;
  s.run->prompt = "place 50 g";
  s.run->travel_m = -1.25e-4;
  OpenQuestion& open = s.run->question.emplace();
  open.number = 3;
  open.question.step_id = "surface";
  open.question.text = "The surface";
  open.question.type = AnswerType::choice;
  open.question.choices = {"clean", "dusty"};
  open.question.fallback = std::string("clean");
  open.question.on_timeout = OnTimeout::use_default;
  s.run->question_left_s = 12.5;
  s.run->stops_after = "level";
  s.correcting = true;
  s.last_run.emplace();
  s.last_run->exit_status = ExitStatus::fail;
  s.last_run->code = Errc::no_reply;
  s.last_run->simulated = true;
  s.queue.emplace();
  s.queue->cause = HoldCause::too_many_failures;
  s.queue->gate = QueueGate::time;
  const auto back = parse_daemon_status(json::parse(to_json(s).dump()));
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(to_json(*back), to_json(s));
  EXPECT_EQ(back->run->travel_m, -1.25e-4);
  EXPECT_EQ(back->run->force_N, std::nullopt);
  EXPECT_TRUE(back->correcting);
  EXPECT_EQ(back->instruments[0].which, Instrument::frame);
  EXPECT_EQ(back->queue->cause, HoldCause::too_many_failures);
  EXPECT_EQ(back->queue->gate, QueueGate::time);
}

// An older daemon sent states as sentences, and did not say how they are known.
TEST(ControlMessages, OfAnOlderDaemonWhatIsThereIsRead) {
  const auto old = parse_daemon_status(json::parse(R"({"version":"0.9","database":"/x.db",
      "instruments":[{"name":"lcr","port":"serial:1:2","state":"ready","identity":"GW","age_s":3},
                     {"name":"frame","port":"tcp:h:1","state":"not asked since its port came"}],
      "run":null,"last_run":null})"));
  ASSERT_TRUE(old) << old.error().what;
  ASSERT_EQ(old->instruments.size(), 2U);
  EXPECT_EQ(old->instruments[0].condition, InstrumentCondition::ready);
  EXPECT_EQ(old->instruments[0].learned_by, LearnedBy::nothing);
  EXPECT_EQ(old->instruments[0].age_s, 3);
  EXPECT_EQ(old->instruments[1].condition, InstrumentCondition::unasked);
  EXPECT_EQ(old->instruments[1].why, "not asked since its port came");
}

TEST(ControlMessages, OfANewerDaemonUnknownWordsOfTheQueueAreNone) {
  const auto queue = parse_queue_status(
      json::parse(R"({"cause":"moon","gate":"tide","prompt":"wait for the tide","why":"full"})"));
  ASSERT_TRUE(queue) << queue.error().what;
  EXPECT_EQ(queue->cause, std::nullopt);
  EXPECT_EQ(queue->gate, std::nullopt);
  EXPECT_EQ(queue->prompt, "wait for the tide");
}

TEST(ControlMessages, AnAnswerHasAValueAndMayNameItsQuestion) {
  for (const char* good :
       {R"({"value":125.5})", R"({"value":"dusty","question":3})", R"({"value":true})"}) {
    const auto request = parse_answer_request(json::parse(good));
    ASSERT_TRUE(request) << request.error().what;
    EXPECT_EQ(to_json(*request), json::parse(good));
  }
  for (const auto& [wrong, why] : std::vector<std::pair<const char*, const char*>>{
           {R"({})", "/params/value: is missing"},
           {R"({"value":null})", "/params/value: is missing"},
           {R"({"value":[1]})", "/params/value: expected a text, a number or true"},
           {R"({"value":1,"question":"3"})", "/params/question: expected a whole number"},
           {R"({"value":1,"step":"a"})", "/params/step: unknown member"}}) {
    const auto request = parse_answer_request(json::parse(wrong));
    ASSERT_FALSE(request) << wrong;
    EXPECT_THAT(request.error().what, HasSubstr(why));
  }
  EXPECT_FALSE(parse_answer_request(json{{"value", std::string(5000, 'x')}}));
}

TEST(ControlMessages, AWrongTypeInAnAnswerIsGarbledAndNamed) {
  const auto back = parse_run_status(json::parse(R"({"run":1,"state":"flying"})"));
  ASSERT_FALSE(back);
  EXPECT_THAT(back.error().what, HasSubstr("/state"));
  EXPECT_FALSE(parse_run_status(json::parse(R"({"run":"1","state":"running"})")));
  EXPECT_FALSE(parse_run_outcome(json::parse(R"([])")));
}

TEST(ControlMessages, ShiftingTheDecimalPointKeepsTheDigits) {
  EXPECT_EQ(json(shift_decimal(1.84249e-11, 12)).dump(), "18.4249");
  EXPECT_EQ(json(shift_decimal(3.6457e-12, 12)).dump(), "3.6457");
  EXPECT_EQ(shift_decimal(0, 12), 0);
  EXPECT_EQ(shift_decimal(-2.5e-3, 3), -2.5);
}

}  // namespace
}  // namespace lcrig
