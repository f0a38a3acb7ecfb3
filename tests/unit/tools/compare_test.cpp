// SPDX-License-Identifier: Apache-2.0
// `lcrig compare` on rehearsed runs: what it says, and its exit code.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

void rehearsed(RehearseRequest request, const std::string& protocol, const std::string& specimen) {
  request.protocol_name = protocol;
  request.protocol_text = read_text_file("protocols/library/" + protocol + ".json").value();
  request.specimen_name = specimen;
  request.specimen_text = read_text_file("model/library/" + specimen + ".json").value();
  const auto done = rehearse(request);
  ASSERT_TRUE(done) << done.error().what;
}

// Runs 1 and 2: the same static protocol on two specimens. Run 3: cycles on the first of them.
class CompareRuns : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new TempDir();
    db = folder->file("runs.db");
    RehearseRequest request;
    request.db_path = db;
    request.seed = 7;
    request.parameters = {
        {"levels", "8"}, {"repeats", "3"}, {"readings", "10"}, {"within_s", "1.5"}};
    for (const char* specimen : {"paper-1", "paper-2"})
      rehearsed(request, "static-frame", specimen);
    request.parameters = {{"cycles", "3"}, {"gap_mm", "0.1"}};
    rehearsed(request, "dynamic-cycles", "paper-1");
  }
  static void TearDownTestSuite() {
    delete folder;
    folder = nullptr;
  }

  static inline TempDir* folder = nullptr;
  static inline std::string db;
  support::Cli cli;
};

TEST_F(CompareRuns, EndsWithASentenceThatCanBeQuoted) {
  ASSERT_EQ(cli.run({"--db", db, "compare", "1", "2", "--range", "0:30"}), 0)
      << cli.out.str() << cli.err.str();
  EXPECT_THAT(cli.out.str(), testing::ContainsRegex(
                                 "\npaper-2 \\(simulated\\) is [0-9.]+ to [0-9.]+ times as "
                                 "sensitive as paper-1 \\(simulated\\) in 0-30 kPa, same probe, "
                                 "same load cell, same meter, loading branch \\(95 %\\)"));
  EXPECT_THAT(cli.out.str(), HasSubstr("same: meter LCR-6100 SIM000001, load cell SIM-CELL-20, "
                                       "probe SIM-PROBE-4"));
}

TEST_F(CompareRuns, UnlikeRunsFailAndSayWhatToDo) {
  EXPECT_EQ(cli.run({"--db", db, "compare", "1", "3"}), 1);
  EXPECT_THAT(cli.out.str(),
              AllOf(HasSubstr("run 1 holds each load, run 3 measures while the load grows"),
                    HasSubstr("to compare them: measure both with one protocol"),
                    HasSubstr("the C0 of paper-1 in run 3 (simulated) is")));
  EXPECT_EQ(cli.run({"--db", db, "compare", "1", "3", "--json"}), 1);
  const json out = json::parse(cli.out.str());
  ASSERT_EQ(out["comparisons"].size(), out["verdicts"].size());
  EXPECT_THAT(out["comparisons"][0]["refused"].get<std::string>(), HasSubstr("holds each load"));
}

TEST_F(CompareRuns, AnalyzeAndTheReportObeyTheSameRules) {
  ASSERT_EQ(cli.run({"--db", db, "compare", "1", "3", "--json"}), 1);
  const json compared = json::parse(cli.out.str())["comparisons"];
  ASSERT_EQ(cli.run({"--db", db, "analyze", "1", "3", "--json"}), 0);
  EXPECT_EQ(json::parse(cli.out.str())["comparisons"], compared);
  ASSERT_EQ(cli.run({"--db", db, "report", "1", "3", "-o", "-"}), 0);
  EXPECT_THAT(cli.out.str(), HasSubstr("run 1 holds each load, run 3 measures while"));
}

TEST_F(CompareRuns, OneRunIsNotEnough) {
  EXPECT_EQ(cli.run({"--db", db, "compare", "1"}), 2);
  EXPECT_THAT(cli.err.str(), HasSubstr("expected two or more"));
}

TEST_F(CompareRuns, ACopyKeepsWhatTheRunsProve) {
  const std::string copy = cli.dir.file("copy.db");
  ASSERT_EQ(cli.run({"--db", db, "runs", "copy", "1", "2", "--to", copy}), 0) << cli.err.str();
  ASSERT_EQ(cli.run({"--db", db, "compare", "1", "2", "--json"}), 0);
  const std::string before = cli.out.str();
  ASSERT_EQ(cli.run({"--db", copy, "compare", "1", "2", "--json"}), 0);
  EXPECT_EQ(cli.out.str(), before);
}

TEST_F(CompareRuns, ARunWithItselfIsRefusedInWords) {
  EXPECT_EQ(cli.run({"--db", db, "compare", "1", "1"}), 1);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("both are run 1"), Not(HasSubstr("times as"))));
}

// A database that lcrig wrote before probe and load cell had a name.
class CompareWithOldRuns : public CompareRuns, public testing::WithParamInterface<int> {};

TEST_P(CompareWithOldRuns, ARunOfAnOldSchemaSharesNothing) {
  const std::string old = cli.dir.file("old.db"), both = cli.dir.file("both.db");
  std::filesystem::copy_file("tests/old_databases/schema-" + std::to_string(GetParam()) + ".sqlite",
                             old);
  std::filesystem::permissions(old, std::filesystem::perms::owner_write,
                               std::filesystem::perm_options::add);
  ASSERT_TRUE(open_read_write(old));  // brings its schema up to date
  ASSERT_EQ(cli.run({"--db", db, "runs", "copy", "1", "--to", both}), 0) << cli.err.str();
  ASSERT_EQ(cli.run({"--db", old, "runs", "copy", "1", "--to", both}), 0) << cli.err.str();
  cli.run({"--db", both, "compare", "1", "2", "--json"});
  const json comparisons = json::parse(cli.out.str())["comparisons"];
  bool answered = false;
  for (const json& c : comparisons) {
    // Since schema 10 there are the meter's corrections, so the runs prove which meter it was.
    const std::string shared = c["shared"].dump();
    EXPECT_TRUE(shared == "[]" || (GetParam() >= 10 && shared.starts_with("[\"meter"))) << c;
    EXPECT_THAT(shared, Not(testing::AnyOf(HasSubstr("load cell"), HasSubstr("probe"))));
    answered = answered || c["refused"].is_null();
  }
  EXPECT_TRUE(answered) << comparisons;
}
INSTANTIATE_TEST_SUITE_P(All, CompareWithOldRuns, testing::Values(8, 9, 10, 12));

}  // namespace
}  // namespace lcrig::cli
