// SPDX-License-Identifier: Apache-2.0

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "daemon/app/rig_watch.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

// A daemon was killed in the middle of a run in which it commanded the frame.
class LeftMotion : public testing::Test {
 protected:
  void SetUp() override {
    const auto db = open_read_write(path_).value();
    RunRow row;
    row.protocol_text = "unreadable, which counts as one that commands";
    run_ = insert_run(db, row).value();
  }
  bool is_left() const { return may_have_left_motion(path_, 60s); }

  TempDir dir_;
  std::string path_ = dir_.file("a.db");
  std::int64_t run_ = 0;
};

TEST_F(LeftMotion, IsNotHiddenByALockOfAReader) {
  static_cast<void>(WriterLock::acquire(path_).value());
  const int reader = ::open((path_ + ".lock").c_str(), O_RDONLY | O_CLOEXEC);
  struct flock shared{};
  shared.l_type = F_RDLCK;
  ASSERT_EQ(::fcntl(reader, F_OFD_SETLK, &shared), 0);
  EXPECT_TRUE(is_left());
  ::close(reader);
}

TEST_F(LeftMotion, IsNotHiddenByAWriterThatDoesNotRecordTheRun) {
  auto lock = WriterLock::acquire(path_).value();
  EXPECT_TRUE(is_left());
  ASSERT_TRUE(lock.begin_run(run_));
  EXPECT_FALSE(is_left()) << "another daemon is at it";
}

TEST_F(LeftMotion, IsNotHiddenWhenTheDatabaseWasMovedAwayFromItsLog) {
  const auto db = open_read_write(path_).value();
  ASSERT_TRUE(insert_run(db, RunRow()));
  std::filesystem::rename(path_, dir_.file("moved.db"));
  ASSERT_GT(std::filesystem::file_size(path_ + "-wal"), 0U);
  EXPECT_TRUE(is_left());
}

TEST_F(LeftMotion, NothingIsLeftWhereThereWasNoDatabase) {
  EXPECT_FALSE(may_have_left_motion(dir_.file("none.db"), 60s));
}

}  // namespace
}  // namespace lcrig
