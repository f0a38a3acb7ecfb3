// SPDX-License-Identifier: Apache-2.0
// `lcrig backup` and `lcrig restore`. storage/backup_test.cpp tests the copy itself.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"
#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

class BackupCommands : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.variables["LCRIG_DB"] = path;
    const auto db = open_read_write(path);
    ASSERT_TRUE(db) << db.error().what;
    ASSERT_TRUE(insert_run(*db, RunRow()));
    ASSERT_TRUE(insert_run_end(*db, 1, RunEnd()));
  }
  // Changes the database as somebody would who gets around the triggers.
  void change() const {
    const auto db = Database::open(path, Database::Mode::read_write_create);
    ASSERT_TRUE(db);
    ASSERT_TRUE(db->execute("DROP TRIGGER run_end_no_update; UPDATE run_end SET reason = 'fine'"));
  }
  support::Cli cli;
  std::string path = cli.dir.file("runs.db"), copy = cli.dir.file("copy.db"),
              place = cli.dir.file("restored.db");
};

TEST_F(BackupCommands, MakeACopyAndPutItBack) {
  ASSERT_EQ(cli.run({"backup", copy, "--json"}), 0) << cli.err.str();
  const auto made = json::parse(cli.out.str());
  EXPECT_EQ(made["file"].get<std::string>(), copy);
  EXPECT_EQ(made["runs"], 1);
  EXPECT_EQ(made["broken"], json::array());
  EXPECT_EQ(made["without_end"], json::array());
  ASSERT_EQ(cli.run({"restore", copy, "--to", place}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("restored.db"), HasSubstr("1 runs")));
  EXPECT_EQ(cli.run({"verify", "1", "--db", place}), 0) << cli.err.str();
}

TEST_F(BackupCommands, OverwriteNothing) {
  ASSERT_EQ(cli.run({"backup", copy}), 0) << cli.err.str();
  EXPECT_EQ(cli.run({"backup", copy}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("is there already"));
  EXPECT_EQ(cli.run({"restore", copy, "--to", path}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("is there already"));
  EXPECT_EQ(cli.run({"restore", copy}), kUsage);
}

// Also tested when somebody has removed the file under the daemon.
TEST_F(BackupCommands, RestoreNothingUnderADaemon) {
  ASSERT_EQ(cli.run({"backup", copy}), 0) << cli.err.str();
  {
    const auto lock = WriterLock::acquire(place);
    ASSERT_TRUE(lock) << lock.error().what;
    EXPECT_EQ(cli.run({"restore", copy, "--to", place}), kFailed);
    EXPECT_THAT(cli.err.str(),
                AllOf(HasSubstr("a daemon records into it"), HasSubstr("systemctl stop lcrigd")));
    EXPECT_FALSE(fs::exists(place));
  }
  EXPECT_EQ(cli.run({"restore", copy, "--to", place}), 0) << cli.err.str();
}

TEST_F(BackupCommands, TellARunThatSomebodyChanged) {
  change();
  EXPECT_EQ(cli.run({"backup", copy}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("run 1 is not as it was recorded"));
  EXPECT_TRUE(fs::exists(copy));
}

TEST_F(BackupCommands, RestoreNothingThatIsNoBackup) {
  std::ofstream(copy) << std::string(8192, 'x');
  EXPECT_EQ(cli.run({"restore", copy, "--to", place}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("is not a database"));
  EXPECT_EQ(cli.run({"restore", cli.dir.file("none.db"), "--to", place}), kFailed);
  EXPECT_FALSE(fs::exists(place));
}

}  // namespace
}  // namespace lcrig::cli
