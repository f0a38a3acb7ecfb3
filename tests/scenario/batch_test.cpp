// SPDX-License-Identifier: Apache-2.0
// A table of runs: sent over the control socket into the queue, and a whole day of them rehearsed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/strict_json.hpp"
#include "daemon/rehearse_batch.hpp"
#include "storage/batches.hpp"
#include "tests/support/queue_world.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::QueueWorld;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

json file_of(const std::string& name, const std::string& text) {
  return json{{"name", name}, {"text", text}};
}
json batch_of(const std::string& table, json more = json::object()) {
  json out{{"name", "day"}, {"file", "day.csv"}, {"table", table}};
  out["protocols"]["phased"] = file_of("phased", support::kPhasedProtocol);
  for (const ShippedSpecimen& s : shipped_specimens()) {
    out["specimens"][std::string(s.name)] = file_of(std::string(s.name), std::string(s.text));
  }
  out.update(more);
  return out;
}
constexpr const char* kTwoByTwo =
    "specimen,protocol,repeats,unattended,rest_s\npaper-1,phased,2,yes,\npaper-2,phased,2,no,30\n";

class BatchOfRuns : public QueueWorld {};

TEST_F(BatchOfRuns, IsQueuedAsAWholeInItsOrderAndOnTheTermsOfItsRows) {
  const json added = ok("queue.add_batch", batch_of(kTwoByTwo, {{"on_failure", "skip"}}));
  EXPECT_EQ(added["entries"], 4);
  EXPECT_EQ(added["first_entry"], 1);
  EXPECT_EQ(added["unplanned"], 0);
  EXPECT_GT(added["duration_s"].get<double>(), 40);
  const json listed = ok("queue.list");
  std::vector<std::string> specimens;
  for (const json& e : listed["entries"]) specimens.push_back(e["specimen"].get<std::string>());
  EXPECT_THAT(specimens, ElementsAre("paper-1", "paper-1", "paper-2", "paper-2"));
  const json third = ok("queue.show", {{"entry", 3}});
  EXPECT_EQ(third["terms"]["unattended"], false);
  EXPECT_EQ(third["terms"]["rest_s"], 30.0);
  EXPECT_EQ(third["terms"]["on_failure"], "skip") << "what holds for all rows";
  EXPECT_EQ(third["batch"]["name"], "day");
  EXPECT_EQ(third["batch"]["line"], 3);
  EXPECT_EQ(third["batch"]["position"], 3);
  EXPECT_EQ(third["batch"]["of"], 4);
  EXPECT_TRUE(third["plan"]["duration_s"].is_number());
}

TEST_F(BatchOfRuns, ASeedDecidesTheOrderAndIsShown) {
  const std::string table =
      "specimen,protocol,repeats,note\npaper-1,phased,6,a\npaper-1,phased,6,b\n";
  ok("queue.add_batch", batch_of(table, {{"order", "random"}, {"seed", 5}}));
  ok("queue.add_batch", batch_of(table, {{"order", "random"}, {"seed", 5}, {"name", "again"}}));
  const json entries = ok("queue.list")["entries"];
  std::string first, second;
  for (std::size_t i = 0; i < 12; ++i) first += entries[i]["note"].get<std::string>();
  for (std::size_t i = 12; i < 24; ++i) second += entries[i]["note"].get<std::string>();
  EXPECT_EQ(first, second);
  EXPECT_NE(first, "aaaaaabbbbbb");
  EXPECT_EQ(ok("queue.show", {{"entry", 1}})["batch"]["seed"], 5);
}

TEST_F(BatchOfRuns, OfAWrongTableNothingIsQueuedAndEverythingIsSaid) {
  const json got =
      call("queue.add_batch", batch_of("specimen,protocol,repeats\npaper-1,phased,x\n,phased,2\n"));
  ASSERT_TRUE(got.contains("error")) << got;
  EXPECT_THAT(got["error"]["message"].get<std::string>(), HasSubstr("day.csv:2:16 repeats"));
  EXPECT_THAT(got["error"]["data"]["detail"].get<std::string>(),
              HasSubstr("day.csv:3:1 specimen: is empty"));
  EXPECT_EQ(ok("queue.list")["count"], 0);
  EXPECT_THAT(refusal("queue.add_batch", batch_of("specimen,protocol\n")), HasSubstr("no row"));
  ok("queue.add_batch", batch_of(kTwoByTwo));
  EXPECT_THAT(refusal("queue.add_batch", batch_of(kTwoByTwo)), HasSubstr("`day` exists already"));
  EXPECT_EQ(ok("queue.list")["count"], 4);
}

TEST_F(BatchOfRuns, WhatTheRigWouldRefuseNamesItsRow) {
  // 2 N is more than the limit of the protocol allows.
  std::string text = support::kPhasedProtocol;
  const std::string aim = R"("until": { "force_N": 0.5 })";
  text.replace(text.find(aim), aim.size(), R"("until": { "force_N": 2 })");
  json batch = batch_of("specimen,protocol\npaper-1,phased\npaper-1,strong\n");
  batch["protocols"]["strong"] = file_of("strong", text);
  EXPECT_THAT(refusal("queue.add_batch", batch),
              AllOf(HasSubstr("day.csv:3:1: "), HasSubstr("limit")));
  EXPECT_EQ(ok("queue.list")["count"], 0);
}

TEST_F(BatchOfRuns, IsRunLikeWhatWasQueuedOneByOne) {
  ok("queue.add_batch", batch_of("specimen,protocol,repeats,unattended\npaper-1,phased,2,yes\n"));
  ok("queue.start");
  ASSERT_TRUE(until_gate("specimen"));
  ok("queue.answer", {{"text", "paper-1"}});
  ASSERT_TRUE(until_held());
  EXPECT_EQ(count("SELECT count(*) FROM run_end WHERE exit_status = 'success'"), 2);
  EXPECT_EQ(count("SELECT count(*) FROM batch_entry AS b JOIN queue_attempt AS a"
                  " ON a.entry_id = b.entry_id"),
            2);
}

class RehearsedDay : public testing::Test {
 protected:
  RehearseBatchRequest request(const std::string& table) {
    RehearseBatchRequest out;
    out.db_path = dir.file("r.db");
    out.begin_unix_ns = 1'790'000'000'000'000'000;
    out.batch.name = "day";
    out.batch.file_name = "day.csv";
    out.batch.table = table;
    BatchFile file;
    file.name = "phased";
    file.text = protocol;
    out.batch.protocols["phased"] = file;
    // The plan cannot know that the specimen is farther away.
    const std::string within = "\"within_mm\": 100";
    file.text.replace(file.text.find(within), within.size(), "\"within_mm\": 1");
    out.batch.protocols["short"] = file;
    for (const ShippedSpecimen& s : shipped_specimens()) {
      file.name = s.name;
      file.text = s.text;
      out.batch.specimens[file.name] = file;
    }
    return out;
  }
  TempDir dir;
  // On the paper bench the contact is where the shipped protocols search for it.
  std::string protocol = read_text_file("protocols/library/preconditioning.json").value();
};

TEST_F(RehearsedDay, TellsItsLengthAndWhenHandsAreNeeded) {
  RehearseBatchRequest wanted = request(kTwoByTwo);
  wanted.hand_s = 100;
  const auto day = rehearse_batch(wanted);
  ASSERT_TRUE(day) << day.error().what;
  EXPECT_THAT(day->entries, SizeIs(4));
  for (const RehearsedEntry& e : day->entries) {
    EXPECT_EQ(e.exit_status, ExitStatus::success) << e.reason;
  }
  EXPECT_THAT(day->troubles, SizeIs(0));
  std::vector<std::optional<QueueGate>> gates;
  for (const HandTime& hand : day->hands) gates.push_back(hand.gate);
  // The person who mounted paper-2 is still there for one of its runs.
  EXPECT_THAT(gates, ElementsAre(QueueGate::specimen, QueueGate::specimen, QueueGate::person));
  EXPECT_EQ(day->hands_s, 300);
  EXPECT_GE(day->length_s, day->machine_s + 300 + 2 * 30 - 100) << "rests of 30 s, one in a gate";
  EXPECT_LE(day->length_s, day->machine_s + 300 + 2 * 30 + 60);
  const auto again = rehearse_batch(wanted);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->name, "day-2");
}

// A tripped limit holds the queue whatever the terms say. Somebody looks, and the day goes on.
TEST_F(RehearsedDay, WhatFailsIsToldAndSkippedAndTheDayGoesOn) {
  for (const std::string terms : {"hold", "skip", "look"}) {
    SCOPED_TRACE(terms);
    const auto day =
        rehearse_batch(request("specimen,protocol,unattended,on_failure\n"
                               "paper-1,short,yes," +
                               terms +
                               "\n"
                               "paper-1,phased,yes,hold\n"));
    ASSERT_TRUE(day) << day.error().what;
    ASSERT_THAT(day->entries, SizeIs(2));
    EXPECT_EQ(day->entries[0].state, EntryState::skipped);
    EXPECT_NE(day->entries[0].exit_status, ExitStatus::success);
    EXPECT_THAT(day->entries[0].reason, HasSubstr("contact"));
    EXPECT_EQ(day->entries[1].exit_status, ExitStatus::success) << day->entries[1].reason;
    EXPECT_THAT(day->troubles, ElementsAre(AllOf(HasSubstr("entry "), HasSubstr("(limit)"))));
    ASSERT_THAT(day->hands, SizeIs(2));
    EXPECT_EQ(day->hands[1].gate, std::nullopt) << "the queue held";
    EXPECT_GE(day->length_s, day->machine_s + day->hands_s);
  }
}

TEST_F(RehearsedDay, LeavesAQueueOfPeopleAlone) {
  const RehearseBatchRequest wanted = request(kTwoByTwo);
  {
    const auto db = open_read_write(wanted.db_path).value();
    QueuedRun run;
    run.protocol_name = "press";
    QueueActor who;
    who.user = "ada";
    who.uid = 1000;
    const std::vector<QueuedRun> runs(1, run);
    ASSERT_TRUE(add_to_queue(db, runs, QueuePlace(), who));
  }
  const auto day = rehearse_batch(wanted);
  ASSERT_FALSE(day);
  EXPECT_THAT(day.error().what, HasSubstr("give another --db"));
}

}  // namespace
}  // namespace lcrig
