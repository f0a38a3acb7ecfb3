// SPDX-License-Identifier: Apache-2.0
// The queue's own connection to the database.
#include "daemon/queue/store.hpp"

#include <gmock/gmock.h>

#include "storage/queue.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

class Store : public AppPartsTest {
 protected:
  QueueStore store{io.get_executor(), clock, database, ""};
};

TEST_F(Store, GivesTheResultOfAJob) {
  const auto counted = run(store.with([](const Database& db) { return count_queue(db); }));
  ASSERT_TRUE(counted) << counted.error().what;
  EXPECT_EQ(*counted, 0);
  const auto missing = run(store.with([](const Database& db) { return get_queue_entry(db, 7); }));
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().what, testing::HasSubstr("never an entry 7"));
}

TEST_F(Store, TellsWhyTheDatabaseCannotBeOpened) {
  QueueStore elsewhere(io.get_executor(), clock, dir.path().string(), "");
  const auto counted = run(elsewhere.with([](const Database& db) { return count_queue(db); }));
  ASSERT_FALSE(counted);
  EXPECT_THAT(counted.error().what, testing::HasSubstr("is a folder"));
}

TEST_F(Store, DoesOneJobAfterTheOther) {
  std::atomic<int> under_way = 0, most = 0, done = 0;
  const auto job = [&](const Database& db) {
    most = std::max(most.load(), ++under_way);
    auto count = count_queue(db);
    --under_way;
    ++done;
    return count;
  };
  std::optional<Result<std::int64_t>> first, second;
  begin(keep(store.with(job), first));
  begin(keep(store.with(job), second));
  begin(store.settle());
  clock.run(io, [&] { return first && second; });
  EXPECT_EQ(done, 2);
  EXPECT_EQ(most, 1);
}

}  // namespace
}  // namespace lcrig::support
