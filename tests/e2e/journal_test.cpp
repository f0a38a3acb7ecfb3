// SPDX-License-Identifier: Apache-2.0
// What an administrator sees: the journal, the service's status, and what the daemon says about its
// ports while nothing runs.
#include <filesystem>
#include "base/clock.hpp"

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Journal : public Rig {
 protected:
  // Output of `lcrig status` once it contains the words; empty: it did not in time.
  std::string status_with(const std::string& words) {
    const RealClock clock;
    const MonoTime limit = clock.now() + 20s;
    while (clock.now() < limit) {
      const auto shown = lcrig({"status", "--socket", file("control.sock")}).out;
      if (shown.find(words) != std::string::npos) return shown;
    }
    return {};
  }
};

TEST_F(Journal, HasTheRunAndTheServiceManagerItsProgress) {
  start_sim();
  const NotifySocket manager(file("d1.notify"));
  Child& daemon = launch_daemon(config(), "d1");
  ASSERT_TRUE(manager.wait("READY=1", 20s)) << daemon.log();
  Control client = control();
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  EXPECT_TRUE(manager.wait("STATUS=simulated run 1 ", 10s));
  EXPECT_TRUE(manager.wait("min left", 10s));
  EXPECT_THAT(daemon.log(), HasSubstr("simulated run 1 begins: "));
  EXPECT_THAT(daemon.log(), HasSubstr(" on paper-1, for "));
  daemon.signal(SIGTERM);
  EXPECT_TRUE(manager.wait("EXTEND_TIMEOUT_USEC=", 10s)) << "`finally` may take its time";
  EXPECT_EQ(daemon.wait(60s), 0);
  EXPECT_THAT(daemon.log(), HasSubstr("simulated run 1 ended: abort SIGTERM (anchor "));
}

TEST_F(Journal, TellsAPortThatWentAwayAndCameBack) {
  start_sim();
  Child& daemon = start_daemon(config());
  EXPECT_THAT(status_with("ready (simulated), asked "), HasSubstr("not asked: an idle daemon"));
  sim("unplug lcr");
  EXPECT_NE(status_with(" s: its port is not there"), "");
  sim("plug lcr");
  EXPECT_THAT(status_with("ready (simulated), asked "), Not(HasSubstr("absent")));
  EXPECT_THAT(daemon.log(), AllOf(HasSubstr("lcr: its port"), HasSubstr("went away"),
                                  HasSubstr("is there again"), HasSubstr("lcr: ready")));
}

TEST_F(Journal, TheInstrumentsAreKnownFromRunsAndRefusedStarts) {
  start_sim();
  Child& daemon = start_daemon(config());
  write("quick.json", kQuickProtocol);
  const std::vector<std::string> words{"run",     file("quick.json"), "--specimen",
                                       "paper-1", "--socket",         file("control.sock")};
  const auto done = lcrig(words, 60s);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("run 1: success (simulated)\n"));
  EXPECT_THAT(status_with("last: run 1 success (simulated)\n"),
              AllOf(HasSubstr("frame  ready (simulated), seen "), HasSubstr("ago in run 1  tcp:")));
  EXPECT_THAT(daemon.log(), HasSubstr("simulated run 1 ended: success (anchor "));
  sim("unplug lcr");
  EXPECT_EQ(lcrig(words).code, 4);
  EXPECT_THAT(status_with("absent (simulated) for "), HasSubstr("LCR-6"));
  EXPECT_THAT(daemon.log(), AllOf(HasSubstr("no run begins: "), HasSubstr(" asked for "),
                                  HasSubstr("quick.json on paper-1: "), HasSubstr("no such port")));
}

TEST_F(Journal, SaysOfADeletedEndThatTheChainIsCut) {
  start_sim();
  Child& daemon = start_daemon(config());
  write("quick.json", kQuickProtocol);
  const auto done = lcrig(
      {"run", file("quick.json"), "--specimen", "paper-1", "--socket", file("control.sock")}, 60s);
  EXPECT_EQ(done.code, 0) << done.err;
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(20s), 0);
  const std::string anchor = query("SELECT links || ':' || lower(hex(sha256)) FROM run_anchor");
  {
    const auto db = open_read_write(file("lcrig.db")).value();
    ASSERT_TRUE(db.execute("DROP TRIGGER run_end_no_delete"));
    ASSERT_TRUE(db.execute("DELETE FROM run_end"));
  }
  const std::string log = start_daemon(config(), "d2").log();
  EXPECT_THAT(log, HasSubstr("run 1 had ended, and its end was deleted from the database"));
  EXPECT_THAT(log, HasSubstr("is kept (" + anchor.substr(0, anchor.find('\n')) + ")"));
  EXPECT_THAT(log, AllOf(HasSubstr("`lcrig verify 1`"), Not(HasSubstr("had not ended"))));
  EXPECT_EQ(lcrig({"verify", "1", "--db", file("lcrig.db")}).code, 1);
}

TEST_F(Journal, AWireLogThatCannotBeWrittenStopsNoRun) {
  start_sim();
  json lost = config();
  lost["wire_log_directory"] = file("nowhere");
  Child& daemon = start_daemon(lost);
  write("quick.json", kQuickProtocol);
  const auto done = lcrig(
      {"run", file("quick.json"), "--specimen", "paper-1", "--socket", file("control.sock")}, 60s);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(daemon.log(), AllOf(HasSubstr("nowhere"), HasSubstr("goes on without a wire log")));
}

TEST_F(Journal, LooksBetweenRunsShareAWireLogUntilTheNextRun) {
  start_sim();
  std::filesystem::create_directory(file("wires"));
  json logged = config();
  logged["wire_log_directory"] = file("wires");
  start_daemon(logged);
  const auto logs = [this](const std::string& begin) {
    std::ptrdiff_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(file("wires"))) {
      count += entry.path().filename().string().starts_with(begin) ? 1 : 0;
    }
    return count;
  };
  const auto look = [this] { return lcrig({"status", "--ask", "--socket", file("control.sock")}); };
  for (int i = 0; i < 4; ++i) EXPECT_EQ(look().code, 0);
  EXPECT_EQ(logs("lcr-looks-"), 1);
  EXPECT_EQ(logs("frame-looks-"), 1);
  EXPECT_EQ(logs(""), 2);
  write("quick.json", kQuickProtocol);
  const auto done = lcrig(
      {"run", file("quick.json"), "--specimen", "paper-1", "--socket", file("control.sock")}, 60s);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(logs(""), 4) << "those of the run";
  EXPECT_EQ(look().code, 0);
  EXPECT_EQ(logs("lcr-looks-"), 2) << "the one of before belongs to the time before the run";
}

TEST_F(Journal, ACheckOnTheRigFindsWhatItsPlanRefuses) {
  start_sim();
  start_daemon(config());
  write("quick.json", kQuickProtocol);
  const std::vector<std::string> check{
      "protocol",   "check",   file("quick.json"), "--rig",
      "--specimen", "paper-1", "--socket",         file("control.sock")};
  EXPECT_EQ(lcrig(check).code, 0);
  std::string fast = kQuickProtocol;
  const auto at = fast.find("\"frequency_Hz\": 1000");
  ASSERT_NE(at, fast.npos);
  write("quick.json", fast.replace(at, 20, "\"frequency_Hz\": 5"));
  const auto refused = lcrig(check);
  EXPECT_EQ(refused.code, 6) << refused.err;
  EXPECT_THAT(refused.err, AllOf(HasSubstr("quick.json:"), HasSubstr("5 Hz")));
  EXPECT_THAT(refused.err, AllOf(HasSubstr("next: lcrig protocol check "), HasSubstr(" --rig"),
                                 Not(HasSubstr("--dry-run"))));
  EXPECT_EQ(number("SELECT count(*) FROM run"), 0);
}

}  // namespace
}  // namespace lcrig::e2e
