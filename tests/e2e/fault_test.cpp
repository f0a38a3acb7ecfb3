// SPDX-License-Identifier: Apache-2.0
// Cables pulled in the middle of a run, and ports without a rig.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

class Faults : public Rig {
 protected:
  // Starts a slow run and waits until it is in the middle of its ramp.
  std::unique_ptr<Control> ramp() {
    start_daemon(config());
    auto client = std::make_unique<Control>(control());
    client->call("watch");
    const json started = start_run(*client, kSlowProtocol);
    EXPECT_TRUE(started.contains("result")) << started;
    client->wait_for("status", [](const json& s) { return s.value("step", "") == "away"; });
    return client;
  }

  // `lcrig run` must be refused with a reason, and nothing may have moved.
  void expect_no_run(const json& config, const std::string& what, int code = 4,
                     Child::Rights rights = Child::Rights::as_we_are) {
    start_daemon(config, "d1", rights);
    write("quick.json", kQuickProtocol);
    const double before_mm = sim("status").value("travel_mm", 0.0);
    const Ended run = lcrig({"run", file("quick.json"), "--specimen", "paper-1", "--json",
                             "--socket", file("control.sock")});
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_THAT(run.err, HasSubstr(what));
    EXPECT_EQ(sim("status").value("travel_mm", -1.0), before_mm);
    EXPECT_EQ(number("SELECT count(*) FROM run"), 0);
  }
};

TEST_F(Faults, UnpluggedMeterEndsTheRunWithTheReason) {
  start_sim();
  auto client = ramp();
  sim("unplug lcr");
  const json end = client->run_ended();
  EXPECT_EQ(end.value("exit_status", ""), "fail");
  EXPECT_EQ(end.value("code", ""), "disconnected");
  EXPECT_THAT(end.value("reason", ""), HasSubstr(file("lcr")));
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "fail\n");
  EXPECT_GE(number("SELECT count(*) FROM event WHERE kind = 'stopped'"), 1);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind = 'step_end' AND step_id = 'clear' AND "
                   "detail = 'done'"),
            1);
  EXPECT_FALSE(sim("settle").value("moving", true));
}

TEST_F(Faults, FrameGoneInTheMiddleOfARamp) {
  start_sim();
  auto client = ramp();
  sim("unplug frame");
  const json end = client->run_ended();
  EXPECT_EQ(end.value("exit_status", ""), "fail");
  EXPECT_EQ(end.value("code", ""), "disconnected");
  EXPECT_THAT(end.value("reason", ""), HasSubstr("tcp:127.0.0.1"));
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "fail\n");
  EXPECT_FALSE(sim("settle").value("moving", true));
}

TEST_F(Faults, SilentFrameInTheMiddleOfARamp) {
  start_sim();
  auto client = ramp();
  sim("silent frame");
  const json end = client->run_ended();
  EXPECT_EQ(end.value("exit_status", ""), "fail");
  EXPECT_NE(end.value("reason", ""), "");
  EXPECT_FALSE(sim("settle").value("moving", true));
}

TEST_F(Faults, NoSuchPort) {
  start_sim();
  json wrong = config();
  wrong["meter"]["port"] = "/dev/no-such-port";
  expect_no_run(wrong, "/dev/no-such-port: no such port");
}

TEST_F(Faults, NobodyListensForTheFrameLink) {
  start_sim();
  const json wrong = config();
  sim("unplug frame");
  expect_no_run(wrong, "is the program there running?");
}

TEST_F(Faults, PortInUse) {
  start_sim();
  const int fd = ::open(ports_.value("lcr", "").substr(4).c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(fd, 0);
  ASSERT_EQ(::flock(fd, LOCK_EX | LOCK_NB), 0);
  expect_no_run(config(), "another program uses the port");
  ::close(fd);
}

TEST_F(Faults, NoRightsOnThePort) {
  start_sim();
  ASSERT_EQ(::chmod(ports_.value("lcr", "").substr(4).c_str(), 0), 0);
  expect_no_run(config(), "no rights to open the port", 1, Child::Rights::those_of_the_files);
}

TEST_F(Faults, AnotherInstrumentAnswers) {
  start_sim({"--lcr-identity", "KEITHLEY INSTRUMENTS INC.,MODEL 2000,0,A20"});
  expect_no_run(config(), "KEITHLEY");
}

TEST_F(Faults, MeterSilent) {
  start_sim();
  sim("silent lcr");
  expect_no_run(config(), file("lcr"));
}

TEST_F(Faults, TwoDaemonsOnOneDatabase) {
  start_sim();
  const Child& first = start_daemon(config());
  json second = config();
  second["socket"] = file("other.sock");
  Child& refused = launch_daemon(second, "d2");
  EXPECT_NE(refused.wait(10s).value_or(0), 0);
  EXPECT_THAT(refused.log(), HasSubstr(std::to_string(first.pid())));
}

TEST_F(Faults, NoRightsOnTheDatabase) {
  start_sim();
  ASSERT_EQ(::mkdir(file("archive").c_str(), 0500), 0);
  json locked = config();
  locked["database"] = file("archive/lcrig.db");
  Child& refused = launch_daemon(locked, "d1", Child::Rights::those_of_the_files);
  EXPECT_NE(refused.wait(10s).value_or(0), 0);
  EXPECT_THAT(refused.log(), HasSubstr(file("archive")));
}

TEST_F(Faults, TwoDaemonsOnOneSocket) {
  start_sim();
  start_daemon(config());
  json second = config();
  second["database"] = file("other.db");
  Child& refused = launch_daemon(second, "d2");
  EXPECT_NE(refused.wait(10s).value_or(0), 0);
  EXPECT_THAT(refused.log(), HasSubstr(file("control.sock")));
  EXPECT_TRUE(control().call("status").contains("result")) << "the first one lost its socket";
}

TEST_F(Faults, ASecondClientOfTheFrameIsSentAway) {
  start_sim();
  auto client = ramp();
  json second = config();
  second["database"] = file("other.db");
  second["socket"] = file("other.sock");
  start_daemon(second, "d2");
  Control other(file("other.sock"));
  const json answer = start_run(other, kQuickProtocol);
  EXPECT_TRUE(answer.contains("error")) << answer;
  EXPECT_TRUE(client->call("run.abort").contains("result")) << "the first run lives";
  EXPECT_EQ(client->run_ended().value("exit_status", ""), "abort");
}

}  // namespace
}  // namespace lcrig::e2e
