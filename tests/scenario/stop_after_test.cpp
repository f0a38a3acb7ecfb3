// SPDX-License-Identifier: Apache-2.0
// Stops and pauses that wait for the end of what is in progress, on the daemon in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "analysis/analysis.hpp"
#include "storage/chain.hpp"
#include "tests/support/daemon_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using testing::AllOf;
using testing::HasSubstr;

// Three passes over two levels, a safe point at the end of each pass, a minute of rest at the end.
constexpr const char* kLevels = R"({ "format": "load-protocol/1", "name": "levels",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-10, 10], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" },
              "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "pass", "do": "repeat", "count": 3, "steps": [
      { "id": "levels", "do": "sweep", "name": "f_N", "values": [0.2, 0.4], "steps": [
        { "id": "load", "do": "ramp", "to": { "force_N": "$f_N" }, "force_rate_N_s": 0.1, "timeout_s": 60 },
        { "id": "settle", "do": "hold", "hold": "force", "force_N": "$f_N", "for_s": 2 },
        { "id": "level", "do": "measure", "count": 10, "within_s": 4 } ] },
      { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.5 }, "speed_mm_s": 0.5, "timeout_s": 60 },
      { "id": "rest", "do": "hold", "hold": "travel", "for_s": 5, "safe_point": true } ] },
    { "id": "after", "do": "record", "for_s": 60 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -1 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

class Stopping : public support::DaemonWorld {
 protected:
  void begin(PlainClient& client, const std::string& protocol = kLevels) {
    ASSERT_TRUE(answer(client, "watch").contains("result"));
    ASSERT_TRUE(answer(client, "run.start", start_request(protocol)).contains("result"));
  }
  // Waits until this step begins for the n-th time.
  void wait_for_step(PlainClient& client, const std::string& step, int times = 1) {
    wait_for(client, [&](const json& m) {
      return m.value("method", "") == "event" && m["params"]["kind"] == "step_begin" &&
             m["params"]["step"] == step && --times == 0;
    });
  }
  void wait_for_state(PlainClient& client, const std::string& state) {
    wait_for(client, [&](const json& m) {
      return m.value("method", "") == "status" && m["params"]["state"] == state;
    });
  }
  json stop_after(PlainClient& client, const std::string& place) {
    return answer(client, "run.stop", {{"after", place}});
  }
  static std::string note(const json& message) {
    EXPECT_EQ(message.value("/result/state"_json_pointer, ""), "later") << message;
    return message.value("/result/note"_json_pointer, "");
  }
  std::string refusal(const json& message) {
    EXPECT_TRUE(message.contains("error")) << message;
    return message.value("/error/message"_json_pointer, "");
  }
  // The steps that were begun, in order.
  std::string steps() const {
    auto db = open_read_only(dir.file("d.db")).value();
    auto s = db.prepare("SELECT group_concat(step_id, ' ') FROM event WHERE kind = 'step_begin'")
                 .value();
    return s.step().value() ? std::string(s.text(0)) : "";
  }
};

struct PlaceCase {
  const char *place, *in_step;
  const char* steps;
};

class AfterEachPlace : public Stopping, public testing::WithParamInterface<PlaceCase> {};

TEST_P(AfterEachPlace, WhatIsUnderWayIsFinishedThenTheSpecimenIsUnloaded) {
  const auto& [place, in_step, expected] = GetParam();
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, in_step);
  EXPECT_THAT(note(stop_after(client, place)), HasSubstr("it stops at the end of the"));
  const json ended = wait_for_end(client);
  EXPECT_EQ(ended["exit_status"], "stopped") << ended;
  EXPECT_TRUE(ended["code"].is_null());
  EXPECT_THAT(ended["reason"].get<std::string>(), AllOf(HasSubstr("after the"), HasSubstr("by ")));
  EXPECT_EQ(steps(), expected);
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'step_end' AND detail <> 'done'"), 0);
  EXPECT_EQ(count("SELECT count(*) FROM v_run WHERE exit_status = 'stopped'"), 1);
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'loaded'"), 0);
  EXPECT_TRUE(verify_chain(open_read_only(dir.file("d.db")).value(), 1).value().intact);
}

INSTANTIATE_TEST_SUITE_P(
    Places, AfterEachPlace,
    testing::Values(
        PlaceCase{"step", "load", "contact load clear"},
        PlaceCase{"level", "load", "contact load settle level clear"},
        PlaceCase{"level", "level", "contact load settle level clear"},
        PlaceCase{"level", "unload", "contact load settle level load settle level unload clear"},
        PlaceCase{"cycle", "load", "contact load settle level load settle level unload rest clear"},
        PlaceCase{"repeat", "unload",
                  "contact load settle level load settle level unload rest clear"},
        PlaceCase{"cycle", "contact", "contact clear"},
        PlaceCase{"safe_point", "contact",
                  "contact load settle level load settle level unload rest clear"}),
    [](const auto& c) { return std::string(c.param.place) + "_in_" + c.param.in_step; });

TEST_F(Stopping, OfTwoRequestsTheNearerOneCountsAndEachIsTold) {
  PlainClient one(socket_path()), other(socket_path());
  begin(one);
  wait_for_step(one, "load");
  EXPECT_THAT(note(stop_after(one, "cycle")), HasSubstr("the end of the cycle (step rest)"));
  EXPECT_THAT(note(stop_after(other, "level")),
              AllOf(HasSubstr("the end of the level (step level)"),
                    HasSubstr("nearer than the end of the cycle (step rest)")));
  EXPECT_THAT(note(stop_after(one, "repeat")),
              AllOf(HasSubstr("already"), HasSubstr("the end of the level (step level)")));
  EXPECT_EQ(wait_for_end(one)["exit_status"], "stopped");
  EXPECT_EQ(steps(), "contact load settle level clear");
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'stop_after'"), 2)
      << "one that changes nothing is no event";
  EXPECT_EQ(requests().size(), 4U) << "but it was asked";
}

TEST_F(Stopping, APauseComesAtItsPlaceAndBeforeTheStopBehindIt) {
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, "load");
  EXPECT_THAT(note(answer(client, "run.pause", {{"at", "level"}})),
              HasSubstr("it pauses at the end of the level (step level)"));
  EXPECT_THAT(note(stop_after(client, "cycle")), HasSubstr("(step rest)"));
  wait_for_state(client, "paused");
  pass(client, 60s);
  EXPECT_EQ(steps(), "contact load settle level load");
  EXPECT_EQ(count("SELECT count(*) FROM frame_sample WHERE flags & 1 <> 0 AND received_mono_ns > "
                  "(SELECT at_mono_ns FROM event WHERE kind = 'pause') + 200000000"),
            0)
      << "it moves in the pause";
  EXPECT_TRUE(answer(client, "run.resume").contains("result"));
  EXPECT_EQ(wait_for_end(client)["exit_status"], "stopped");
  EXPECT_EQ(steps(), "contact load settle level load settle level unload rest clear");
}

TEST_F(Stopping, WhileItIsPausedTheRequestIsTakenAndActsAfterwards) {
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, "load");
  EXPECT_TRUE(answer(client, "run.pause").contains("result"));
  wait_for_state(client, "paused");
  EXPECT_THAT(note(stop_after(client, "level")), HasSubstr("goes on with `lcrig resume`"));
  const json status = answer(client, "status")["result"]["run"];
  EXPECT_EQ(status["state"], "paused");
  EXPECT_EQ(status["stops_after"], "level");
  EXPECT_TRUE(status["pauses_at"].is_null());
  EXPECT_TRUE(answer(client, "run.resume").contains("result"));
  EXPECT_EQ(wait_for_end(client)["exit_status"], "stopped");
  EXPECT_EQ(steps(), "contact load settle level clear");
}

TEST_F(Stopping, WhileItWaitsForAPersonTheRequestIsTakenAndActsAfterwards) {
  std::string protocol = kLevels;
  protocol.replace(protocol.find(R"({ "id": "contact")"), 0,
                   R"({ "id": "clean", "do": "ask", "text": "Clean?", "answer": "confirmation",
                        "timeout_s": 600 }, )");
  PlainClient client(socket_path());
  begin(client, protocol);
  wait_for_state(client, "waiting_for_operator");
  EXPECT_THAT(note(stop_after(client, "step")), HasSubstr("waits for a person first"));
  pass(client, 10s);
  EXPECT_TRUE(answer(client, "run.answer", {{"value", true}}).contains("result"));
  EXPECT_EQ(wait_for_end(client)["exit_status"], "stopped");
  EXPECT_EQ(steps(), "clean clear");
}

TEST_F(Stopping, InFinallyAndAfterAStopTheRunIsSaidToEndAlready) {
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, "load");
  EXPECT_THAT(note(stop_after(client, "step")), HasSubstr("(step load)"));
  wait_for_step(client, "clear");
  const json late = stop_after(client, "step");
  EXPECT_EQ(late.value("/result/state"_json_pointer, ""), "finally") << late;
  EXPECT_EQ(answer(client, "run.pause", {{"at", "level"}}).value("/result/state"_json_pointer, ""),
            "finally");
  EXPECT_EQ(wait_for_end(client)["exit_status"], "stopped");
  EXPECT_EQ(steps(), "contact load clear");
}

TEST_F(Stopping, WithoutARunOrAPlaceItIsRefused) {
  PlainClient client(socket_path());
  EXPECT_THAT(refusal(stop_after(client, "level")), HasSubstr("no run is going on"));
  EXPECT_THAT(refusal(stop_after(client, "levels")),
              HasSubstr("\"levels\", expected one of step, level, cycle, repeat, safe_point"));
  EXPECT_THAT(refusal(answer(client, "run.stop")), HasSubstr("/params/after: is missing"));
  EXPECT_THAT(refusal(answer(client, "run.pause", {{"at", 3}})),
              HasSubstr("/params/at: expected a string"));
  begin(client);
  wait_for_step(client, "after");
  EXPECT_THAT(refusal(stop_after(client, "safe_point")),
              HasSubstr("no step behind step after is marked as a safe point"));
}

// Nothing is left out, so this does not count as a stop.
TEST_F(Stopping, BehindTheLastStepTheRunIsASuccess) {
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, "after");
  note(stop_after(client, "step"));
  EXPECT_EQ(wait_for_end(client)["exit_status"], "success");
}

TEST_F(Stopping, AnAbortMeanwhileActsAtOnce) {
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, "load");
  note(stop_after(client, "repeat"));
  EXPECT_TRUE(answer(client, "run.abort").contains("result"));
  EXPECT_EQ(wait_for_end(client)["exit_status"], "abort");
  EXPECT_EQ(steps(), "contact load clear");
}

TEST_F(Stopping, WhatWasRecordedIsAnalysedAndCannotBeResumed) {
  PlainClient client(socket_path());
  begin(client);
  wait_for_step(client, "load");
  note(stop_after(client, "cycle"));
  wait_for_end(client);
  EXPECT_THAT(refusal(answer(client, "run.resume", {{"run", 1}, {"confirm_specimen", true}})),
              AllOf(HasSubstr("ended with `stopped`"), HasSubstr("needs a new run")));
  const auto db = open_read_only(dir.file("d.db")).value();
  const auto data = load_run_data(db, 1);
  ASSERT_TRUE(data) << data.error().what;
  EXPECT_EQ(data->listing.exit_status, ExitStatus::stopped);
  EXPECT_EQ(data->levels.size(), 2U);
  const auto analysis = analyse(*data, AnalysisOptions());
  ASSERT_TRUE(analysis) << analysis.error().what;
  EXPECT_EQ(analysis->curve.size(), 2U);
}

}  // namespace
}  // namespace lcrig
