// SPDX-License-Identifier: Apache-2.0
#include "storage/faulty_disk.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "storage/database.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

class FaultyDiskTest : public ::testing::Test {
 protected:
  Database open() {
    auto db = open_read_write(path, disk.name());
    if (!db) throw std::runtime_error(db.error().what);
    return std::move(*db);
  }
  // A row of 64 kB, which cannot fit into the present file.
  static Result<> add_row(const Database& db) {
    return db.execute(
        "INSERT INTO specimen (name, version, sha256, text, added_unix_ns) VALUES ("
        "'x' || random(), 1, hex(zeroblob(32)), hex(randomblob(32768)), 0)");
  }
  TempDir dir;
  std::string path = dir.file("a.db");
  FaultyDisk disk;
};

TEST_F(FaultyDiskTest, AFullDiskTakesRowsAgainWhenItHasRoom) {
  const Database db = open();
  ASSERT_TRUE(add_row(db));
  disk.set_full(true);
  const auto full = add_row(db);
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().what, HasSubstr("full"));
  disk.set_full(false);
  EXPECT_TRUE(add_row(db));
  EXPECT_EQ(db.integer("SELECT count(*) FROM specimen").value(), 2);
}

TEST_F(FaultyDiskTest, DeletingTheReserveMakesRoom) {
  const Database db = open();
  std::ofstream(path + ".reserve") << std::string(1 << 20, 'r');
  disk.set_full(true);
  EXPECT_FALSE(add_row(db));
  std::filesystem::remove(path + ".reserve");
  EXPECT_TRUE(add_row(db));
  int more = 0;
  while (more < 100 && add_row(db)) ++more;
  EXPECT_LT(more, 16) << "the reserve had 1 MiB, a row has 64 kB";
}

TEST_F(FaultyDiskTest, AReadOnlyDiskStillAnswers) {
  const Database db = open();
  ASSERT_TRUE(add_row(db));
  disk.set_read_only(true);
  const auto refused = add_row(db);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_EQ(db.integer("SELECT count(*) FROM specimen").value(), 1);
  disk.set_read_only(false);
  EXPECT_TRUE(add_row(open()));
}

TEST_F(FaultyDiskTest, OneOperationFailsOnce) {
  const Database db = open();
  disk.fail_operation(0, FaultyDisk::Failure::io_error);
  EXPECT_FALSE(add_row(db));
  EXPECT_TRUE(disk.has_failed());
  EXPECT_TRUE(add_row(open()));
}

TEST_F(FaultyDiskTest, WithoutMemoryADatabaseSaysSo) {
  const Database db = open();
  set_sqlite_memory_short(true);
  const auto refused = add_row(db);
  set_sqlite_memory_short(false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_THAT(refused.error().what, HasSubstr("memory is short"));
  EXPECT_TRUE(add_row(db));
}

}  // namespace
}  // namespace lcrig
