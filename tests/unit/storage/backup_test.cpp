// SPDX-License-Identifier: Apache-2.0
#include "storage/backup.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/faulty_disk.hpp"
#include "storage/runs.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Backup : public testing::Test {
 protected:
  // Two runs, of which the second goes on, and more pages than one step of the copy takes.
  void SetUp() override {
    auto db = open_read_write(path_);
    ASSERT_TRUE(db) << db.error().what;
    db_ = std::move(*db);
    ASSERT_TRUE(db_.execute("PRAGMA busy_timeout = 0"));
    ASSERT_EQ(insert_run(db_, RunRow()).value_or(0), 1);
    for (int i = 0; i < 10; ++i) add_samples(1, 3000);
    ASSERT_TRUE(insert_run_end(db_, 1, RunEnd()));
    ASSERT_EQ(insert_run(db_, RunRow()).value_or(0), 2);
    add_samples(2, 5);
  }
  // One commit of the recorder.
  void add_samples(std::int64_t run, int count) const {
    auto transaction = Transaction::begin(db_);
    ASSERT_TRUE(transaction) << transaction.error().what;
    auto chain = ChainWriter::prepare(db_);
    auto writer = RowWriter::prepare(db_, "frame_sample");
    ASSERT_TRUE(chain && writer);
    auto head = chain->head(run);
    ASSERT_TRUE(head);
    RowHash hash;
    hash.start(head->hash);
    for (int i = 0; i < count; ++i) {
      const auto seq = ++head->last_of(RunTable::frame_sample);
      writer->begin(hash).add(run).add(seq).add(seq * 20).add(seq);
      writer->add(std::optional<double>()).add(0.5 * static_cast<double>(seq)).add(0.25);
      writer->add(std::int64_t{0});
      ASSERT_TRUE(writer->insert());
    }
    ASSERT_TRUE(chain->append(*head, hash));
    ASSERT_TRUE(transaction->commit());
  }
  std::set<std::string> files() const {
    std::set<std::string> out;
    for (const auto& entry : fs::directory_iterator(dir_.path())) {
      out.insert(entry.path().filename().string());
    }
    return out;
  }
  static std::int64_t samples_in(const std::string& file, std::int64_t run) {
    const auto db = open_read_only(file).value();
    return db.integer("SELECT count(*) FROM frame_sample WHERE run_id = " + std::to_string(run))
        .value();
  }

  TempDir dir_;
  std::string path_ = dir_.file("rig.db"), copy_ = dir_.file("copy.db");
  Database db_;
};

TEST_F(Backup, HoldsEveryRunAndIsChecked) {
  auto expected = files();
  expected.insert("copy.db");
  const auto report = copy_database(path_, copy_);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->runs, 2);
  EXPECT_GT(report->rows, 30'005);
  EXPECT_THAT(report->without_end, ElementsAre(2));
  EXPECT_THAT(report->broken, IsEmpty());
  EXPECT_EQ(report->bytes, static_cast<std::int64_t>(fs::file_size(copy_)));
  EXPECT_EQ(files(), expected);
  EXPECT_EQ(samples_in(copy_, 1), 30'000);
  EXPECT_TRUE(verify_chain(open_read_only(copy_).value(), 1)->intact);
}

// The writer does not wait, and the copy does not start again with each of its commits.
TEST_F(Backup, IsOneStateWhileARunGoesOn) {
  int asked = 0;
  CopyOptions options;
  options.goes_on = [&] {
    if (samples_in(path_, 2) < 5 + 300) add_samples(2, 10);
    return ++asked < 1000;
  };
  const auto report = copy_database(path_, copy_, options);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_GT(samples_in(path_, 2), 5 + 30);
  EXPECT_EQ(samples_in(copy_, 2), 5) << "the state when it began";
}

TEST_F(Backup, OverwritesNothingAndLeavesNothing) {
  fs::create_directory(dir_.file("folder"));
  fs::create_hard_link(path_, dir_.file("again.db"));
  fs::create_symlink("rig.db", dir_.file("link.db"));
  fs::create_symlink("nowhere.db", dir_.file("dangling.db"));
  std::ofstream(dir_.file("other.db")) << "precious";
  std::ofstream(dir_.file("old.db-wal")) << "of an older one";
  ASSERT_EQ(::mkfifo(dir_.file("pipe").c_str(), 0600), 0);
  fs::remove(path_ + ".lock");
  const auto before = files();
  const std::pair<const char*, const char*> places[] = {
      {"rig.db", "is the database itself"},
      {"again.db", "is the database itself"},
      {"link.db", "is the database itself"},
      {"folder", "is a folder"},
      {"folder/", "a folder"},
      {"pipe", "a pipe or a device"},
      {"dangling.db", "is there already"},
      {"other.db", "is there already"},
      {"rig.db.lock", "belongs to the database"},
      {"other.db-wal", "takes a file of this name for a log"},
      {"none.db-journal", "takes a file of this name for a log"},
      {"old.db", "old.db-wal: the log of a database"},
      {"none/copy.db", "make the folder first"}};
  for (const auto& [place, words] : places) {
    const auto report = copy_database(path_, dir_.file(place));
    ASSERT_FALSE(report) << place;
    EXPECT_THAT(report.error().what, HasSubstr(words)) << place;
    EXPECT_EQ(files(), before) << place;
  }
  EXPECT_EQ(fs::file_size(dir_.file("other.db")), 8U);
}

TEST_F(Backup, GivesUpOnAFullDisk) {
  const auto before = files();
  FaultyDisk disk;
  disk.fail_operation(3, FaultyDisk::Failure::full);
  CopyOptions options;
  options.vfs = disk.name();
  const auto report = copy_database(path_, copy_, options);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().what, HasSubstr("no space is left"));
  EXPECT_EQ(files(), before);
}

TEST_F(Backup, EndsWhenItIsStoppedAtAnyInstant) {
  const auto before = files();
  int most = 0;
  for (int last = 1; most == 0; ++last) {
    ASSERT_LT(last, 1000);
    int asked = 0;
    CopyOptions options;
    options.goes_on = [&] { return ++asked != last; };
    const auto report = copy_database(path_, copy_, options);
    if (report) {
      most = last;
      continue;
    }
    EXPECT_EQ(report.error().code, Errc::aborted) << report.error().what;
    EXPECT_EQ(files(), before);
  }
  EXPECT_GT(most, 3);
}

TEST_F(Backup, OfADamagedDatabaseIsNotKept) {
  ASSERT_TRUE(db_.execute("PRAGMA wal_checkpoint(TRUNCATE)"));
  {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(path_) / 2 / 4096 * 4096));
    file << std::string(4096, '\x55');
  }
  const auto before = files();
  for (const bool first : {false, true}) {
    CopyOptions options;
    options.check_original = first;
    const auto report = copy_database(path_, copy_, options);
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().what, HasSubstr("rig.db: is damaged"));
    EXPECT_EQ(files(), before);
  }
}

TEST_F(Backup, KeepsAndTellsARunThatSomebodyChanged) {
  ASSERT_TRUE(
      db_.execute("DROP TRIGGER frame_sample_no_update;"
                  "UPDATE frame_sample SET force_N = 9 WHERE run_id = 1 AND seq = 7"));
  const auto report = copy_database(path_, copy_);
  ASSERT_TRUE(report) << report.error().what;
  ASSERT_EQ(report->broken.size(), 1U);
  EXPECT_EQ(report->broken[0].run, 1);
  EXPECT_THAT(report->broken[0].finding, HasSubstr("a value was changed"));
  EXPECT_TRUE(fs::exists(copy_));
}

}  // namespace
}  // namespace lcrig
