// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/room.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Room, IsThereForThePlanAndForWhatNoPlanKnows) {
  const TempDir dir;
  const auto free_bytes = [&dir] {
    return static_cast<std::int64_t>(std::filesystem::space(dir.path()).available);
  };
  const auto database = dir.file("rig.db");
  EXPECT_TRUE(require_room(database, free_bytes() / 2));
  const auto refused = require_room(database, free_bytes() - 1'000'000);
  ASSERT_FALSE(refused) << "all of it would be used up";
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_THAT(refused.error().what, AllOf(HasSubstr(dir.path().string()), HasSubstr("MB are free"),
                                          HasSubstr("free some space")));
}

TEST(Room, OfADiskThatCannotTellIsBelievedToBeThere) {
  EXPECT_TRUE(require_room("/no/such/folder/rig.db", std::int64_t{1} << 60));
}

}  // namespace
}  // namespace lcrig
