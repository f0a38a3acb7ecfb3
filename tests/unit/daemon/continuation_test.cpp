// SPDX-License-Identifier: Apache-2.0
#include "daemon/continuation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/session.hpp"
#include "storage/copy_runs.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;

// Its numbers, and the specimen on the rig, belong to the place where it was recorded.
TEST(Continuation, OfARunThatWasCopiedIsRefused) {
  const TempDir dir;
  {
    const auto db = open_read_write(dir.file("rig.db")).value();
    ASSERT_TRUE(insert_run(db, RunRow()));
    RunEnd end;
    end.status = ExitStatus::interrupted;
    ASSERT_TRUE(insert_run_end(db, 1, end));
    EXPECT_THAT(prepare_continuation(db, 1).error().what, HasSubstr("before its first step"));
  }
  ASSERT_TRUE(copy_runs(dir.file("rig.db"), {1}, dir.file("other.db"), {}));
  const auto other = open_read_write(dir.file("other.db")).value();
  EXPECT_THAT(prepare_continuation(other, 1).error().what,
              HasSubstr("rig.db, where it is run 1: it can be continued only there"));
  EXPECT_TRUE(find_resumable(other, RigBefore::still_there).value().empty());
  EXPECT_EQ(last_run_end_unix_ns(other).value(), std::nullopt) << "the rig did nothing for it";
}

}  // namespace
}  // namespace lcrig
