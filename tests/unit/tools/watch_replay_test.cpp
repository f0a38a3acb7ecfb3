// SPDX-License-Identifier: Apache-2.0
// `lcrig watch replay`: a stored run is judged again, and what is found is compared.
#include <gmock/gmock.h>
#include <sqlite3.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "protocols/checks/check.hpp"
#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tools/lcrig/watch_checks.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
namespace fs = std::filesystem;

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream out;
  out << file.rdbuf();
  return out.str();
}

// Run 1: honest. Run 2: its load cell freezes while it presses.
class WatchReplayed : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new TempDir();
    rehearse_with("");
    rehearse_with(R"({"format":"faults/1","faults":[{"on":"frame","fault":"force_frozen",
      "in_step":"level","after_s":0.5}]})");
  }
  static void TearDownTestSuite() { delete folder; }
  static void rehearse_with(const std::string& faults) {
    RehearseRequest r;
    r.protocol_name = "static-frame";
    r.protocol_text = text_of("protocols/library/static-frame.json");
    r.specimen_name = "paper-1";
    r.specimen_text = text_of("model/library/paper-1.json");
    r.db_path = folder->file("runs.db");
    r.seed = 7;
    r.parameters = {{"levels", "4"}, {"repeats", "1"}, {"readings", "10"}, {"within_s", "1.5"}};
    r.faults_text = faults;
    const auto result = rehearse(r);
    ASSERT_TRUE(result) << result.error().what;
  }
  json answer(std::vector<std::string> words, int exit_code) {
    words.insert(words.begin(), {"--db", db, "--json", "watch", "replay"});
    EXPECT_EQ(cli.run(words), exit_code) << cli.err.str();
    return json::parse(cli.out.str(), nullptr, false);
  }
  // Changes a stored sample, which the tables forbid.
  void change(const char* sql) {
    db = cli.dir.file("changed.db");
    fs::copy_file(folder->file("runs.db"), db, fs::copy_options::overwrite_existing);
    sqlite3* raw = nullptr;
    ASSERT_EQ(sqlite3_open(db.c_str(), &raw), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(raw, "DROP TRIGGER frame_sample_no_update", nullptr, nullptr, nullptr),
              SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(raw, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(raw);
    sqlite3_close(raw);
  }

  static inline TempDir* folder = nullptr;
  support::Cli cli;
  std::string db = folder->file("runs.db");
};

TEST_F(WatchReplayed, FindsWhatTheRunsRecorded) {
  const json all = answer({"1", "2"}, 0);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["judged"], json::array());
  ASSERT_EQ(all[1]["judged"].size(), 1U);
  EXPECT_THAT(all[1]["judged"][0]["why"].get<std::string>(), HasSubstr("the load cell is frozen"));
  for (const json& run : all) {
    EXPECT_EQ(run["same"], true);
    EXPECT_EQ(run["only"], "");
    EXPECT_GT(run["samples"], 1000);
    EXPECT_GT(run["inputs"], 50);
  }
}

TEST_F(WatchReplayed, SaysItInWords) {
  ASSERT_EQ(cli.run({"--db", db, "watch", "replay", "1", "2"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("inputs: nothing found, as recorded"));
  EXPECT_THAT(cli.out.str(), HasSubstr("inputs: 1 as recorded\n  judged"));
}

TEST_F(WatchReplayed, SeesWhatTheRunDidNot) {
  change("UPDATE frame_sample SET force_N = 9 WHERE run_id = 1 AND seq = 2000");
  const json all = answer({"1"}, 1);
  EXPECT_EQ(all[0]["same"], false);
  EXPECT_EQ(all[0]["recorded"], json::array());
  ASSERT_GE(all[0]["judged"].size(), 1U);
  EXPECT_THAT(all[0]["judged"][0]["why"].get<std::string>(), HasSubstr("9.0000 N"));
  ASSERT_EQ(cli.run({"--db", db, "watch", "replay", "1"}), 1);
  EXPECT_THAT(cli.out.str(), HasSubstr("other findings than recorded"));
}

TEST_F(WatchReplayed, ComparesWithAnotherBuild) {
  const std::string other = cli.dir.file("other");
  const auto says = [&other](const json& judged) {
    std::ofstream(other) << "#!/bin/sh\necho '" << judged.dump() << "'\n";
    fs::permissions(other, fs::perms::owner_all);
  };
  says(answer({"2"}, 0));
  EXPECT_EQ(answer({"2", "--against", other}, 0)[0]["same"], true);
  says({{{"run", 2}, {"judged", json::array()}}});
  const json differs = answer({"2", "--against", other}, 1);
  EXPECT_EQ(differs[0]["there"], json::array());
  EXPECT_EQ(differs[0]["here"].size(), 1U);
  ASSERT_EQ(cli.run({"--db", db, "watch", "replay", "2", "--against", other}), 1);
  EXPECT_THAT(cli.out.str(), HasSubstr("run 2: other findings as " + other));
  says("no list");
  EXPECT_EQ(cli.run({"--db", db, "watch", "replay", "2", "--against", other}), 1);
  EXPECT_THAT(cli.err.str(), HasSubstr("did not judge the runs"));
}

TEST_F(WatchReplayed, OfARunWithoutOrdersSaysWhatWasJudged) {
  db = cli.dir.file("old.db");
  fs::copy_file("tests/old_databases/schema-12.sqlite", db);
  const json all = answer({"1"}, 0);
  EXPECT_THAT(all[0]["only"].get<std::string>(), HasSubstr("it did not store its orders"));
}

TEST_F(WatchReplayed, MistakesAreNamed) {
  EXPECT_EQ(cli.run({"--db", db, "watch", "repaly", "1"}), 2);
  EXPECT_THAT(cli.err.str(), HasSubstr("'repaly' is nothing that watch knows"));
  EXPECT_EQ(cli.run({"--db", db, "watch", "--against", "x"}), 2);
  EXPECT_THAT(cli.err.str(), HasSubstr("--against is for `watch replay`"));
  EXPECT_NE(cli.run({"--db", db, "watch", "replay", "7"}), 0);
}

// Checks and constants stand in one place; the page is their print.
TEST(WatchChecks, ThePageOfTheWatchShowsTheTableOfThisProgram) {
  EXPECT_THAT(text_of("docs/watch.md"), HasSubstr(checks_text()))
      << "docs/watch.md: replace its table by what `lcrig watch checks` prints";
  EXPECT_EQ(checks_json().at("checks").size(), all_checks().size());
}

}  // namespace
}  // namespace lcrig::cli
