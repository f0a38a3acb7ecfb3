// SPDX-License-Identifier: Apache-2.0
// A protocol that asks people, on the whole daemon in virtual time: what clients may answer, when,
// and what the frame does meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/strict_json.hpp"
#include "daemon/rehearse.hpp"
#include "tests/support/daemon_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using testing::AllOf;
using testing::HasSubstr;

std::string protocol(const std::string& steps) {
  return R"({ "format": "load-protocol/1", "name": "asks",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [)" +
         steps + R"(],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";
}

constexpr const char* kThickness =
    R"({ "id": "thickness", "do": "ask", "text": "Thickness by gauge", "answer": "number",
         "range_um": [20, 400], "timeout_s": 120 })";

std::string thickness(const std::string& more) {
  return R"({ "id": "thickness", "do": "ask", "text": "Thickness by gauge", "answer": "number",
         "range_um": [20, 400], "timeout_s": 120, )" +
         more + "}";
}

// A step that takes a minute, after a question.
const std::string kThen = R"(, { "id": "then", "do": "record", "for_s": 60 })";

class Asking : public support::DaemonWorld {
 protected:
  void begin(PlainClient& client, const std::string& steps) {
    ASSERT_TRUE(answer(client, "watch").contains("result"));
    const json started = answer(client, "run.start", start_request(protocol(steps)));
    ASSERT_TRUE(started.contains("result")) << started;
  }
  // The question of this step, as watchers receive it.
  json question(PlainClient& client, const std::string& step) {
    const json status = wait_for(client, [&](const json& m) {
      return m.value("method", "") == "status" && m["params"]["question"].is_object() &&
             m["params"]["question"]["step"] == step;
    });
    return status.is_null() ? json() : status["params"];
  }
  json wait_for_step(PlainClient& client, const std::string& step) {
    return wait_for(client, [&](const json& m) {
      return m.value("method", "") == "status" && m["params"]["step"] == step;
    });
  }
  json say(PlainClient& client, const json& value) {
    return answer(client, "run.answer", {{"value", value}});
  }
  std::string refusal(const json& message) {
    EXPECT_TRUE(message.contains("error")) << message;
    return message.value("/error/message"_json_pointer, "");
  }
  std::string text(const std::string& sql) const {
    auto db = open_read_only(dir.file("d.db")).value();
    auto s = db.prepare(sql).value();
    return s.step().value() ? std::string(s.text(0)) : "";
  }
};

TEST_F(Asking, EveryKindOfAnswerIsStoredWithItsType) {
  PlainClient client(socket_path());
  begin(
      client,
      R"({ "id": "clean", "do": "ask", "text": "Clean the probe.", "answer": "confirmation", "timeout_s": 60 },
           { "id": "rep", "do": "repeat", "count": 2, "steps": [
             { "id": "surface", "do": "ask", "text": "The surface", "answer": "choice", "choices": ["clean", "dusty"], "timeout_s": 60 } ] },
           { "id": "seen", "do": "ask", "text": "What is seen", "answer": "line", "timeout_s": 60 },)" +
          std::string(kThickness) + kThen);
  const json first = question(client, "clean");
  EXPECT_EQ(first["state"], "waiting_for_operator");
  EXPECT_EQ(first["prompt"], "Clean the probe.");
  EXPECT_TRUE(say(client, true).contains("result"));
  question(client, "surface");
  EXPECT_TRUE(say(client, "dusty").contains("result"));
  wait_for(client, [](const json& m) {
    return m.value("method", "") == "status" && m["params"]["question"].is_object() &&
           m["params"]["question"]["number"] == 3;
  });
  EXPECT_TRUE(say(client, "clean").contains("result"));
  question(client, "seen");
  EXPECT_TRUE(say(client, "a scratch").contains("result"));
  const json number = question(client, "thickness")["question"];
  EXPECT_EQ(number["unit"], "um");
  EXPECT_EQ(number["min"], 20);
  EXPECT_EQ(number["max"], 400);
  EXPECT_NEAR(number["left_s"].get<double>(), 120, 1);
  const json taken = say(client, "125.5")["result"];
  EXPECT_EQ(taken, json::parse(R"({"run":1,"step":"thickness","value":125.5,"unit":"um"})"));
  // An acknowledged answer is stored.
  EXPECT_EQ(text("SELECT step || ' ' || type || ' ' || number || ' ' || unit || ' ' || source FROM "
                 "v_answer WHERE step = 'thickness'"),
            "thickness number 125.5 um person");
  wait_for_step(client, "then");
  ASSERT_TRUE(answer(client, "run.abort").contains("result"));
  wait_for_end(client);
  EXPECT_EQ(text("SELECT group_concat(step || ' ' || repeat || ' ' || type || ' ' || "
                 "coalesce(text, '-'), '; ') FROM v_answer WHERE type <> 'number'"),
            "clean 0 confirmation -; surface 1 choice dusty; surface 2 choice clean; seen 0 line a "
            "scratch");
  EXPECT_EQ(count("SELECT count(*) FROM v_answer WHERE answered_by <> ''"), 5);
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'request' AND detail LIKE "
                  "'%run.answer%'"),
            5);
}

TEST_F(Asking, AWrongAnswerIsRefusedAndTheQuestionStaysOpen) {
  PlainClient client(socket_path());
  begin(client, kThickness + kThen);
  question(client, "thickness");
  EXPECT_THAT(refusal(say(client, "thick")), HasSubstr("is no number"));
  EXPECT_THAT(refusal(say(client, 500)), HasSubstr("out of range, expected a number from 20 to"));
  EXPECT_THAT(refusal(say(client, true)), HasSubstr("is no number"));
  EXPECT_THAT(refusal(say(client, json::array())), HasSubstr("/params/value: expected a text"));
  EXPECT_THAT(refusal(answer(client, "run.answer")), HasSubstr("/params/value: is missing"));
  EXPECT_THAT(refusal(answer(client, "run.answer", {{"value", 125}, {"question", 7}})),
              AllOf(HasSubstr("question 7 waits no more"), HasSubstr("step thickness asks now")));
  EXPECT_THAT(refusal(answer(client, "run.confirm")),
              AllOf(HasSubstr("step thickness asks for a number"), HasSubstr("lcrig answer")));
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'answer'"), 0);
  EXPECT_TRUE(answer(client, "run.answer", {{"value", 125}, {"question", 1}}).contains("result"));
  wait_for_step(client, "then");
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'answer'"), 1);
}

TEST_F(Asking, OfTwoClientsAtOnceOneIsTakenAndTheOtherIsTold) {
  PlainClient one(socket_path()), other(socket_path());
  begin(one, kThickness + kThen);
  question(one, "thickness");
  one.call("run.answer", {{"value", 125}, {"question", 1}});
  other.call("run.answer", {{"value", 130}, {"question", 1}});
  const auto is_answer = [](const json& m) { return m.contains("id"); };
  const json first = wait_for(one, is_answer), second = wait_for(other, is_answer);
  EXPECT_NE(first.contains("result"), second.contains("result")) << first << second;
  const bool first_won = first.contains("result");
  EXPECT_THAT(refusal(first_won ? second : first),
              AllOf(HasSubstr("no question waits for an answer: step thickness was answered by"),
                    HasSubstr(first_won ? "125 um" : "130 um")));
  wait_for_step(one, "then");
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'answer'"), 1);
  EXPECT_EQ(count("SELECT number FROM v_answer"), first_won ? 125 : 130);
}

TEST_F(Asking, WithoutAnAnswerTheDefaultIsTakenAndALateAnswerIsTold) {
  PlainClient client(socket_path());
  begin(client, thickness(R"("default_mm": 0.1, "on_timeout": "default")") + kThen);
  question(client, "thickness");
  const MonoTime asked = clock.now();
  wait_for_step(client, "then");
  EXPECT_NEAR(to_seconds(clock.now() - asked), 120, 1);
  EXPECT_THAT(refusal(say(client, 125)),
              HasSubstr("step thickness was answered by its default: 100 um"));
  EXPECT_EQ(text("SELECT number || ' ' || unit || ' ' || source FROM v_answer"),
            "100.0 um default");
}

TEST_F(Asking, WithoutAnAnswerTheRunEndsWhereTheProtocolSaysSo) {
  PlainClient client(socket_path());
  begin(client, kThickness + kThen);
  const json ended = wait_for_end(client);
  EXPECT_EQ(ended["exit_status"], "abort");
  EXPECT_THAT(ended["reason"].get<std::string>(),
              HasSubstr("step thickness: nobody answered within 120 s"));
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE step_id = 'clear' AND kind = 'step_end' AND "
                  "detail = 'done'"),
            1);
  EXPECT_THAT(refusal(say(client, 125)), HasSubstr("no run is going on"));
}

TEST_F(Asking, WhereTheProtocolWaitsAnAnswerIsTakenAfterTheTimeToo) {
  PlainClient client(socket_path());
  begin(client, thickness(R"("on_timeout": "wait")") + kThen);
  question(client, "thickness");
  pass(client, 300s);
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'late'"), 1);
  const json open = question(client, "thickness")["question"];
  EXPECT_TRUE(open["left_s"].is_null());
  EXPECT_EQ(open["number"], 1) << "it is the same question";
  EXPECT_TRUE(say(client, 125).contains("result"));
  wait_for_step(client, "then");
}

TEST_F(Asking, AnAnswerToNothingIsToldWhatWaitsInstead) {
  PlainClient client(socket_path());
  EXPECT_THAT(refusal(say(client, 1)), HasSubstr("no run is going on"));
  begin(client, R"({ "id": "look", "do": "record", "until": "confirmed", "timeout_s": 600 },)" +
                    std::string(kThickness) + kThen);
  wait_for(client, [](const json& m) {
    return m.value("method", "") == "status" && m["params"]["prompt"] != "";
  });
  EXPECT_THAT(refusal(say(client, 1)),
              AllOf(HasSubstr("waits for a confirmation"), HasSubstr("lcrig confirm")));
  EXPECT_TRUE(answer(client, "run.confirm").contains("result"));
  question(client, "thickness");
  EXPECT_TRUE(say(client, 50).contains("result"));
  wait_for_step(client, "then");
  EXPECT_THAT(refusal(say(client, 50)), HasSubstr("was answered by"));
}

TEST_F(Asking, AConfirmationIsConfirmedByEitherWord) {
  PlainClient client(socket_path());
  begin(
      client,
      R"({ "id": "clean", "do": "ask", "text": "Clean the probe.", "answer": "confirmation", "timeout_s": 60, "on_timeout": "wait" })" +
          kThen);
  question(client, "clean");
  EXPECT_THAT(refusal(say(client, "no")), HasSubstr("lcrig abort ends the run"));
  EXPECT_TRUE(answer(client, "run.confirm").contains("result"));
  wait_for_step(client, "then");
  EXPECT_EQ(text("SELECT type || ' ' || source FROM v_answer"), "confirmation person");
}

// The time of a pause does not count against the time for the question.
TEST_F(Asking, APauseWithdrawsTheQuestionAndAsksItAgain) {
  PlainClient client(socket_path());
  begin(client, kThickness + kThen);
  question(client, "thickness");
  pass(client, 20s);
  EXPECT_TRUE(answer(client, "run.pause").contains("result"));
  pass(client, 200s);
  EXPECT_THAT(refusal(say(client, 125)), AllOf(HasSubstr("is paused"), HasSubstr("lcrig resume")));
  EXPECT_TRUE(answer(client, "run.resume").contains("result"));
  const json again = question(client, "thickness")["question"];
  EXPECT_NEAR(again["left_s"].get<double>(), 100, 2);
  EXPECT_EQ(again["number"], 2);
  EXPECT_TRUE(say(client, 125).contains("result"));
  wait_for_step(client, "then");
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'answer'"), 1);
}

// Both lines are in the socket at once. An answer that was accepted must not be asked for again.
TEST_F(Asking, AnAnswerInTheInstantOfAPauseIsKept) {
  PlainClient client(socket_path());
  begin(client, kThickness + kThen);
  question(client, "thickness");
  client.send(request_line(100, "run.answer", {{"value", 125}}) +
              request_line(101, "run.pause", json::object()));
  pass(client, 10s);
  answer(client, "run.resume");
  wait_for_step(client, "then");
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'answer'"), 1);
}

TEST_F(Asking, AStopWhileItWaitsEndsTheRunAtOnce) {
  for (const char* stop : {"run.abort", "run.freeze"}) {
    PlainClient client(socket_path());
    begin(client, kThickness + kThen);
    question(client, "thickness");
    const MonoTime asked = clock.now();
    EXPECT_TRUE(answer(client, stop).contains("result")) << stop;
    EXPECT_LT(clock.now() - asked, 1s) << stop;
    EXPECT_EQ(wait_for_end(client)["exit_status"], "abort") << stop;
  }
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'answer'"), 0);
}

// The force loop of a frame moves it, while a person has the hands at the specimen.
TEST_F(Asking, TheFrameStandsWhileItWaitsAlsoUnderAHeldForce) {
  PlainClient client(socket_path());
  begin(
      client,
      R"({ "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
           { "id": "load", "do": "ramp", "to": { "force_N": 0.4 }, "force_rate_N_s": 0.5, "timeout_s": 60 },
           { "id": "hold", "do": "hold", "hold": "force", "force_N": 0.4, "for_s": 5 },)" +
          std::string(kThickness) +
          R"(, { "id": "level", "do": "measure", "count": 10, "within_s": 4 })");
  question(client, "thickness");
  pass(client, 60s);
  EXPECT_TRUE(say(client, 125).contains("result"));
  EXPECT_EQ(wait_for_end(client)["exit_status"], "success");
  const std::string waits =
      "received_mono_ns BETWEEN (SELECT at_mono_ns FROM event WHERE kind = 'prompt') + 500000000 "
      "AND (SELECT at_mono_ns FROM event WHERE kind = 'answer')";
  EXPECT_GT(count("SELECT count(*) FROM frame_sample WHERE " + waits), 2000);
  EXPECT_EQ(count("SELECT count(*) FROM frame_sample WHERE flags & 3 <> 0 AND " + waits), 0)
      << "1: moving, 2: force control";
  EXPECT_GT(count("SELECT count(*) FROM frame_sample WHERE flags & 2 <> 0 AND received_mono_ns > "
                  "(SELECT at_mono_ns FROM event WHERE kind = 'step_begin' AND step_id = 'level')"),
            100)
      << "the force is held again";
}

// Copies the disk as a crash leaves it, twice: while a question waits, and after it was answered.
class AskingAfterACrash : public Asking {
 protected:
  // `cut`: SQL that removes the rows that are lost in the crash.
  void crash(const std::string& name, const std::string& cut = "") {
    for (const char* suffix : {"", "-wal"}) {
      std::filesystem::copy_file(dir.file(std::string("d.db") + suffix), dir.file(name + suffix));
    }
    if (!cut.empty()) {
      auto db = Database::open(dir.file(name), Database::Mode::read_write_create).value();
      const auto done = db.execute(cut);
      ASSERT_TRUE(done) << done.error().what;
    }
    stop();
    start(name);
  }
  std::string text_of(const std::string& file, const std::string& sql) const {
    auto db = open_read_only(dir.file(file)).value();
    auto s = db.prepare(sql).value();
    return s.step().value() ? std::string(s.text(0)) : "";
  }
};

TEST_F(AskingAfterACrash, WhatWasAnsweredIsKeptAndWhatWaitedIsAskedAgain) {
  {
    PlainClient client(socket_path());
    begin(
        client,
        R"({ "id": "seen", "do": "ask", "text": "What is seen", "answer": "line", "timeout_s": 60 },)" +
            std::string(kThickness) + kThen);
    question(client, "seen");
    EXPECT_TRUE(say(client, "a scratch").contains("result"));
    question(client, "thickness");
    clock.run_for(io, 2s);
  }
  crash("crashed.db");
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "watch").contains("result"));
  ASSERT_TRUE(
      answer(client, "run.resume", {{"run", 1}, {"confirm_specimen", true}}).contains("result"));
  question(client, "thickness");
  EXPECT_TRUE(say(client, 125).contains("result"));
  wait_for_step(client, "then");
  EXPECT_EQ(text_of("crashed.db",
                    "SELECT group_concat(step || ' ' || coalesce(text, number) || ' ' || "
                    "coalesce(from_run, '-'), '; ') FROM v_answer WHERE run = 2"),
            "seen a scratch 1; thickness 125.0 -");
}

// The daemon dies after it told its client that the answer was accepted, and before the next step.
TEST_F(AskingAfterACrash, AnAnswerThatWasAcknowledgedIsNeverAskedForAgain) {
  {
    PlainClient client(socket_path());
    begin(client, kThickness + kThen);
    question(client, "thickness");
    EXPECT_TRUE(say(client, 125).contains("result"));
    wait_for_step(client, "then");
    clock.run_for(io, 2s);
  }
  // The rows of the next step are lost, as in a real crash.
  crash("crashed.db",
        "DROP TRIGGER event_no_delete; DELETE FROM event WHERE seq > (SELECT max(seq) FROM event "
        "WHERE kind = 'answer')");
  PlainClient client(socket_path());
  ASSERT_TRUE(answer(client, "watch").contains("result"));
  const json resumed = answer(client, "run.resume", {{"run", 1}, {"confirm_specimen", true}});
  ASSERT_TRUE(resumed.contains("result")) << resumed;
  wait_for_step(client, "then");
  EXPECT_EQ(text_of("crashed.db",
                    "SELECT step || ' ' || number || ' ' || from_run FROM v_answer "
                    "WHERE run = 2"),
            "thickness 125.0 1");
}

TEST(RehearsedAsking, ItsPersonAnswersAndTheRemarksSayFromWhere) {
  const TempDir dir;
  RehearseRequest request;
  request.protocol_name = "inspection";
  request.protocol_text = read_text_file("protocols/library/inspection.json").value();
  request.specimen_name = "paper-1";
  request.specimen_text = std::string(shipped_specimens().front().text);
  request.db_path = dir.file("r.db");
  request.answers_name = "answers.json";
  request.answers_text =
      R"({ "format": "answers/1", "answers": { "thickness": 125.5, "surface": "dusty" } })";
  const auto result = rehearse(request);
  ASSERT_TRUE(result) << result.error().what;
  EXPECT_EQ(result->exit_status, ExitStatus::success) << result->reason;
  EXPECT_EQ(result->measure_readings, 30);
  EXPECT_THAT(result->remarks,
              testing::ElementsAre(
                  HasSubstr("thickness was answered \"125.5 um\": from the file"),
                  HasSubstr("temperature was answered \"25 degC\": made up"),
                  HasSubstr("humidity was answered \"50 percent\": made up"),
                  HasSubstr("surface was answered \"dusty\": from the file"),
                  HasSubstr("remark was answered \"nothing\": the default of the protocol"),
                  HasSubstr("placed was answered \"confirmed\": made up")));
  request.answers_text = R"({ "format": "answers/1", "answers": { "thickness": 5 } })";
  const auto refused = rehearse(request);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("answers.json:1:"));
}

}  // namespace
}  // namespace lcrig
