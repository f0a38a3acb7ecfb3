// SPDX-License-Identifier: Apache-2.0
// A day of specimens: the queue of a whole daemon in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/queue_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::PlainClient;
using support::QueueWorld;
using testing::HasSubstr;

const json kUnattended{{"unattended", true}};

class QueueOfRuns : public QueueWorld {
 protected:
  void answer_gate(const std::string& kind, const std::string& word) {
    ASSERT_TRUE(until_gate(kind)) << queue();
    ok("queue.answer", {{"text", word}});
  }
};

TEST_F(QueueOfRuns, AnEntryHasTheNameOfItsProtocolAndNotThatOfItsFile) {
  ok("queue.add", entry("paper-1", {{"protocol", "copy of it.json"}}));
  EXPECT_EQ(ok("queue.show", {{"entry", 1}})["protocol"].get<std::string>(), "phased");
}

TEST_F(QueueOfRuns, RunsWhatIsQueuedAndAsksForEverySpecimen) {
  queue_up({"paper-1", "paper-1", "paper-2"}, kUnattended);
  EXPECT_EQ(queue()["going"], false) << "nothing starts by itself";
  clock.run_for(io, 10min);
  EXPECT_EQ(runs(), 0);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("specimen"));
  EXPECT_EQ(runs(), 2) << "the same specimen goes on by itself";
  EXPECT_THAT(queue()["prompt"].get<std::string>(), HasSubstr("take paper-1 off, put paper-2 on"));
  clock.run_for(io, 60min);
  EXPECT_EQ(runs(), 2) << "a gate waits for as long as it takes";
  EXPECT_THAT(refusal("queue.answer", {{"text", "paper-1"}}), HasSubstr("nothing moves"));
  ok("queue.answer", {{"text", "paper-2"}});
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty");
  EXPECT_EQ(queue()["count"], 0);
  EXPECT_EQ(count("SELECT count(*) FROM run_end WHERE exit_status = 'success'"), 3);
  EXPECT_EQ(count("SELECT count(*) FROM queue_entry WHERE state = 'done'"), 3);
}

TEST_F(QueueOfRuns, WithoutConsentNothingMovesWhileNobodyIsThere) {
  queue_up({"paper-1", "paper-1"});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("person"));
  EXPECT_EQ(runs(), 1) << "whoever put the specimen on is there for one run";
  clock.run_for(io, 60min);
  EXPECT_EQ(runs(), 1);
  EXPECT_THAT(refusal("queue.answer", {{"text", "no"}}), HasSubstr("nothing moves"));
  ok("run.confirm");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 2);
}

TEST_F(QueueOfRuns, OfTwoAnswersAtOnceOneCounts) {
  queue_up({"paper-1"}, kUnattended);
  ok("queue.start");
  ASSERT_TRUE(until_gate("specimen"));
  PlainClient other(socket_path());
  client->call("queue.answer", {{"text", "paper-1"}});
  other.call("queue.answer", {{"text", "paper-1"}});
  const json first = wait_for(*client, [](const json& m) { return m.contains("id"); });
  const json second = wait_for(other, [](const json& m) { return m.contains("id"); });
  EXPECT_NE(first.contains("result"), second.contains("result"));
  const json& refused = first.contains("error") ? first : second;
  EXPECT_THAT(refused["error"]["message"].get<std::string>(), HasSubstr("waits for no answer"));
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 1);
}

TEST_F(QueueOfRuns, ARunOfSomebodyElseIsRefusedWhileItGoesUnlessItIsQueuedFirst) {
  queue_up({"paper-1", "paper-1"}, kUnattended);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until([this](const json&) { return runs() == 1; }));
  EXPECT_THAT(refusal("run.start", entry("paper-1")), HasSubstr("lcrig run --next"));
  const json added = ok("queue.add", entry("paper-1", {{"place", "first"}, {"unattended", true}}));
  const json page = ok("queue.list");
  ASSERT_EQ(page["count"], 3);
  EXPECT_EQ(page["entries"][0]["state"], "running");
  EXPECT_EQ(page["entries"][1]["entry"], added["entry"]);
  EXPECT_TRUE(added["plan"]["duration_s"].is_number()) << "planned on the rig as it was seen last";
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 3);
}

TEST_F(QueueOfRuns, AnEntryThatTheRigWouldRefuseIsRefusedWhenItIsAdded) {
  json wrong = entry("paper-1");
  std::string text = support::kPhasedProtocol;
  text.replace(text.find("\"force_N\": 0.5 }"), 16, "\"force_N\": 5.0 }");
  wrong["protocol_text"] = text;
  EXPECT_THAT(refusal("queue.add", wrong), HasSubstr("limit"));
  json unknown = entry("nobody-knows-it");
  unknown.erase("specimen_text");
  EXPECT_THAT(refusal("queue.add", unknown), HasSubstr("no specimen `nobody-knows-it`"));
  json broken = entry("paper-1");
  broken["protocol_text"] = "{";
  EXPECT_THAT(refusal("queue.add", broken), HasSubstr("phased"));
  EXPECT_EQ(queue()["count"], 0);
}

TEST_F(QueueOfRuns, TheTextAtTheTimeOfQueueingCountsAndPlansAddUp) {
  queue_up({"paper-1", "paper-1"}, kUnattended);
  const json entries = ok("queue.list")["entries"];
  const auto begin = entries[1]["planned_begin_unix_ns"].get<std::int64_t>();
  EXPECT_EQ(entries[0]["planned_end_unix_ns"].get<std::int64_t>(), begin);
  EXPECT_GT(begin, entries[0]["planned_begin_unix_ns"].get<std::int64_t>());
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(count("SELECT count(*) FROM run AS r JOIN queue_attempt AS a ON a.run_id = r.id JOIN "
                  "queue_entry AS e ON e.id = a.entry_id WHERE e.protocol_sha256 = "
                  "r.protocol_sha256"),
            2);
}

TEST_F(QueueOfRuns, HoldingFinishesTheRunAndBeginsNothingMore) {
  queue_up({"paper-1", "paper-1"}, kUnattended);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until([this](const json&) { return runs() == 1; }));
  ok("queue.hold", {{"why", "lunch"}});
  EXPECT_THAT(queue()["why"].get<std::string>(), HasSubstr("lunch"));
  clock.run_for(io, 10min);
  EXPECT_EQ(count("SELECT count(*) FROM run_end WHERE exit_status = 'success'"), 1);
  EXPECT_EQ(runs(), 1);
  EXPECT_EQ(queue()["cause"], "person");
  ok("queue.start");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 2);
}

TEST_F(QueueOfRuns, ALockKeepsOthersOutAndNobodyFromHolding) {
  queue_up({"paper-1"});
  ok("queue.lock", {{"why", "mine"}});
  EXPECT_EQ(queue()["locked_by"], ok("queue.history")["acts"][0]["user"]);
  ok("queue.move", {{"entry", 1}, {"place", "last"}});  // the owner of the lock may move it
  ok("queue.hold");
  ok("queue.unlock");
  EXPECT_EQ(queue()["locked_by"], "");
}

TEST_F(QueueOfRuns, AFailedEntryStaysAtTheHeadUntilAPersonDecides) {
  troubles[1].script =
      R"({ "format": "faults/1", "faults": [ { "on": "meter", "in_step": "measure", "after_s": 0.3, "fault": "unplug" } ] })";
  queue_up({"paper-1", "paper-1"}, kUnattended);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "failure");
  EXPECT_EQ(state(1), "failed");
  EXPECT_THAT(refusal("queue.start"), HasSubstr("--repeat"));
  EXPECT_THAT(refusal("queue.start", {{"head", "resume"}}), HasSubstr("--repeat"));
  EXPECT_THAT(refusal("queue.move", {{"entry", 2}, {"place", {{"before", 1}}}}),
              HasSubstr("nothing can stand before it"));
  ok("queue.start", {{"head", "repeat"}});
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty");
  EXPECT_EQ(ok("queue.show", {{"entry", 1}})["attempts"], 2);
  EXPECT_EQ(runs(), 3);
}

TEST_F(QueueOfRuns, SkipsAFailureWhereTheTermsSaySo) {
  troubles[1].script =
      R"({ "format": "faults/1", "faults": [ { "on": "meter", "in_step": "measure", "after_s": 0.3, "fault": "unplug" } ] })";
  queue_up({"paper-1", "paper-1"}, {{"unattended", true}, {"on_failure", "skip"}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty");
  EXPECT_EQ(state(1), "skipped");
  EXPECT_EQ(state(2), "done");
}

TEST_F(QueueOfRuns, WhatDidNotBeginIsRepeatedAtOnceAndNotForEver) {
  for (int i = 1; i <= 2; ++i) troubles[i].refuses = Error(Errc::no_reply, "lcr: no answer");
  queue_up({"paper-1"}, {{"unattended", true}, {"on_failure", "repeat"}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty") << "the third attempt was good";
  for (int i = 4; i < 100; ++i) troubles[i].refuses = Error(Errc::no_reply, "lcr: no answer");
  queue_up({"paper-1"}, {{"unattended", true}, {"on_failure", "repeat"}, {"failures_max", 5}});
  ok("queue.start");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "too_many_failures");
  EXPECT_THAT(queue()["why"].get<std::string>(), HasSubstr("5 failures in a row"));
  EXPECT_EQ(state(2), "failed");
  EXPECT_EQ(runs(), 1);
}

TEST_F(QueueOfRuns, AnAbortedRunHoldsTheQueue) {
  queue_up({"paper-1", "paper-1"}, {{"unattended", true}, {"on_failure", "skip"}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until([this](const json&) { return runs() == 1; }));
  ok("run.abort", {{"why", "smoke"}});
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "aborted");
  EXPECT_THAT(queue()["why"].get<std::string>(), HasSubstr("smoke"));
  EXPECT_EQ(runs(), 1);
}

TEST_F(QueueOfRuns, AfterARestartNothingGoesUntilAPersonSaysSo) {
  queue_up({"paper-1", "paper-1"}, kUnattended);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until([this](const json&) { return runs() == 1; }));
  restart();  // like SIGTERM: the run is aborted, and `finally` runs
  EXPECT_EQ(queue()["going"], false);
  EXPECT_EQ(state(1), "failed");
  clock.run_for(io, 60min);
  EXPECT_EQ(runs(), 1);
  ok("queue.start", {{"head", "skip"}});
  answer_gate("specimen", "paper-1");  // nobody knows what happened in the meantime
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 2);
}

TEST_F(QueueOfRuns, AGateSurvivesARestartAsAHeldQueue) {
  queue_up({"paper-1"}, kUnattended);
  ok("queue.start");
  ASSERT_TRUE(until_gate("specimen"));
  restart();
  EXPECT_EQ(queue()["cause"], "restart");
  EXPECT_EQ(queue()["gate"], "");
  EXPECT_THAT(refusal("queue.answer", {{"text", "paper-1"}}), HasSubstr("waits for no answer"));
  EXPECT_EQ(queue()["count"], 1);
  EXPECT_EQ(runs(), 0);
}

TEST_F(QueueOfRuns, WatchersAreToldWhatItWaitsFor) {
  queue_up({"paper-1"}, kUnattended);
  client->call("watch");
  client->call("queue.start");
  const json told = wait_for(*client, [](const json& m) {
    return m.value("method", "") == "queue" && m["params"]["gate"] == "specimen";
  });
  EXPECT_THAT(told["params"]["prompt"].get<std::string>(), HasSubstr("put paper-1 on"));
}

TEST_F(QueueOfRuns, AStrangerIsNamedAndNotPressed) {
  troubles[2].stray_F = 3e-12;
  troubles[3].stray_F = 3e-12;
  queue_up({"paper-1", "paper-1"}, kUnattended);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("stranger"));
  EXPECT_EQ(runs(), 1);
  EXPECT_THAT(queue()["prompt"].get<std::string>(), HasSubstr("but paper-1 had"));
  EXPECT_THAT(queue()["prompt"].get<std::string>(), HasSubstr("in run 1"));
  clock.run_for(io, 60min);
  EXPECT_EQ(runs(), 1);
  EXPECT_THAT(refusal("queue.answer", {{"text", "yes"}}), HasSubstr("nothing moves"));
  ok("queue.answer", {{"text", "paper-1"}});  // a person vouches for it
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty");
  EXPECT_EQ(runs(), 2);
}

TEST_F(QueueOfRuns, WithoutARunOfItsOwnASpecimenIsComparedWithItsFile) {
  troubles[1].stray_F = 5e-12;
  queue_up({"paper-1"}, kUnattended);
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("stranger"));
  EXPECT_THAT(queue()["prompt"].get<std::string>(), HasSubstr("by its file"));
  EXPECT_EQ(runs(), 0);
}

TEST_F(QueueOfRuns, RestsAndWaitsForATime) {
  const auto now_s = clock.unix_ns() / 1'000'000'000;
  queue_up({"paper-1"}, {{"unattended", true}, {"not_before_unix_s", now_s + 7200}});
  queue_up({"paper-1"}, {{"unattended", true}, {"rest_s", 600}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("time"));
  EXPECT_THAT(queue()["prompt"].get<std::string>(), HasSubstr("not before"));
  EXPECT_THAT(refusal("queue.answer", {{"text", "yes"}}), HasSubstr("waits for no answer"));
  ASSERT_TRUE(until([this](const json&) { return runs() == 2; }, 4h));
  EXPECT_GE(count("SELECT min(started_unix_ns) FROM run") / 1'000'000'000, now_s + 7200);
  EXPECT_GE(count("SELECT (SELECT started_unix_ns FROM run WHERE id = 2) - (SELECT ended_unix_ns "
                  "FROM run_end WHERE run_id = 1)"),
            599'000'000'000);
  ASSERT_TRUE(until_held());
}

TEST_F(QueueOfRuns, WhoSetTheClockOverATimeIsAskedAndNothingMoves) {
  const auto now_s = clock.unix_ns() / 1'000'000'000;
  queue_up({"paper-1"}, {{"unattended", true}, {"not_before_unix_s", now_s + 7200}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("time"));
  clock.step_wall_clock(3h);
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "clock_step");
  EXPECT_THAT(queue()["why"].get<std::string>(), HasSubstr("set the clock by 10800 s"));
  clock.run_for(io, 60min);
  EXPECT_EQ(runs(), 0);
  ok("queue.start");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 1);
}

TEST_F(QueueOfRuns, ConsentDoesNotLastUntilTheNight) {
  const auto now_s = clock.unix_ns() / 1'000'000'000;
  queue_up({"paper-1"}, {{"not_before_unix_s", now_s + 7200}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  ASSERT_TRUE(until_gate("time"));
  ASSERT_TRUE(until([](const json& q) { return q["gate"] == "person"; }, 3h));
  EXPECT_EQ(runs(), 0);
}

TEST_F(QueueOfRuns, AnEntryThatIsTooLateHoldsOrIsSkipped) {
  const auto now_s = clock.unix_ns() / 1'000'000'000;
  queue_up({"paper-1"},
           {{"unattended", true}, {"not_after_unix_s", now_s + 60}, {"on_failure", "skip"}});
  queue_up({"paper-1"}, {{"unattended", true}, {"not_after_unix_s", now_s + 60}});
  ok("queue.start");
  ASSERT_TRUE(until_gate("specimen"));
  ASSERT_TRUE(until_held()) << "nobody came";
  EXPECT_THAT(queue()["why"].get<std::string>(), HasSubstr("was to begin before"));
  EXPECT_EQ(state(1), "skipped");
  EXPECT_EQ(state(2), "failed");
  EXPECT_THAT(refusal("queue.start"), HasSubstr("--skip")) << "it would fail again";
  ok("queue.start", {{"head", "skip"}});
  ASSERT_TRUE(until_held());
  EXPECT_EQ(queue()["cause"], "empty");
  EXPECT_EQ(runs(), 0);
}

TEST_F(QueueOfRuns, AnotherProbeWaitsForItsName) {
  queue_up({"paper-1"}, {{"unattended", true}, {"probe", "tip-4"}, {"fixture", "holder-2"}});
  ok("queue.start");
  answer_gate("specimen", "paper-1");
  answer_gate("probe", "tip-4");
  answer_gate("fixture", "holder-2");
  ASSERT_TRUE(until_held());
  EXPECT_EQ(runs(), 1);
}

TEST_F(QueueOfRuns, RemovesAndClearsAndKeepsAHistoryOfWhoDidIt) {
  queue_up({"paper-1", "paper-1", "paper-1"});
  ok("queue.remove", {{"entry", 2}});
  EXPECT_EQ(state(2), "removed");
  EXPECT_EQ(ok("queue.clear")["removed"], 2);
  EXPECT_THAT(refusal("queue.remove", {{"entry", 2}}), HasSubstr("no entry 2"));
  EXPECT_THAT(refusal("queue.show", {{"entry", 99}}), HasSubstr("never an entry 99"));
  EXPECT_THAT(refusal("queue.start"), HasSubstr("nothing is queued"));
  const json history = ok("queue.history", json{{"entry", 2}});
  const json& acts = history.at("acts");
  ASSERT_EQ(acts.size(), 2U);
  EXPECT_EQ(acts[0]["act"], "remove");
  EXPECT_EQ(acts[1]["act"], "add");
  EXPECT_EQ(acts[1]["uid"], ::getuid());
}

}  // namespace
}  // namespace lcrig
