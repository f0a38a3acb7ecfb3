// SPDX-License-Identifier: Apache-2.0
#include "storage/copy_runs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <set>

#include "storage/chain.hpp"
#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/faulty_disk.hpp"
#include "storage/runs.hpp"
#include "storage/tags.hpp"
#include "storage/writer_lock.hpp"
#include "tests/support/old_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class RunCopies : public testing::Test {
 protected:
  // Run 1 with everything that a run can have, run 2 with little, run 3 without an end.
  void SetUp() override {
    db_ = open_read_write(path_).value();
    std::string digits(64, '0');
    ASSERT_TRUE(
        db_.execute("INSERT INTO specimen VALUES (7, 'paper-1', 1, '" + digits + "', '{}', 1)"));
    RunRow row;
    row.protocol_name = "press";
    row.specimen_id = 7;
    row.specimen_name = "paper-1";
    row.specimen_text = "the text";
    row.probe_diameter_m = 0.004;
    row.made_unix_ns = 4;
    ASSERT_EQ(insert_run(db_, row).value_or(0), 1);
    add_rows(1);
    ASSERT_TRUE(insert_run_end(db_, 1, RunEnd()));
    ASSERT_TRUE(add_run_note(db_, 1, "Ada", "dusty", 5));
    TagChange tag;
    tag.run = 1;
    tag.tags = {"thesis"};
    ASSERT_TRUE(change_tags(db_, tag, "Ada", 6));
    for (const std::int64_t run : {2, 3}) ASSERT_EQ(insert_run(db_, RunRow()).value_or(0), run);
    ASSERT_TRUE(insert_run_end(db_, 2, RunEnd()));
  }
  // One commit with a row in each table, and a value of each type.
  void add_rows(std::int64_t run) const {
    auto transaction = Transaction::begin(db_).value();
    auto chain = ChainWriter::prepare(db_).value();
    auto head = chain.head(run).value();
    RowHash hash;
    hash.start(head.hash);
    auto levels = RowWriter::prepare(db_, "level").value();
    levels.begin(hash).add(run).add(++head.last_of(RunTable::level)).add(std::int64_t{1});
    levels.add("hold").add(std::int64_t{1}).add(std::int64_t{0}).add(0.5);
    levels.add(std::optional<double>()).add(std::int64_t{10}).add(std::int64_t{100});
    ASSERT_TRUE(levels.insert());
    auto events = RowWriter::prepare(db_, "event").value();
    events.begin(hash).add(run).add(++head.last_of(RunTable::event)).add(std::int64_t{100});
    events.add("mark").add("hold").add("µ \"quoted\"");
    ASSERT_TRUE(events.insert());
    auto readings = RowWriter::prepare(db_, "lcr_reading").value();
    readings.begin(hash).add(run).add(++head.last_of(RunTable::lcr_reading));
    for (const std::int64_t at : {1, 2, 3}) readings.add(at);
    readings.add(std::optional<std::int64_t>()).add("hold").add(std::int64_t{1});
    readings.add(std::int64_t{1}).add(std::int64_t{1}).add(std::int64_t{1}).add(std::int64_t{0});
    readings.add("Cp-D").add("OK").add(1.5e-12).add(0.01);
    for (int i = 0; i < 5; ++i) readings.add(std::optional<double>());
    ASSERT_TRUE(readings.insert());
    auto samples = RowWriter::prepare(db_, "frame_sample").value();
    for (int i = 0; i < 40'000; ++i) {
      const auto seq = ++head.last_of(RunTable::frame_sample);
      samples.begin(hash).add(run).add(seq).add(seq * 20).add(seq);
      samples.add(std::optional<double>()).add(0.1 * static_cast<double>(seq)).add(0.25);
      ASSERT_TRUE(samples.add(std::int64_t{0}).insert());
    }
    ASSERT_TRUE(chain.append(head, hash));
    ASSERT_TRUE(transaction.commit());
  }
  Result<std::vector<CopiedRun>> copy(std::vector<std::int64_t> runs, const std::string& to,
                                      RunCopyOptions options = {}) const {
    options.by = "Bob";
    options.now_unix_ns = 9;
    return copy_runs(path_, std::move(runs), to, std::move(options));
  }
  Result<std::vector<CopiedRun>> copy_on_disk_that_fills(std::int64_t operation,
                                                         const std::string& to) const {
    FaultyDisk disk;
    disk.fail_operation(operation, FaultyDisk::Failure::full);
    RunCopyOptions options;
    options.vfs = disk.name();
    return copy({1, 2}, to, std::move(options));
  }
  static std::int64_t runs_in(const std::string& file) {
    return open_read_only(file).value().integer("SELECT count(*) FROM run").value();
  }
  std::string refusal(std::vector<std::int64_t> runs, const std::string& to) const {
    const auto copied = copy(std::move(runs), to);
    return copied ? "it was copied" : copied.error().what;
  }
  std::set<std::string> files() const {
    std::set<std::string> out;
    for (const auto& entry : fs::directory_iterator(dir_.path())) {
      out.insert(entry.path().filename().string());
    }
    return out;
  }
  static std::string all_rows(const Database& db, const std::string& table, std::int64_t run) {
    std::string out;
    auto statement = db.query("SELECT name FROM pragma_table_info(?)", std::string_view(table));
    std::string columns;
    while (statement->step().value_or(false)) {
      const std::string name(statement->text(0));
      if (name == "run_id" || name == "id" || name == "specimen_id") continue;
      columns += (columns.empty() ? "quote(" : " || ',' || quote(") + name + ")";
    }
    auto all = db.query(fmt::format("SELECT {} FROM {} WHERE {} = ?", columns, table,
                                    table == "run" ? "id" : "run_id"),
                        run);
    EXPECT_TRUE(all) << all.error().what;
    while (all->step().value_or(false)) out += std::string(all->text(0)) + "\n";
    return out;
  }

  TempDir dir_;
  std::string path_ = dir_.file("rig.db"), to_ = dir_.file("other.db");
  Database db_;
};

TEST_F(RunCopies, AreWholeAndKeepTheirNameAndTheirChain) {
  {
    const auto other = open_read_write(to_).value();
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(insert_run(other, RunRow()));
  }
  const auto copied = copy({2, 1, 2}, to_);
  ASSERT_TRUE(copied) << copied.error().what;
  ASSERT_EQ(copied->size(), 2U);
  const auto other = open_read_only(to_).value();
  for (std::size_t i : {0U, 1U}) {
    const CopiedRun& run = (*copied)[i];
    EXPECT_EQ(run.from, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(run.to, run.from + 4);
    EXPECT_EQ(run.uuid, get_uuid(db_, run.from).value());
    const auto before = verify_chain(db_, run.from).value(),
               after = verify_chain(other, run.to).value();
    EXPECT_TRUE(after.intact) << after.finding;
    EXPECT_EQ(after.head, before.head) << "an anchor in the journal still fits";
    EXPECT_EQ(get_anchor(other, run.to).value(), get_anchor(db_, run.from).value());
  }
  for (const char* table : {"run", "run_end", "run_note", "level", "event", "lcr_reading",
                            "frame_sample", "chain", "run_anchor", "run_tag", "run_made"}) {
    EXPECT_EQ(all_rows(other, table, 5), all_rows(db_, table, 1)) << table;
    EXPECT_FALSE(all_rows(other, table, 5).empty()) << table;
  }
  const auto from = get_copied_from(other, 5).value();
  ASSERT_TRUE(from);
  EXPECT_EQ(from->run, 1);
  EXPECT_EQ(from->by, "Bob");
  EXPECT_EQ(from->file, fs::canonical(path_).string());
  EXPECT_EQ(fs::file_size(to_ + "-wal"), 0U) << "the file alone is whole";
}

// Add a new table of a run here, with whether it is copied.
TEST_F(RunCopies, LeaveNoTableOut) {
  const auto tables = db_.rows(
      "SELECT DISTINCT m.name FROM sqlite_schema AS m, pragma_foreign_key_list(m.name) AS k"
      " WHERE m.type = 'table' AND k.\"table\" = 'run' ORDER BY m.name",
      [](const Statement& s) { return std::string(s.text(0)); });
  EXPECT_THAT(tables.value(), ElementsAre("chain", "event", "frame_sample", "lcr_reading", "level",
                                          "queue_attempt",  // stays: the queue belongs to a rig
                                          "queue_entry",  // likewise
                                          "run_anchor",
                                          "run_copy",  // written anew
                                          "run_end", "run_made", "run_note", "run_tag"));
}

TEST_F(RunCopies, TakeNotesAndAreCopiedOn) {
  ASSERT_TRUE(copy({1}, to_));
  {
    const auto other = open_read_write(to_).value();
    ASSERT_TRUE(add_run_note(other, 1, "Eve", "seen again", 8));
    ASSERT_TRUE(insert_run(other, RunRow()));
    EXPECT_TRUE(verify_chain(other, 1).value().intact);
  }
  const auto third = dir_.file("third.db");
  {
    const auto db = open_read_write(third).value();
    for (int i = 0; i < 9; ++i) ASSERT_TRUE(insert_run(db, RunRow()));
  }
  const auto copied = copy_runs(to_, {1}, third, {});
  ASSERT_TRUE(copied) << copied.error().what;
  const auto db = open_read_only(third).value();
  const auto chain = verify_chain(db, 10).value();
  EXPECT_TRUE(chain.intact) << chain.finding;
  EXPECT_EQ(get_run_notes(db, 10).value().size(), 2U);
  EXPECT_EQ(get_copied_from(db, 10).value()->run, 1);
  EXPECT_EQ(get_copied_from(db, 10).value()->file, fs::canonical(path_).string());
}

TEST_F(RunCopies, OfARunFromBeforeUuidsAreSoundToo) {
  const auto old = dir_.file("old.db");
  {
    const auto db = support::database_before_uuids(old);
    support::insert_old_run(db, 1);
    support::insert_old_run(db, 2);
    ASSERT_TRUE(insert_run_end(db, 2, RunEnd()));
  }
  EXPECT_THAT(copy_runs(old, {2}, to_, {}).error().what, HasSubstr("schema 7 is older"));
  {
    ASSERT_TRUE(open_read_write(old));
  }
  const auto copied = copy_runs(old, {2}, to_, {});
  ASSERT_TRUE(copied) << copied.error().what;
  EXPECT_EQ(copied->front().to, 1);
  const auto db = open_read_only(to_).value();
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
  EXPECT_EQ(get_uuid(db, 1).value(), copied->front().uuid);
}

TEST_F(RunCopies, HaveANumberOfWhereTheyWereRecordedThatCannotBeChanged) {
  ASSERT_TRUE(copy({1}, to_));
  const auto other = open_read_write(to_).value();
  ASSERT_TRUE(other.execute("DROP TRIGGER run_copy_no_update; DROP TRIGGER run_copy_no_delete"));
  for (const char* change :
       {"UPDATE run_copy SET recorded_run = 2", "UPDATE run_copy SET recorded_specimen_id = NULL",
        "DELETE FROM run_copy"}) {
    ASSERT_TRUE(other.execute("SAVEPOINT before"));
    ASSERT_TRUE(other.execute(change));
    EXPECT_THAT(verify_chain(other, 1).value().finding, HasSubstr("link 1 does not match"))
        << change;
    ASSERT_TRUE(other.execute("ROLLBACK TO before; RELEASE before"));
  }
  EXPECT_TRUE(verify_chain(other, 1).value().intact);
}

// As docs/database.md says: the chain covers what was recorded and nothing else.
TEST_F(RunCopies, HaveAnOriginBesideTheNumberThatIsNotHashed) {
  ASSERT_TRUE(copy({1}, to_));
  const auto other = open_read_write(to_).value();
  const auto before = verify_chain(other, 1).value();
  ASSERT_TRUE(
      other.execute("DROP TRIGGER run_copy_no_update; UPDATE run_copy SET "
                    "copied_from = '/else.db', copied_by = 'eve', copied_unix_ns = 1"));
  EXPECT_TRUE(verify_chain(other, 1, before.head).value().intact);
  const auto here = open_read_write(path_).value();
  const auto recorded = verify_chain(here, 1).value();
  ASSERT_TRUE(
      here.execute("INSERT INTO run_copy SELECT 1, 1, specimen_id, '/else.db', 'eve', 1 "
                   "FROM run WHERE id = 1"));
  EXPECT_TRUE(verify_chain(here, 1, recorded.head).value().intact);
}

TEST_F(RunCopies, AreMadeOnce) {
  ASSERT_TRUE(copy({2}, to_));
  const auto again = refusal({1, 2}, to_);
  EXPECT_THAT(again, HasSubstr("run 2 is there already, as run 1 (same uuid): nothing was copied"));
  ASSERT_TRUE(copy({1}, to_));
  EXPECT_THAT(refusal({1, 2}, to_),
              HasSubstr("run 1 is there already, as run 2; run 2 is there already, as run 1"));
  ASSERT_TRUE(add_run_note(db_, 1, "Ada", "more", 7));
  EXPECT_THAT(refusal({1}, to_), HasSubstr("without the notes that were added here since"));
  EXPECT_EQ(runs_in(to_), 2);
}

TEST_F(RunCopies, AreRefusedOfWhatIsNotSound) {
  auto lock = WriterLock::acquire(path_).value();
  const auto before = files();
  EXPECT_THAT(refusal({3}, to_), HasSubstr("run 3 was cut off"));
  ASSERT_TRUE(lock.begin_run(3));
  EXPECT_THAT(refusal({1, 3}, to_), HasSubstr("run 3 is still going on"));
  EXPECT_THAT(refusal({9}, to_), HasSubstr("no run 9"));
  ASSERT_TRUE(
      db_.execute("DROP TRIGGER frame_sample_no_update;"
                  "UPDATE frame_sample SET force_N = 9 WHERE run_id = 1 AND seq = 7"));
  EXPECT_THAT(refusal({2, 1}, to_),
              HasSubstr("run 1 is not as it was recorded (link 2 does not match its rows"));
  EXPECT_EQ(files(), before);
}

TEST_F(RunCopies, GoOnlyIntoADatabaseOfThisSchema) {
  fs::create_directory(dir_.file("folder"));
  fs::create_hard_link(path_, dir_.file("again.db"));
  fs::create_symlink("rig.db", dir_.file("link.db"));
  fs::create_symlink("nowhere.db", dir_.file("dangling.db"));
  {
    ASSERT_TRUE(open_read_write(dir_.file("two.db")));
  }
  fs::create_hard_link(dir_.file("two.db"), dir_.file("names.db"));
  std::ofstream(dir_.file("text.db")) << std::string(5000, 'x');
  std::ofstream(dir_.file("empty.db")).flush();
  ASSERT_EQ(::mkfifo(dir_.file("pipe").c_str(), 0600), 0);
  {
    support::database_before_uuids(dir_.file("older.db"));
  }
  std::ofstream(dir_.file("log.db-wal")) << "readings";
  {
    const auto newer = open_read_write(dir_.file("newer.db")).value();
    ASSERT_TRUE(newer.execute("PRAGMA user_version = 9999"));
    const auto songs =
        Database::open(dir_.file("songs.db"), Database::Mode::read_write_create).value();
    ASSERT_TRUE(songs.execute("CREATE TABLE song (title TEXT)"));
  }
  fs::remove(path_ + ".lock");
  const auto before = files();
  const std::pair<const char*, const char*> places[] = {
      {"rig.db", "is the database itself"},
      {"again.db", "is the database itself"},
      {"link.db", "is the database itself"},
      {"names.db", "2 names (hard links)"},
      {"rig.db-wal", "belongs to the database"},
      {"dangling.db", "a link to nothing"},
      {"log.db", "there is no database, but its log"},
      {"folder", "is a folder"},
      {"folder/", "a folder"},
      {"pipe", "a pipe or a device"},
      {"text.db", "is not a database"},
      {"empty.db", "is empty, and no database"},
      {"songs.db", "of another program"},
      {"older.db", "schema 7 is older"},
      {"newer.db", "schema 9999 is newer"},
      {"none/other.db", "check that its folder is there"}};
  for (const auto& [place, words] : places) {
    EXPECT_THAT(refusal({1}, dir_.file(place)), HasSubstr(words)) << place;
    EXPECT_EQ(files(), before) << place;
  }
  EXPECT_EQ(open_read_only(dir_.file("older.db")).value().integer("PRAGMA user_version").value(),
            support::kSchemaBeforeUuids);
}

TEST_F(RunCopies, AreNotMadeIntoTheDatabaseOfADaemon) {
  {
    ASSERT_TRUE(open_read_write(to_));
  }
  const auto daemon = WriterLock::acquire(to_).value();
  const auto copied = copy({1}, to_);
  ASSERT_FALSE(copied);
  EXPECT_EQ(copied.error().code, Errc::busy);
  EXPECT_THAT(copied.error().what, HasSubstr("a daemon, or another copy, writes to it"));
  EXPECT_EQ(runs_in(to_), 0);
}

// Each write and each sync fails in turn.
TEST_F(RunCopies, LeaveNothingHalfOnAFullDisk) {
  const auto target = dir_.file("new.db");
  const auto before = files();
  int failures = 0;
  for (std::int64_t n = 0;; n += 1 + n / 4) {
    ASSERT_LT(n, 20'000);
    const auto copied = copy_on_disk_that_fills(n, target);
    if (copied) break;
    ++failures;
    EXPECT_THAT(copied.error().what, HasSubstr("is full")) << n;
    EXPECT_EQ(files(), before) << n;
  }
  EXPECT_EQ(runs_in(target), 2);
  EXPECT_GT(failures, 15);
}

// Once they are stored they stay; the rest of the work is to move them from the log.
TEST_F(RunCopies, AreAllOrNoneInAnOlderDatabaseOnAFullDisk) {
  int none = 0, all = 0;
  for (std::int64_t n = 0;; n += 1 + n / 4) {
    ASSERT_LT(n, 20'000);
    const auto target = dir_.file(fmt::format("{}.db", n));
    {
      ASSERT_TRUE(open_read_write(target));
    }
    const auto copied = copy_on_disk_that_fills(n, target);
    if (copied) {
      EXPECT_EQ(runs_in(target), 2);
      break;
    }
    if (runs_in(target) == 0) {
      ++none;
      EXPECT_THAT(copied.error().what, HasSubstr("is full")) << n;
    } else {
      ++all;
      EXPECT_EQ(runs_in(target), 2) << n;
      EXPECT_THAT(copied.error().what, HasSubstr("the runs are copied")) << n;
      EXPECT_THAT(copied.error().what, HasSubstr("keep both files together")) << n;
      EXPECT_TRUE(verify_chain(open_read_only(target).value(), 2).value().intact) << n;
    }
  }
  EXPECT_GT(none, 15);
  EXPECT_GT(all, 0);
}

TEST_F(RunCopies, EndWhenTheyAreStoppedAtAnyInstant) {
  const auto before = files();
  int last = 1;
  for (;; ++last) {
    ASSERT_LT(last, 100);
    int asked = 0;
    RunCopyOptions options;
    options.goes_on = [&] { return ++asked != last; };
    const auto copied = copy({1, 2}, to_, options);
    if (copied) break;
    EXPECT_EQ(copied.error().code, Errc::aborted) << copied.error().what;
    EXPECT_EQ(files(), before);
  }
  EXPECT_GT(last, 3);
}

}  // namespace
}  // namespace lcrig
