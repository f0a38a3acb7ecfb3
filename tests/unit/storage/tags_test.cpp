// SPDX-License-Identifier: Apache-2.0
#include "storage/tags.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/old_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Tags : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(insert_run(db_, RunRow()));
    for (const std::int64_t run : {1, 2}) ASSERT_TRUE(insert_run_end(db_, run, RunEnd()));
  }
  Result<std::vector<std::string>> change(std::int64_t run, std::vector<std::string> tags,
                                          bool remove = false) const {
    TagChange wanted;
    wanted.run = run;
    wanted.tags = std::move(tags);
    wanted.remove = remove;
    return change_tags(db_, wanted, "Ada", 7);
  }
  std::vector<std::int64_t> tagged(const std::string& tag) const {
    RunFilter filter;
    filter.tag = tag;
    std::vector<std::int64_t> out;
    const auto runs = list_runs(db_, filter).value();
    for (const auto& run : runs) out.push_back(run.run);
    return out;
  }
  TempDir dir_;
  Database db_ = open_read_write(dir_.file("a.db")).value();
};

TEST_F(Tags, FindRunsAgain) {
  EXPECT_THAT(change(1, {"thesis", "ageing"}).value(), ElementsAre("ageing", "thesis"));
  EXPECT_THAT(change(3, {"ageing"}).value(), ElementsAre("ageing")) << "it goes on";
  EXPECT_THAT(tagged("ageing"), ElementsAre(3, 1));
  EXPECT_THAT(tagged("thesis"), ElementsAre(1));
  EXPECT_THAT(tagged("age"), IsEmpty());
  EXPECT_THAT(get_run_listing(db_, 1).value().tags, ElementsAre("ageing", "thesis"));
}

TEST_F(Tags, AreTakenOffAndPutOnAgainWithoutForgettingIt) {
  ASSERT_TRUE(change(1, {"good"}));
  ASSERT_TRUE(change(1, {"good"})) << "it has it already";
  EXPECT_THAT(change(1, {"good"}, true).value(), IsEmpty());
  EXPECT_THAT(tagged("good"), IsEmpty());
  EXPECT_THAT(change(1, {"good"}).value(), ElementsAre("good"));
  EXPECT_EQ(db_.integer("SELECT count(*) FROM run_tag").value(), 3);
  EXPECT_FALSE(db_.execute("DELETE FROM run_tag"));
  EXPECT_FALSE(db_.execute("UPDATE run_tag SET tag = 'bad'"));
}

TEST_F(Tags, LeaveTheChainAsItIs) {
  const auto before = verify_chain(db_, 1).value();
  ASSERT_TRUE(change(1, {"good"}));
  ASSERT_TRUE(change(1, {"good"}, true));
  const auto after = verify_chain(db_, 1).value();
  EXPECT_TRUE(after.intact) << after.finding;
  EXPECT_EQ(after.head, before.head);
}

TEST_F(Tags, AreWordsOfARunThatIsThere) {
  for (const char* tag : {"", "two words", "a,b", "-x", "a\nb", "\xff", "a\u00A0b", "a\u200Bb",
                          "a-word-that-is-far-too-long-for-a-column-of-a-table-of-runs-and-more"}) {
    EXPECT_FALSE(change(1, {"fine", tag})) << tag;
  }
  EXPECT_FALSE(change(1, {}));
  EXPECT_THAT(change(9, {"x"}).error().what, HasSubstr("no run 9"));
  EXPECT_THAT(change(1, {"x"}, true).error().what, HasSubstr("run 1 has no tag x"));
  EXPECT_THAT(get_tags_of(db_, 1).value(), IsEmpty()) << "all or nothing";
}

TEST_F(Tags, OfASchemaWithoutThemAreNone) {
  const auto old = support::database_before_uuids(dir_.file("old.db"));
  support::insert_old_run(old, 1);
  EXPECT_THAT(get_run_listing(old, 1).value().tags, IsEmpty());
  EXPECT_THAT(get_tags(old).value(), IsEmpty());
  RunFilter filter;
  EXPECT_EQ(list_runs(old, filter).value().size(), 1U);
  filter.tag = "thesis";
  EXPECT_THAT(list_runs(old, filter).value(), IsEmpty());
}

}  // namespace
}  // namespace lcrig
