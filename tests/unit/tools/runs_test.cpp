// SPDX-License-Identifier: Apache-2.0
// Commands that work on recorded runs.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Runs : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.variables["LCRIG_DB"] = path;
    auto db = open_read_write(path);
    ASSERT_TRUE(db) << db.error().what;
    RunRow row;
    row.protocol_name = "press";
    row.protocol_text = "{}";
    row.specimen_name = "paper-1";
    row.specimen_text = "{}";
    row.operator_name = "Ada";
    row.simulated = true;
    row.started_unix_ns = 1'767'225'600'000'000'000;  // 2026-01-01
    auto run = insert_run(*db, row);
    ASSERT_TRUE(run) << run.error().what;
    ASSERT_EQ(*run, 1);
    RunEnd end;
    end.status = ExitStatus::abort;
    end.reason = "smoke";
    end.ended_unix_ns = row.started_unix_ns + 5'000'000'000;
    ASSERT_TRUE(insert_run_end(*db, 1, end));
    row.protocol_name = "open-end";
    ASSERT_TRUE(insert_run(*db, row));
  }
  support::Cli cli;
  std::string path = cli.dir.file("runs.db");
};

TEST_F(Runs, AreListedWithAndWithoutTheVerb) {
  ASSERT_EQ(cli.run({"runs"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("press"), HasSubstr("abort"), HasSubstr("simulated"),
                                   HasSubstr("2026-01-01T00:00:00Z")));
  ASSERT_EQ(cli.run({"runs", "list", "--json"}), 0);
  const auto runs = json::parse(cli.out.str())["runs"];
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0]["exit_status"], nullptr);  // newest first; it goes on
  EXPECT_EQ(runs[1]["exit_status"], "abort");
  EXPECT_EQ(runs[1]["ended"], "2026-01-01T00:00:05Z");
}

TEST_F(Runs, AreShownWithTheirNotes) {
  ASSERT_EQ(cli.run({"runs", "note", "1", "probe was dusty"}), 0) << cli.err.str();
  ASSERT_EQ(cli.run({"runs", "show", "1", "--json"}), 0) << cli.err.str();
  const auto run = json::parse(cli.out.str());
  EXPECT_EQ(run["operator"], "Ada");
  ASSERT_EQ(run["notes"].size(), 1U);
  EXPECT_EQ(run["notes"][0]["text"], "probe was dusty");
  EXPECT_EQ(run["notes"][0]["operator"], login_name());
}

TEST_F(Runs, ThatGoOnTakeNoNote) {
  EXPECT_EQ(cli.run({"runs", "note", "last", "x"}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("still going on"));
}

TEST_F(Runs, ThatDoNotExistAreRefusedByEveryCommand) {
  for (const auto& args : {std::vector<std::string>{"runs", "show", "99"},
                           {"runs", "note", "99", "x"},
                           {"export", "99", "-o", cli.dir.file("out")},
                           {"analyze", "99"},
                           {"verify", "99"},
                           {"verify", "first"}}) {
    EXPECT_EQ(cli.run(args), kFailed) << ::testing::PrintToString(args);
    EXPECT_THAT(cli.err.str(), HasSubstr("lcrig runs"));
  }
  EXPECT_FALSE(std::filesystem::exists(cli.dir.file("out")));
}

TEST_F(Runs, AreExportedToAFolder) {
  const auto folder = cli.dir.file("out");
  ASSERT_EQ(cli.run({"export", "1", "-o", folder, "--json"}), 0) << cli.err.str();
  EXPECT_TRUE(std::filesystem::exists(folder + "/lcr.csv"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/datapackage.json"));
  EXPECT_EQ(json::parse(cli.out.str())["run"], 1);
}

TEST_F(Runs, TheLastOneIsMeantWhereNoneIsNamed) {
  ASSERT_EQ(cli.run({"verify", "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["run"], 2);
  ASSERT_EQ(cli.run({"export", "-o", cli.dir.file("newest"), "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["run"], 2);
}

TEST_F(Runs, AreVerified) {
  ASSERT_EQ(cli.run({"verify", "1", "--json"}), 0) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["intact"], true);
  {
    auto db = Database::open(path, Database::Mode::read_write_create);
    ASSERT_TRUE(db);
    ASSERT_TRUE(db->execute("DROP TRIGGER run_end_no_update; UPDATE run_end SET reason = 'fine'"));
  }
  EXPECT_EQ(cli.run({"verify", "1"}), kFailed);
}

}  // namespace
}  // namespace lcrig::cli
