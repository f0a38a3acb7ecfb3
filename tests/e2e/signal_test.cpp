// SPDX-License-Identifier: Apache-2.0
// A signal that comes while the daemon begins ends it as one that comes later: in order.
#include <csignal>
#include <filesystem>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

TEST_F(Rig, ATermInTheInstantOfReadyClosesTheDatabase) {
  const json simulated{{"format", "lcrigd-config/1"},
                       {"database", file("lcrig.db")},
                       {"socket", file("control.sock")},
                       {"bench", file("bench.json")}};
  constexpr int kTimes = 25;
  for (int i = 0; i < kTimes; ++i) {
    SCOPED_TRACE(i);
    const auto name = "d" + std::to_string(i);
    const NotifySocket manager(file(name + ".notify"));
    Child& daemon = launch_daemon(simulated, name);
    ASSERT_TRUE(manager.wait("READY=1", 20s)) << daemon.log();
    daemon.signal(i % 2 == 0 ? SIGTERM : SIGINT);
    ASSERT_EQ(daemon.wait(20s), 0);
    EXPECT_THAT(daemon.log(), HasSubstr(": stopping"));
    EXPECT_EQ(std::filesystem::file_size(file("lcrig.db-wal")), 0U)
        << "the database was not closed";
    daemons_.clear();
  }
}

}  // namespace
}  // namespace lcrig::e2e
