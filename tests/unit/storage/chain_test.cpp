// SPDX-License-Identifier: Apache-2.0
#include "storage/chain.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/specimens.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

class ChainTest : public testing::Test {
 protected:
  void SetUp() override {
    auto db = open_read_write(dir_.file("a.db"));
    ASSERT_TRUE(db) << db.error().what;
    db_ = std::move(*db);
    auto run = insert_run(db_, RunRow());
    ASSERT_TRUE(run) << run.error().what;
    run_ = *run;
    for (int i = 0; i < 3; ++i) add_samples(2);
    RunEnd end;
    end.reason = "done";
    ASSERT_TRUE(insert_run_end(db_, run_, end));
    ASSERT_TRUE(add_run_note(db_, run_, "ann", "looks good", 5));
  }
  void add_samples(int count) {
    auto transaction = Transaction::begin(db_);
    auto chain = ChainWriter::prepare(db_);
    auto writer = RowWriter::prepare(db_, "frame_sample");
    ASSERT_TRUE(transaction && chain && writer);
    auto head = chain->head(run_);
    ASSERT_TRUE(head);
    RowHash hash;
    hash.start(head->hash);
    for (int i = 0; i < count; ++i) {
      const auto seq = ++head->last_of(RunTable::frame_sample);
      writer->begin(hash).add(run_).add(seq).add(seq * 20).add(seq);
      writer->add(std::optional<double>()).add(0.5 * static_cast<double>(seq)).add(-0.0);
      writer->add(std::int64_t{0});
      ASSERT_TRUE(writer->insert());
    }
    ASSERT_TRUE(chain->append(*head, hash));
    ASSERT_TRUE(transaction->commit());
  }
  // Changes the database as somebody would who gets around the triggers; returns the chain's
  // report.
  ChainReport after(const std::string& sql) {
    auto triggers = db_.execute(
        "DROP TRIGGER frame_sample_no_update; DROP TRIGGER frame_sample_no_delete;"
        "DROP TRIGGER run_no_update; DROP TRIGGER run_end_no_update; DROP TRIGGER chain_no_delete;"
        "DROP TRIGGER run_note_no_delete; DROP TRIGGER chain_no_update;"
        "DROP TRIGGER run_end_no_delete");
    EXPECT_TRUE(triggers);
    auto done = db_.execute(sql);
    EXPECT_TRUE(done) << done.error().what;
    auto report = verify_chain(db_, run_);
    EXPECT_TRUE(report) << report.error().what;
    return report.value_or(ChainReport());
  }

  TempDir dir_;
  Database db_;
  std::int64_t run_ = 0;
};

TEST_F(ChainTest, HoldsForAnUntouchedRun) {
  auto report = verify_chain(db_, run_);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->intact) << report->finding;
  EXPECT_TRUE(report->ended);
  EXPECT_EQ(report->head.links, 6);
  EXPECT_EQ(report->rows, 9);
}

TEST_F(ChainTest, ARunWithoutAnyLinkIsListedAndBroken) {
  EXPECT_FALSE(after("DELETE FROM chain").intact);
  const auto listed = list_runs(db_, RunFilter());
  ASSERT_TRUE(listed) << listed.error().what;
  ASSERT_EQ(listed->size(), 1U);
  EXPECT_EQ(listed->front().frame_samples, 0);
}

TEST_F(ChainTest, ShowsAChangedValueAtItsLink) {
  const auto report = after("UPDATE frame_sample SET force_N = 1.5000000000000002 WHERE seq = 3");
  EXPECT_FALSE(report.intact);
  EXPECT_THAT(report.finding, HasSubstr("link 3"));
}
TEST_F(ChainTest, ShowsAMissingValueTurnedIntoZero) {
  EXPECT_FALSE(after("UPDATE frame_sample SET device_time_s = 0 WHERE seq = 1").intact);
}
TEST_F(ChainTest, ShowsARemovedRow) {
  EXPECT_THAT(after("DELETE FROM frame_sample WHERE seq = 4").finding, HasSubstr("4 is missing"));
}
TEST_F(ChainTest, ShowsARemovedLastRow) {
  EXPECT_FALSE(after("DELETE FROM run_note").intact);
}
TEST_F(ChainTest, ShowsAnAddedRow) {
  EXPECT_THAT(after("INSERT INTO frame_sample VALUES (1, 7, 140, 7, NULL, 1.0, 1.0, 0)").finding,
              HasSubstr("in no link"));
}
TEST_F(ChainTest, ShowsAChangedRunAndAChangedEnd) {
  EXPECT_THAT(after("UPDATE run SET operator = 'x'").finding, HasSubstr("link 1"));
}
TEST_F(ChainTest, ShowsAChangedEnd) {
  EXPECT_FALSE(after("UPDATE run_end SET exit_status = 'fail'").intact);
}
TEST_F(ChainTest, ShowsARemovedEndAndItsLinks) {
  EXPECT_FALSE(after("DELETE FROM run_end").intact);
}
TEST_F(ChainTest, ShowsARemovedLink) {
  EXPECT_THAT(after("DELETE FROM chain WHERE seq = 2").finding, HasSubstr("link 2 is missing"));
}
TEST_F(ChainTest, ShowsAChangedHash) {
  EXPECT_FALSE(after("UPDATE chain SET sha256 = zeroblob(32) WHERE seq = 6").intact);
}
TEST_F(ChainTest, AnUnknownRunIsAnError) {
  EXPECT_THAT(verify_chain(db_, 99).error().what, HasSubstr("no run 99"));
}

TEST_F(ChainTest, NoStoredRowCanBeChangedOrDeleted) {
  ASSERT_TRUE(add_specimen(db_, "paper-1", "{}", 1));
  ASSERT_TRUE(
      db_.execute("INSERT INTO level VALUES (1, 1, 1, 's', 1, 1, NULL, NULL, 30, 0);"
                  "INSERT INTO event VALUES (1, 1, 0, 'mark', '', '');"
                  "INSERT INTO lcr_reading (run_id, seq, asked_mono_ns, first_byte_mono_ns,"
                  " last_byte_mono_ns, step_id, repeat, fresh, flags, function, status)"
                  " VALUES (1, 1, 0, 0, 0, '', 0, 1, 0, 'Cp-D', '')"));
  for (const char* table : {"run", "run_end", "run_note", "level", "event", "lcr_reading",
                            "frame_sample", "chain", "run_anchor", "specimen"}) {
    const std::string key =
        std::string(table) == "run" || std::string(table) == "specimen" ? "id" : "run_id";
    for (const auto& sql : {fmt::format("UPDATE {} SET {} = {}", table, key, key),
                            fmt::format("DELETE FROM {}", table),
                            fmt::format("INSERT OR REPLACE INTO {0} SELECT * FROM {0}", table)}) {
      auto r = db_.execute(sql);
      ASSERT_FALSE(r) << sql;
      EXPECT_THAT(r.error().what, HasSubstr("append-only")) << sql;
    }
  }
}

TEST_F(ChainTest, ASecondEndIsRefused) {
  EXPECT_FALSE(insert_run_end(db_, run_, RunEnd()));
  EXPECT_TRUE(verify_chain(db_, run_)->intact);
}

TEST_F(ChainTest, RunsAreFoundByNumberOrLast) {
  EXPECT_EQ(find_run(db_, "1").value_or(0), 1);
  EXPECT_EQ(find_run(db_, "last").value_or(0), 1);
  EXPECT_THAT(find_run(db_, "2").error().what, HasSubstr("no run 2"));
  EXPECT_THAT(find_run(db_, "1x").error().what, HasSubstr("1x"));
  EXPECT_EQ(list_runs(db_)->size(), 1U);
  EXPECT_EQ(get_run_notes(db_, 1)->at(0).text, "looks good");
  EXPECT_EQ(get_run_listing(db_, 1)->frame_samples, 6);
}

// Bytes that this process has read from files so far.
std::int64_t bytes_read() {
  std::ifstream figures("/proc/self/io");
  std::string name;
  std::int64_t value = 0;
  while (figures >> name >> value && name != "rchar:") {
  }
  return value;
}

TEST_F(ChainTest, AListOfRunsThatEndedDoesNotReadTheirChains) {
  constexpr std::int64_t kRuns = 300, kLinksEach = 200;
  for (std::int64_t run = 2; run <= kRuns; ++run) {
    ASSERT_TRUE(insert_run(db_, RunRow()));
    ASSERT_TRUE(db_.change(
        "WITH RECURSIVE n(seq) AS (VALUES (2) UNION ALL SELECT seq + 1 FROM n WHERE seq < ?2)"
        " INSERT INTO chain SELECT ?1, seq, 0, 0, seq, seq, 0, 0, zeroblob(32) FROM n",
        run, kLinksEach));
    if (run == kRuns) break;
    ASSERT_TRUE(insert_run_end(db_, run, RunEnd()));
  }
  ASSERT_TRUE(db_.execute("PRAGMA wal_checkpoint(TRUNCATE)"));
  const auto other = open_read_only(dir_.file("a.db")).value();
  const auto before = bytes_read();
  const auto runs = list_runs(other).value();
  EXPECT_LT(bytes_read() - before, kRuns * 1000) << "a page of 4096 bytes for each run";
  ASSERT_EQ(runs.size(), std::size_t{kRuns});
  EXPECT_EQ(runs[0].lcr_readings, kLinksEach) << "of the run that did not end";
  EXPECT_EQ(runs[1].lcr_readings, kLinksEach);
}

TEST_F(ChainTest, SpecimensAreVersionedByTheirContent) {
  const auto first = add_specimen(db_, "paper-1", "a", 1);
  const auto same = add_specimen(db_, "paper-1", "a", 2);
  const auto changed = add_specimen(db_, "paper-1", "b", 3);
  ASSERT_TRUE(first && same && changed);
  EXPECT_EQ(first->id, same->id);
  EXPECT_EQ(changed->version, 2);
  EXPECT_EQ((*find_specimen(db_, "paper-1"))->text, "b");
  EXPECT_FALSE(find_specimen(db_, "paper-9")->has_value());
  EXPECT_EQ(list_specimens(db_)->size(), 1U);
}

}  // namespace
}  // namespace lcrig
