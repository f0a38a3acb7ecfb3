// SPDX-License-Identifier: Apache-2.0
// Stored batches: all runs of a table or none, in the order that was drawn.
#include "storage/batches.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "storage/database.hpp"
#include "tests/support/deadly_vfs.hpp"
#include "tests/support/queued_run.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

StoredBatch named(const std::string& name) {
  StoredBatch out;
  out.name = name;
  out.file_name = name + ".csv";
  out.order = BatchOrder::random;
  out.seed = 7;
  return out;
}

Result<std::vector<std::int64_t>> add_batch(const Database& db, const std::string& name,
                                            const std::vector<std::string>& specimens) {
  std::vector<QueuedRun> runs;
  runs.reserve(specimens.size());
  for (const auto& specimen : specimens) runs.push_back(queued(specimen));
  const auto run_at = [&runs](std::size_t i) {
    BatchedRun out;
    out.run = &runs[i];
    out.line = static_cast<std::int64_t>(i) + 2;
    return out;
  };
  return add_batch_to_queue(db, named(name), "the table", runs.size(), run_at, QueuePlace(),
                            by("lab"));
}

TEST(Batches, AreQueuedInTheirOrderAndKnowTheirRows) {
  const TempDir dir;
  const auto db = open_read_write(dir.file("q.db")).value();
  ASSERT_TRUE(add_one(db, queued("before")));
  const auto entries = add_batch(db, "day", {"b", "a", "b"});
  ASSERT_TRUE(entries) << entries.error().what;
  EXPECT_THAT(order_of(db), ElementsAre(1, 2, 3, 4));
  const auto found = find_batch(db, "day").value();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->seed, 7);
  EXPECT_EQ(found->order, BatchOrder::random);
  EXPECT_EQ(found->added_by, "lab");
  const auto listed = batch_entries(db, found->batch).value();
  ASSERT_EQ(listed.size(), 3U);
  EXPECT_EQ(listed[1].specimen_name, "a");
  EXPECT_EQ(listed[1].line, 3);
  EXPECT_TRUE(listed[1].runs.empty());
  const auto from = batch_of_entry(db, 3).value();
  ASSERT_TRUE(from);
  EXPECT_EQ(from->position, 2);
  EXPECT_EQ(from->of, 3);
  EXPECT_FALSE(batch_of_entry(db, 1).value());
}

TEST(Batches, ANameThatExistsIsRefusedAndNothingIsQueued) {
  const TempDir dir;
  const auto db = open_read_write(dir.file("q.db")).value();
  ASSERT_TRUE(add_batch(db, "day", {"a"}));
  const auto again = add_batch(db, "day", {"b", "c"});
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().what, HasSubstr("a batch `day` exists already, added by lab"));
  EXPECT_EQ(count_queue(db).value(), 1);
  EXPECT_EQ(list_batches(db).value().size(), 1U);
}

TEST(Batches, KnowTheRunsThatTheirEntriesBecame) {
  const TempDir dir;
  const auto db = open_read_write(dir.file("q.db")).value();
  ASSERT_TRUE(add_batch(db, "day", {"a", "a"}));
  ASSERT_TRUE(start_queue(db, HeadChoice::none, by("lab")));
  const auto run = begin_entry(db, 1);
  ASSERT_TRUE(run) << run.error().what;
  const auto listed = batch_entries(db, 1).value();
  EXPECT_THAT(listed[0].runs, ElementsAre(*run));
  EXPECT_EQ(listed[0].state, EntryState::running);
  EXPECT_TRUE(listed[1].runs.empty());
}

// The process that adds a batch dies at its nth write. Afterwards the whole table is there, or none
// of it.
TEST(Batches, AKillAtAnyWriteLeavesAllOrNothing) {
  int whole = 0, none = 0;
  for (int n = 0; n < 40; ++n) {
    SCOPED_TRACE(n);
    const TempDir dir;
    const auto path = dir.file("q.db");
    {
      ASSERT_TRUE(open_read_write(path));
    }
    const pid_t child = ::fork();
    if (child == 0) {
      const DeadlyVfs vfs(n);
      const auto db = open_read_write(path);
      if (db) static_cast<void>(add_batch(*db, "day", {"a", "b", "c", "d", "e"}));
      ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    const auto db = open_read_write(path);
    ASSERT_TRUE(db) << db.error().what;
    const auto entries = count_queue(*db).value();
    const auto rows = db->integer("SELECT count(*) FROM batch_entry").value();
    const auto batches = db->integer("SELECT count(*) FROM batch").value();
    EXPECT_TRUE(entries == 0 || entries == 5) << entries;
    EXPECT_EQ(rows, entries);
    EXPECT_EQ(batches, entries / 5);
    (entries == 5 ? whole : none) += 1;
  }
  EXPECT_GT(none, 2);
  EXPECT_GT(whole, 2);
}

}  // namespace
}  // namespace lcrig
