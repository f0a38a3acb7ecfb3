// SPDX-License-Identifier: Apache-2.0
#include "storage/uuid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "storage/chain.hpp"
#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/old_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

std::string uuid_in(const Database& db, std::int64_t run) {
  return get_uuid(db, run).value().value_or("none");
}

void overwrite(const Database& db, const std::string& sql) {
  const auto done = db.execute("DROP TRIGGER IF EXISTS run_no_update; " + sql);
  ASSERT_TRUE(done) << done.error().what;
}

TEST(Uuid, IsRandomAndOfVersion4) {
  std::set<std::string> all;
  for (int i = 0; i < 1000; ++i) {
    const auto uuid = random_uuid();
    EXPECT_THAT(uuid, MatchesRegex("[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-8[0-9a-f]{3}-"
                                   "[0-9a-f]{12}"));
    EXPECT_FALSE(is_of_link(uuid));
    all.insert(uuid);
  }
  EXPECT_EQ(all.size(), 1000U);
}

TEST(Uuid, IsMeantByItsBeginningWhereItIsNoNumber) {
  const std::string uuid = "12345678-9abc-4def-8123-456789abcdef";
  for (const std::size_t length : {9U, 10U, 14U, 36U}) {
    EXPECT_TRUE(is_beginning_of_uuid(uuid.substr(0, length))) << length;
  }
  for (const char* text : {"", "abc", "12345678", "last", "1234567-", "12345678x", "0x1234",
                           "12345678-9abc-4def-8123-456789abcdef0"}) {
    EXPECT_FALSE(is_beginning_of_uuid(text)) << text;
  }
}

TEST(Uuid, OfANewRunIsCoveredByItsChain) {
  const TempDir dir;
  const auto db = open_read_write(dir.file("a.db")).value();
  ASSERT_TRUE(insert_run(db, RunRow()));
  ASSERT_TRUE(insert_run_end(db, 1, RunEnd()));
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
  const auto uuid = uuid_in(db, 1);
  EXPECT_EQ(get_run(db, 1).value().uuid, uuid);
  EXPECT_EQ(get_run_listing(db, 1).value().uuid, uuid);
  auto other = uuid;
  other.back() = other.back() == '0' ? '1' : '0';
  overwrite(db, "UPDATE run SET uuid = '" + other + "'");
  EXPECT_THAT(verify_chain(db, 1).value().finding, HasSubstr("link 1 does not match"));
  other[14] = '8';  // as if the run had been recorded before uuids
  ASSERT_TRUE(db.execute("UPDATE run SET uuid = '" + other + "'"));
  EXPECT_FALSE(verify_chain(db, 1).value().intact);
  ASSERT_TRUE(db.execute("UPDATE run SET uuid = '" + uuid + "'"));
  EXPECT_TRUE(verify_chain(db, 1).value().intact);
}

TEST(Uuid, IsNeededByEveryRunAndOfOneOnly) {
  const TempDir dir;
  const auto db = open_read_write(dir.file("a.db")).value();
  RunRow row;
  row.uuid = random_uuid();
  ASSERT_TRUE(insert_run(db, row));
  EXPECT_FALSE(insert_run(db, row)) << "two runs with one name";
  EXPECT_FALSE(db.execute("INSERT INTO run SELECT * FROM run"));
}

// Two copies of a database that are brought up to date separately give a run the same name.
TEST(Uuid, OfAnOldRunFollowsFromItsFirstLink) {
  const TempDir dir;
  std::string names[2];
  for (std::size_t copy : {0U, 1U}) {
    const auto path = dir.file(copy == 0 ? "a.db" : "b.db");
    Sha256 link{};
    {
      const auto old = support::database_before_uuids(path);
      link = support::insert_old_run(old, 1);
      support::insert_old_run(old, 2);
      ASSERT_TRUE(insert_run_end(old, 1, RunEnd()));
      EXPECT_TRUE(verify_chain(old, 1).value().intact);
      EXPECT_EQ(get_uuid(old, 1).value(), std::nullopt);
      EXPECT_EQ(get_run_listing(old, 1).value().uuid, "");
      EXPECT_EQ(list_runs(old).value().size(), 2U);
    }
    const auto db = open_read_write(path).value();
    names[copy] = uuid_in(db, 1);
    EXPECT_EQ(names[copy], uuid_of_link(link));
    EXPECT_TRUE(is_of_link(names[copy]));
    EXPECT_NE(uuid_in(db, 2), names[copy]);
    const auto chain = verify_chain(db, 1).value();
    EXPECT_TRUE(chain.intact) << chain.finding;
    EXPECT_FALSE(db.execute("UPDATE run SET note = 'other'")) << "rows do not change any more";
  }
  EXPECT_EQ(names[0], names[1]);
}

TEST(Uuid, OfAnOldRunCannotBeChangedUnnoticed) {
  const TempDir dir;
  {
    const auto old = support::database_before_uuids(dir.file("a.db"));
    support::insert_old_run(old, 1);
    ASSERT_TRUE(insert_run_end(old, 1, RunEnd()));
  }
  const auto db = open_read_write(dir.file("a.db")).value();
  auto other = uuid_in(db, 1);
  other.front() = other.front() == '0' ? '1' : '0';
  overwrite(db, "UPDATE run SET uuid = '" + other + "'");
  EXPECT_THAT(verify_chain(db, 1).value().finding, HasSubstr("the uuid is not that of the run"));
  overwrite(db, "UPDATE run SET uuid = '" + random_uuid() + "'");
  EXPECT_FALSE(verify_chain(db, 1).value().intact);
}

// A daemon must start even with a database that somebody has changed.
TEST(Uuid, IsGivenToOldRunsWithoutALinkOrWithThatOfAnother) {
  const TempDir dir;
  {
    const auto old = support::database_before_uuids(dir.file("a.db"));
    for (const std::int64_t run : {1, 2, 3}) support::insert_old_run(old, run);
    ASSERT_TRUE(
        old.execute("DROP TRIGGER chain_no_update; DROP TRIGGER chain_no_delete;"
                    "UPDATE chain SET sha256 = (SELECT sha256 FROM chain WHERE run_id = 1)"
                    " WHERE run_id = 2; DELETE FROM chain WHERE run_id = 3"));
  }
  const auto db = open_read_write(dir.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  std::set<std::string> names;
  for (const std::int64_t run : {1, 2, 3}) {
    names.insert(uuid_in(*db, run));
    EXPECT_EQ(uuid_in(*db, run).size(), 36U);
  }
  EXPECT_EQ(names.size(), 3U);
  EXPECT_THAT(uuid_in(*db, 2), MatchesRegex("[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-8[0-9a-f]{3}-"
                                            "[0-9a-f]{12}"));
}

TEST(Uuid, FindsItsRun) {
  const TempDir dir;
  const auto db = open_read_write(dir.file("a.db")).value();
  for (const char* uuid :
       {"abcd1111-0000-4000-8000-000000000000", "abcd2222-0000-4000-8000-000000000000",
        "12345678-0000-4000-8000-000000000000"}) {
    RunRow row;
    row.uuid = uuid;
    ASSERT_TRUE(insert_run(db, row));
  }
  EXPECT_EQ(find_run(db, "abcd2").value_or(0), 2);
  EXPECT_EQ(find_run(db, "ABCD1111-00").value_or(0), 1);
  EXPECT_EQ(find_run(db, "12345678-0000-4000-8000-000000000000").value_or(0), 3);
  EXPECT_EQ(find_run(db, "12345678-").value_or(0), 3);
  EXPECT_THAT(find_run(db, "12345678").error().what, HasSubstr("no run 12345678"));
  EXPECT_THAT(find_run(db, "abcd").error().what, HasSubstr("those of runs 1 and 2"));
  EXPECT_THAT(find_run(db, "abcd3").error().what, HasSubstr("no run abcd3"));
}

}  // namespace
}  // namespace lcrig
