// SPDX-License-Identifier: Apache-2.0
// Acknowledged rows survive kill -9 at any moment.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <random>

#include "daemon/record/recorder.hpp"
#include "tests/support/run_task.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

// Writes readings without end, and after each commit writes to `fd` how many are acknowledged.
[[noreturn]] void record_forever(const std::string& path, int fd) {
  asio::io_context io;
  RealClock clock;
  auto recorder = Recorder::open(io, clock, Recorder::Options(path));
  if (!recorder) ::_exit(1);
  std::int64_t acknowledged = 0;
  Recorder::Listener listener;
  listener.committed = [&](const Committed& c) {
    acknowledged += static_cast<std::int64_t>(c.readings.size());
    if (::write(fd, &acknowledged, sizeof acknowledged) < 0) ::_exit(2);
  };
  (*recorder)->set_listener(std::move(listener));
  if (!run_task(io, (*recorder)->begin_run(RunRow()))) ::_exit(3);
  for (;;) {
    for (int i = 0; i < 3; ++i) (*recorder)->reading(LcrReading(), ReadingTag());
    if (!run_task(io, (*recorder)->flush())) ::_exit(4);
  }
}

TEST(KilledRecorder, LosesNoAcknowledgedReading) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> commits(1, 60);
  for (int round = 0; round < 10; ++round) {
    TempDir dir;
    const std::string path = dir.file("a.db");
    int pipe_fds[2];
    ASSERT_EQ(::pipe(pipe_fds), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) record_forever(path, pipe_fds[1]);
    ::close(pipe_fds[1]);
    std::int64_t acknowledged = 0;
    for (int left = commits(random); left > 0; --left) {
      ASSERT_EQ(::read(pipe_fds[0], &acknowledged, sizeof acknowledged), 8);
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    while (::read(pipe_fds[0], &acknowledged, sizeof acknowledged) == 8) {
    }
    ::close(pipe_fds[0]);
    auto owned = open_as_owner(path, 1);
    ASSERT_TRUE(owned) << owned.error().what;
    EXPECT_EQ(owned->interrupted.size(), 1U);
    EXPECT_GE(get_run_listing(owned->db, 1)->lcr_readings, acknowledged);
    const auto report = verify_chain(owned->db, 1);
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->intact) << report->finding;
  }
}

}  // namespace
}  // namespace lcrig
