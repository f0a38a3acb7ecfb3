// SPDX-License-Identifier: Apache-2.0
// A signal that comes while the daemon starts ends it in order, as a later one does.
#include <csignal>
#include <filesystem>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

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

// SIGTERM comes from a program and not from a key.
TEST_F(Rig, ATermToARunIsToldAsWhatItWas) {
  start_sim();
  start_daemon(config());
  write("slow.json", kSlowProtocol);
  Control client = control();
  client.call("watch");
  Child run({LCRIG_BIN "/lcrig", "run", file("slow.json"), "--specimen", "paper-1", "--socket",
             file("control.sock")},
            file("run.log"), {{"HOME", file("home")}});
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "away"; });
  run.signal(SIGTERM);
  EXPECT_EQ(client.run_ended().value("exit_status", ""), "abort");
  EXPECT_EQ(run.wait(10s), 130);
  EXPECT_THAT(query("SELECT reason FROM run_end"), HasSubstr("SIGTERM to lcrig run"));
  EXPECT_THAT(run.log(), AllOf(HasSubstr("stopping the run"), Not(HasSubstr("Ctrl-C"))));
}

}  // namespace
}  // namespace lcrig::e2e
