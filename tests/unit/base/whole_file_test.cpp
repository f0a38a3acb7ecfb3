// SPDX-License-Identifier: Apache-2.0
#include "base/whole_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

std::string content(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string part(const std::string& path, int n) {
  return path + "." + std::to_string(::getpid()) + "-" + std::to_string(n) + ".part";
}

std::ptrdiff_t files_in(const TempDir& dir) {
  return std::distance(std::filesystem::directory_iterator(dir.path()), {});
}

Result<> write_it(const std::string& path) {
  return write_whole_file(path, "new");
}

TEST(EarlierOutput, AloneIsReplaced) {
  const TempDir dir;
  const auto is_replaceable = [&dir](const char* name) {
    return require_earlier_output(dir.file(name), "<svg our").has_value();
  };
  std::ofstream(dir.file("empty.svg"));
  std::ofstream(dir.file("ours.svg")) << "<?xml?>\n<svg ours/>";
  std::ofstream(dir.file("theirs.svg")) << "<svg theirs/>";
  std::ofstream(dir.file("deep.svg")) << std::string(5000, ' ') << "<svg ours/>";
  std::ofstream(dir.file("a.db")) << "SQLite format 3\0<svg ours/>";
  std::ofstream(dir.file("a.db.lock"));
  std::filesystem::create_symlink("a.db", dir.file("link.svg"));
  std::filesystem::create_symlink("a.db.lock", dir.file("lock.svg"));
  std::filesystem::create_hard_link(dir.file("a.db"), dir.file("hard.svg"));
  for (const char* may : {"new.svg", "empty.svg", "ours.svg", "."}) {
    EXPECT_TRUE(is_replaceable(may)) << may;
  }
  for (const char* lost :
       {"theirs.svg", "deep.svg", "a.db", "a.db.lock", "link.svg", "lock.svg", "hard.svg"}) {
    EXPECT_FALSE(is_replaceable(lost)) << lost;
  }
  EXPECT_EQ(require_earlier_output(dir.file("a.db"), "x").error().what,
            dir.file("a.db") + ": is of a database, which would be lost");
}

TEST(WholeFile, ReplacesTheOldOne) {
  const TempDir dir;
  std::ofstream(dir.file("a.csv")) << "older and longer";
  ASSERT_TRUE(write_it(dir.file("a.csv")));
  EXPECT_EQ(content(dir.file("a.csv")), "new");
  EXPECT_EQ(files_in(dir), 1);
}

TEST(WholeFile, WhatACrashLeftBehindIsNotInTheWay) {
  const TempDir dir;
  const std::string path = dir.file("a.csv");
  std::ofstream(part(path, 0)) << "half";
  ASSERT_TRUE(write_it(path));
  EXPECT_EQ(content(path), "new");
  EXPECT_EQ(content(part(path, 0)), "half") << "it may be somebody else's";
}

TEST(WholeFile, ALinkThatSomebodyPutThereIsNotFollowed) {
  const TempDir dir;
  const std::string path = dir.file("a.csv"), precious = dir.file("precious");
  std::ofstream(precious) << "mine";
  std::filesystem::create_symlink(precious, part(path, 0));
  std::filesystem::create_symlink(dir.file("nowhere"), part(path, 1));
  ASSERT_TRUE(write_it(path));
  EXPECT_EQ(content(path), "new");
  EXPECT_EQ(content(precious), "mine");
  EXPECT_FALSE(std::filesystem::exists(dir.file("nowhere")));
}

TEST(WholeFile, NothingIsLeftOfWhatFailed) {
  const TempDir dir;
  const auto failed = write_whole_file(dir.file("a.csv"), [](int fd) -> Result<> {
    if (auto half = write_text(fd, "a.csv", "half"); !half) return half;
    return fail(Errc::io, "no more");
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().what, "no more");
  EXPECT_EQ(files_in(dir), 0);
  const std::string nowhere = dir.file("none/a.csv");
  EXPECT_EQ(write_it(nowhere).error().what, nowhere + ": No such file or directory");
}

}  // namespace
}  // namespace lcrig
