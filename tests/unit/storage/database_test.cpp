// SPDX-License-Identifier: Apache-2.0
#include "storage/database.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <span>
#include <sstream>

#include "storage/chain.hpp"
#include "storage/migrations.hpp"
#include "storage/runs.hpp"
#include "tests/support/old_run.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/without_rights.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

Database raw(const std::string& path) {
  auto db = Database::open(path, Database::Mode::read_write_create);
  EXPECT_TRUE(db) << db.error().what;
  return std::move(*db);
}

std::int64_t integer(const Database& db, std::string_view sql) {
  auto r = db.integer(sql);
  EXPECT_TRUE(r) << r.error().what;
  return r.value_or(-1);
}

TEST(OpenReadWrite, CreatesADurableDatabaseOfOurs) {
  TempDir dir;
  auto db = open_read_write(dir.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  EXPECT_EQ(integer(*db, "PRAGMA application_id"), kApplicationId);
  EXPECT_EQ(integer(*db, "PRAGMA user_version"), shipped_migrations().back().version);
  EXPECT_EQ(integer(*db, "PRAGMA synchronous"), 2);
  EXPECT_EQ(integer(*db, "PRAGMA foreign_keys"), 1);
  EXPECT_EQ(integer(*db, "SELECT journal_mode = 'wal' FROM pragma_journal_mode"), 1);
  EXPECT_EQ(integer(*db,
                    "SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND"
                    " type = 'table' AND name NOT LIKE 'sqlite_%' AND NOT strict"),
            0);
}

// debian/lcrig.preinst reads these four bytes, also after the daemon was killed.
TEST(OpenReadWrite, TheHeaderOfTheFileTellsTheSchemaWhileItIsOpen) {
  TempDir dir;
  const auto db = open_read_write(dir.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  std::ifstream file(dir.file("a.db"), std::ios::binary);
  std::array<char, 100> header{};
  file.read(header.data(), header.size());
  EXPECT_TRUE(file);
  int schema = 0;
  for (const char byte : std::span(header).subspan(60, 4)) {
    schema = schema * 256 + static_cast<unsigned char>(byte);
  }
  EXPECT_EQ(schema, shipped_migrations().back().version);
}

// The state after a daemon was killed: the run is only in the log.
class LogWithoutItsDatabase : public testing::Test {
 protected:
  void SetUp() override {
    const auto db = open_read_write(dir_.file("there.db")).value();
    ASSERT_TRUE(db.execute("PRAGMA wal_checkpoint(TRUNCATE)"));
    ASSERT_TRUE(insert_run(db, RunRow()));
    std::filesystem::copy_file(dir_.file("there.db"), moved_);
    std::filesystem::copy_file(dir_.file("there.db-wal"), path_ + "-wal");
    log_bytes_ = std::filesystem::file_size(path_ + "-wal");
    ASSERT_GT(log_bytes_, 0U);
  }
  void expect_refused() {
    for (const auto open : {open_read_write, open_read_only}) {
      const auto db = open(path_, "");
      ASSERT_FALSE(db);
      EXPECT_THAT(db.error().what, HasSubstr("move the database back beside it"));
      EXPECT_THAT(db.error().what, HasSubstr(path_ + "-wal"));
    }
    EXPECT_EQ(std::filesystem::file_size(path_ + "-wal"), log_bytes_);
  }

  TempDir dir_;
  std::string path_ = dir_.file("a.db"), moved_ = dir_.file("moved.db");
  std::uintmax_t log_bytes_ = 0;
};

TEST_F(LogWithoutItsDatabase, IsNotEmptiedByANewDatabase) {
  expect_refused();
  EXPECT_FALSE(std::filesystem::exists(path_));
  std::filesystem::rename(moved_, path_);
  const auto db = open_read_write(path_);
  ASSERT_TRUE(db) << db.error().what;
  EXPECT_EQ(integer(*db, "SELECT count(*) FROM run"), 1);
}

TEST_F(LogWithoutItsDatabase, IsNotEmptiedBesideAnEmptyFile) {
  std::ofstream(path_).close();
  expect_refused();
}

// Until the file exists its log and its lock would have other names than afterwards.
TEST(OpenReadWrite, RefusesALinkToNothing) {
  const TempDir dir;
  std::filesystem::create_symlink("none.db", dir.file("a.db"));
  const auto db = open_read_write(dir.file("a.db"));
  ASSERT_FALSE(db);
  EXPECT_THAT(db.error().what, HasSubstr("a link to nothing (none.db)"));
  EXPECT_FALSE(std::filesystem::exists(dir.file("none.db")));
}

TEST(InMemory, IsSharedByItsPathAndGoneWithTheLastConnection) {
  TempDir dir;
  const std::string path = dir.file("a.db");
  {
    const auto db = open_read_write(path, kInMemory);
    ASSERT_TRUE(db) << db.error().what;
    EXPECT_EQ(integer(*db, "PRAGMA user_version"), shipped_migrations().back().version);
    const auto reader = open_read_only(path, kInMemory);
    ASSERT_TRUE(reader) << reader.error().what;
    EXPECT_EQ(reader->vfs(), kInMemory);
    EXPECT_GT(integer(*reader, "SELECT count(*) FROM sqlite_schema"), 0);
    EXPECT_FALSE(open_read_only(dir.file("b.db"), kInMemory)) << "another path is another one";
  }
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
  EXPECT_FALSE(open_read_only(path, kInMemory));
}

TEST(OpenReadWrite, RefusesAFileThatIsNoDatabase) {
  TempDir dir;
  std::ofstream(dir.file("a.db")) << std::string(4096, 'x');
  auto db = open_read_write(dir.file("a.db"));
  ASSERT_FALSE(db);
  EXPECT_EQ(db.error().code, Errc::invalid_request);
  EXPECT_THAT(db.error().what,
              ::testing::EndsWith("a.db: is not a database, or its beginning is damaged (26)"));
}

TEST(OpenReadWrite, RefusesAnotherProgramsDatabaseUnchanged) {
  TempDir dir;
  ASSERT_TRUE(raw(dir.file("a.db")).execute("CREATE TABLE song (title TEXT)"));
  auto db = open_read_write(dir.file("a.db"));
  ASSERT_FALSE(db);
  EXPECT_THAT(db.error().what, HasSubstr("another program"));
  const Database after = raw(dir.file("a.db"));
  EXPECT_EQ(integer(after, "SELECT count(*) FROM sqlite_schema"), 1);
  EXPECT_EQ(integer(after, "PRAGMA application_id"), 0);
}

TEST(OpenReadWrite, RefusesANewerSchema) {
  TempDir dir;
  ASSERT_TRUE(open_read_write(dir.file("a.db")));
  ASSERT_TRUE(raw(dir.file("a.db")).execute("PRAGMA user_version = 9999"));
  for (const auto& db : {open_read_write(dir.file("a.db")), open_read_only(dir.file("a.db"))}) {
    ASSERT_FALSE(db);
    EXPECT_EQ(db.error().code, Errc::invalid_request);
    EXPECT_THAT(db.error().what, HasSubstr("newer"));
  }
}

TEST(OpenReadWrite, RefusesAFolderThatDoesNotExist) {
  auto db = open_read_write("/nowhere/a.db");
  ASSERT_FALSE(db);
  EXPECT_EQ(db.error().code, Errc::io);
  EXPECT_THAT(db.error().what, HasSubstr("/nowhere/a.db"));
}

TEST(OpenReadWrite, RefusesAFolderThatIsNotWritable) {
  TempDir dir;
  ::chmod(dir.path().c_str(), 0500);
  const WithoutFileRights like_anybody;
  auto db = open_read_write(dir.file("a.db"));
  ::chmod(dir.path().c_str(), 0700);
  ASSERT_FALSE(db);
  EXPECT_EQ(db.error().code, Errc::io);
}

TEST(OpenReadOnly, RefusesAMissingAndAnEmptyFile) {
  TempDir dir;
  EXPECT_THAT(open_read_only(dir.file("a.db")).error().what, HasSubstr("no such database"));
  EXPECT_FALSE(std::filesystem::exists(dir.file("a.db")));
  std::ofstream(dir.file("b.db")).flush();
  EXPECT_THAT(open_read_only(dir.file("b.db")).error().what, HasSubstr("empty"));
}

// As in an archive, the file may not be written to bring it up to date.
TEST(OpenReadOnly, ReadsADatabaseOfTheFirstSchema) {
  TempDir dir;
  {
    const auto db = raw(dir.file("a.db"));
    ASSERT_TRUE(migrate(db, shipped_migrations().first(1)));
  }
  const auto db = open_read_only(dir.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  EXPECT_EQ(integer(*db, "PRAGMA user_version"), 1);
  EXPECT_EQ(integer(*db, "SELECT count(*) FROM run"), 0);
}

// Names and sizes of what is in a folder.
std::map<std::string, std::uintmax_t> files_in(const std::string& folder) {
  std::map<std::string, std::uintmax_t> out;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    out[file.path().filename()] = file.file_size();
  }
  return out;
}

TEST(OpenReadWrite, LeavesAnEmptyLogAndItsIndexForReaders) {
  TempDir dir;
  ASSERT_TRUE(open_read_write(dir.file("a.db")));
  const auto left = files_in(dir.path());
  EXPECT_EQ(left.size(), 3U);
  EXPECT_EQ(left.at("a.db-wal"), 0U) << "a copy of the file alone must be whole";
  EXPECT_TRUE(left.contains("a.db-shm"));
}

// After a crash, for a copy or for an old file: what is there is read, and nothing is created.
TEST(OpenReadOnly, NeedsNoneOfTheFilesBesideTheDatabaseButReadsTheLog) {
  TempDir dir;
  const std::string path = dir.file("a.db");
  const auto writer = open_read_write(path);
  ASSERT_TRUE(writer->execute("INSERT INTO specimen VALUES (1, 'in the log', 1, '" +
                              std::string(64, '0') + "', '', 1)"));
  for (const auto& [with, rows] : std::vector<std::pair<std::vector<std::string>, std::int64_t>>{
           {{"", "-wal", "-shm"}, 1}, {{"", "-wal"}, 1}}) {
    const TempDir copy;
    for (const auto& file : with) {
      std::filesystem::copy_file(path + file, copy.file("a.db" + file));
    }
    const auto before = files_in(copy.path());
    {
      const auto db = open_read_only(copy.file("a.db"));
      ASSERT_TRUE(db) << db.error().what;
      EXPECT_EQ(integer(*db, "SELECT count(*) FROM specimen"), rows) << with.size();
      const auto second = open_read_only(copy.file("a.db"));
      ASSERT_TRUE(second) << second.error().what;
      EXPECT_EQ(integer(*second, "SELECT count(*) FROM specimen"), rows) << with.size();
    }
    EXPECT_EQ(files_in(copy.path()), before) << with.size();
  }
}

TEST(OpenReadOnly, ReadsAFileThatIsThereAlone) {
  TempDir dir, copy;
  ASSERT_TRUE(open_read_write(dir.file("a.db")));
  std::filesystem::copy_file(dir.file("a.db"), copy.file("a.db"));
  const auto before = files_in(copy.path());
  const auto db = open_read_only(copy.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  EXPECT_EQ(integer(*db, "SELECT count(*) FROM run"), 0);
  EXPECT_EQ(files_in(copy.path()), before);
}

TEST(OpenReadOnly, SaysWhoMayReadAFileThatIsOfOthers) {
  TempDir dir;
  ASSERT_TRUE(open_read_write(dir.file("a.db")));
  ::chmod(dir.file("a.db").c_str(), 0);
  const WithoutFileRights like_anybody;
  const auto db = open_read_only(dir.file("a.db"));
  ASSERT_FALSE(db);
  EXPECT_THAT(db.error().what, HasSubstr("its folder"));
}

TEST(OpenReadOnly, DoesNotWrite) {
  TempDir dir;
  ASSERT_TRUE(open_read_write(dir.file("a.db")));
  auto db = open_read_only(dir.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  EXPECT_FALSE(db->execute("CREATE TABLE t (x INTEGER)"));
}

// The table of ends is made anew with the same rows, because a chain of hashes covers them.
TEST(Migrate, EndsOfRunsStayAsTheyWereWhenTheirWordsBecomeMore) {
  TempDir dir;
  const std::string path = dir.file("a.db");
  const auto all = shipped_migrations();
  const auto stopped = std::ranges::find_if(
      all, [](const Migration& m) { return m.name.ends_with("_stopped.sql"); });
  ASSERT_NE(stopped, all.end());
  {
    const auto db = raw(path);
    ASSERT_TRUE(migrate(db, all.first(static_cast<std::size_t>(stopped - all.begin()))));
    support::insert_old_run(db, 1);
    RunEnd end;
    end.status = ExitStatus::abort;
    end.reason = "wrong specimen";
    ASSERT_TRUE(insert_run_end(db, 1, end));
    support::insert_old_run(db, 2);
    end.status = ExitStatus::stopped;
    EXPECT_FALSE(insert_run_end(db, 2, end)) << "a word that it does not know";
  }
  const auto db = open_read_write(path).value();
  EXPECT_EQ(integer(db,
                    "SELECT count(*) FROM v_run WHERE exit_status = 'abort' AND reason = "
                    "'wrong specimen'"),
            1);
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
  RunEnd end;
  end.status = ExitStatus::stopped;
  EXPECT_TRUE(insert_run_end(db, 2, end));
  EXPECT_EQ(get_run_listing(db, 2).value().exit_status, ExitStatus::stopped);
  EXPECT_FALSE(db.execute("DELETE FROM run_end"));
  EXPECT_FALSE(db.execute("UPDATE run_end SET reason = ''"));
}

TEST(Migrate, AFailingMigrationRollsBackWithItsVersion) {
  TempDir dir;
  const Database db = raw(dir.file("a.db"));
  const Migration migrations[] = {
      {1, "0001_good.sql", "CREATE TABLE a (x INTEGER) STRICT;"},
      {2, "0002_bad.sql", "CREATE TABLE b (x INTEGER) STRICT; INSERT INTO nowhere VALUES (1);"}};
  auto r = migrate(db, migrations);
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().what, HasSubstr("0002_bad.sql"));
  EXPECT_EQ(integer(db, "PRAGMA user_version"), 1);
  EXPECT_EQ(integer(db, "SELECT count(*) FROM sqlite_schema WHERE name = 'a'"), 1);
  EXPECT_EQ(integer(db, "SELECT count(*) FROM sqlite_schema WHERE name = 'b'"), 0);
  EXPECT_FALSE(db.in_transaction());
}

TEST(Migrate, RunsOnlyWhatIsMissing) {
  TempDir dir;
  const Database db = raw(dir.file("a.db"));
  const Migration migrations[] = {{1, "0001_a.sql", "CREATE TABLE a (x INTEGER) STRICT;"},
                                  {2, "0002_b.sql", "CREATE TABLE b (x INTEGER) STRICT;"}};
  ASSERT_TRUE(migrate(db, std::span(migrations).first(1)));
  ASSERT_TRUE(migrate(db, migrations));
  ASSERT_TRUE(migrate(db, migrations));
  EXPECT_EQ(integer(db, "PRAGMA user_version"), 2);
}

TEST(Migrate, IsToldAlsoWhereOnlyWarningsAre) {
  TempDir dir;
  constexpr std::size_t kOld = 8;
  ASSERT_TRUE(migrate(raw(dir.file("old.db")), shipped_migrations().first(kOld)));
  std::ostringstream said;
  const auto logger = std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(said));
  logger->set_level(spdlog::level::warn);
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(logger);
  const bool opened = open_read_write(dir.file("new.db")) && open_read_write(dir.file("old.db"));
  const bool again = open_read_write(dir.file("old.db")).has_value();
  spdlog::set_default_logger(before);
  EXPECT_TRUE(opened && again);
  EXPECT_THAT(said.str(), HasSubstr(fmt::format("old.db: schema {} -> {}", kOld,
                                                shipped_migrations().back().version)));
  EXPECT_EQ(std::ranges::count(said.str(), '\n'), 1) << said.str();
}

TEST(Transaction, RollsBackWhatIsNotCommitted) {
  TempDir dir;
  const Database db = raw(dir.file("a.db"));
  ASSERT_TRUE(db.execute("CREATE TABLE a (x INTEGER) STRICT"));
  {
    auto t = Transaction::begin(db);
    ASSERT_TRUE(t);
    ASSERT_TRUE(db.execute("INSERT INTO a VALUES (1)"));
  }
  EXPECT_EQ(integer(db, "SELECT count(*) FROM a"), 0);
  EXPECT_FALSE(db.in_transaction());
}

// SQLite would take each of these names for the address of another file, of memory, or of nothing.
TEST(DatabaseNames, AreNamesOfFilesWhateverTheyLookLike) {
  const TempDir dir;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(dir.path());
  for (const std::string name : {"file:victim.db?x=", "file:victim.db?mode=memory", ":memory:"}) {
    {
      const auto made = open_read_write(name);
      ASSERT_TRUE(made) << made.error().what;
    }
    EXPECT_TRUE(std::filesystem::exists("./" + name)) << name;
    EXPECT_TRUE(open_read_only(name)) << name;
  }
  EXPECT_FALSE(std::filesystem::exists("victim.db"));
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace lcrig
