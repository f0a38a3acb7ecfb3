// SPDX-License-Identifier: Apache-2.0
// What completion proposes from the database. What the shells make of it: tests/shell/completion.
#include <gmock/gmock.h>

#include "storage/database.hpp"
#include "storage/queue.hpp"
#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

class Completion : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.variables["LCRIG_DB"] = cli.dir.file("a.db");
    auto db = open_read_write(cli.dir.file("a.db"));
    ASSERT_TRUE(db) << db.error().what;
    std::vector<QueuedRun> runs(2);
    for (auto& run : runs) {
      run.protocol_name = "press";
      run.specimen_name = "paper-1";
      run.protocol_text = run.specimen_text = run.parameters_json = run.plan_json = "{}";
    }
    ASSERT_TRUE(add_to_queue(*db, runs, QueuePlace(), QueueActor()));
  }
  std::string offered(std::vector<std::string> words) {
    words.insert(words.begin(), {"__complete", "--"});
    EXPECT_EQ(cli.run(words), 0);
    return cli.out.str();
  }
  support::Cli cli;
};

TEST_F(Completion, ProposesTheEntriesOfTheQueue) {
  const std::string entries = "none\n1\tpress on paper-1\n2\tpress on paper-1\n";
  EXPECT_EQ(offered({"queue", "show", ""}), entries);
  EXPECT_EQ(offered({"queue", "move", ""}), entries);
  EXPECT_EQ(offered({"queue", "remove", ""}), entries);
  EXPECT_EQ(offered({"queue", "move", "2", "--before", ""}), entries);
  EXPECT_EQ(offered({"queue", "history", "--entry", ""}), entries);
  EXPECT_EQ(offered({"queue", "show", "--db", cli.dir.file("none.db"), ""}), "none\n");
}

TEST_F(Completion, SaysWhatGroupsKnowAndNothingBehindUnknownWords) {
  using ::testing::HasSubstr;
  const auto all = offered({""});
  EXPECT_THAT(all, HasSubstr("\nconfig\tcheck, show\n"));
  EXPECT_THAT(all, HasSubstr("\nlcr\tcorrect, show\n"));
  EXPECT_EQ(offered({"help", ""}), all);
  EXPECT_EQ(offered({"bogus", ""}), "none\n");
  EXPECT_EQ(offered({"queue", "bogus", ""}), "none\n");
  EXPECT_THAT(offered({"queue", ""}), HasSubstr("\nhold\t"));
}

TEST_F(Completion, ProposesNothingWhereAnythingMayStand) {
  EXPECT_EQ(offered({"run", "press", "--note", ""}), "none\n");
  EXPECT_EQ(offered({"export", "--license", ""}), "none\n");
}

}  // namespace
}  // namespace lcrig::cli
