// SPDX-License-Identifier: Apache-2.0
// `lcrig status --check`, for monitoring programs.
#include "tools/lcrig/status_check.hpp"

#include <gmock/gmock.h>

#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/unit/tools/served.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

InstrumentState instrument(InstrumentCondition condition, const char* why = "") {
  InstrumentState out;
  out.condition = condition;
  out.why = why;
  return out;
}

class StatusOfMonitoring : public ::testing::Test {
 protected:
  void begin_run() { status.run.emplace(); }
  Verdict verdict() const { return check_status(status).verdict; }
  std::string words() const { return check_status(status).words; }
  DaemonStatus status;
};

TEST_F(StatusOfMonitoring, IsInOrderWithARunAndWithout) {
  EXPECT_EQ(verdict(), Verdict::ok);
  EXPECT_EQ(words(), "no run in progress");
  status.instruments.push_back(instrument(InstrumentCondition::unasked));
  begin_run();
  EXPECT_EQ(verdict(), Verdict::ok);
  EXPECT_THAT(words(), HasSubstr("in progress"));
}

TEST_F(StatusOfMonitoring, AnInstrumentThatIsAwayIsWorseInARun) {
  for (const auto condition : {InstrumentCondition::absent, InstrumentCondition::fault}) {
    status = DaemonStatus();
    status.instruments.push_back(instrument(condition, "its port is not there"));
    EXPECT_EQ(verdict(), Verdict::warning);
    EXPECT_THAT(words(), HasSubstr("meter: its port is not there"));
    begin_run();
    EXPECT_EQ(verdict(), Verdict::critical);
  }
}

TEST_F(StatusOfMonitoring, OldDataOfARunAreCritical) {
  begin_run();
  status.instruments.push_back(instrument(InstrumentCondition::in_use));
  status.instruments[0].age_s = 3;
  EXPECT_EQ(verdict(), Verdict::ok);
  status.instruments[0].age_s = 30;
  EXPECT_EQ(verdict(), Verdict::critical);
  EXPECT_THAT(words(), HasSubstr("nothing heard for 30 s"));
}

TEST_F(StatusOfMonitoring, WhatWaitsForAPersonIsAWarning) {
  begin_run();
  status.run->prompt = "place 10 g";
  EXPECT_EQ(verdict(), Verdict::warning);
  EXPECT_THAT(words(), HasSubstr("place 10 g"));
  status.run->prompt.clear();
  status.run->state = RunState::paused;
  EXPECT_EQ(verdict(), Verdict::warning);
}

// Whatever state it is in: a stop that failed is no state of its own.
TEST_F(StatusOfMonitoring, AFrameThatMayMoveIsCriticalAndNamed) {
  for (const RunState state : {RunState::stopping, RunState::finishing, RunState::running}) {
    for (const Standstill alarm : {Standstill::not_confirmed, Standstill::unknown}) {
      begin_run();
      status.run->state = state;
      status.run->standstill = alarm;
      EXPECT_EQ(verdict(), Verdict::critical);
      EXPECT_THAT(words(), HasSubstr("frame: standstill"));
      EXPECT_THAT(words(), HasSubstr("E-stop"));
      status.run->standstill = Standstill::awaited;
      EXPECT_EQ(verdict(), Verdict::ok);
    }
  }
}

TEST_F(StatusOfMonitoring, AFailedRunIsAWarningUntilTheNextOneBegins) {
  status.last_run.emplace();
  status.last_run->exit_status = ExitStatus::abort;
  EXPECT_EQ(verdict(), Verdict::ok) << "somebody wanted it";
  status.last_run->stands = false;
  EXPECT_EQ(verdict(), Verdict::critical);
  status.last_run->stands = true;
  status.last_run->exit_status = ExitStatus::fail;
  EXPECT_EQ(verdict(), Verdict::warning);
  status.last_run->stands = false;
  EXPECT_EQ(verdict(), Verdict::critical);
  begin_run();
  EXPECT_EQ(verdict(), Verdict::ok);
}

TEST_F(StatusOfMonitoring, AFrameThatMayMoveAfterItsRunIsNamedUntilItStands) {
  status.last_run.emplace();
  status.last_run->run = 7;
  status.last_run->reason = "by root";
  status.last_run->stands = false;
  EXPECT_EQ(verdict(), Verdict::critical);
  EXPECT_THAT(words(), HasSubstr("frame: standstill not confirmed: use the E-stop"));
  status.last_run->stands = true;
  status.last_run->stood_after_s = 12;
  EXPECT_EQ(verdict(), Verdict::warning);
  EXPECT_THAT(words(), HasSubstr("the frame confirmed standstill 12 s after the end of the run"));
}

TEST_F(StatusOfMonitoring, StatesAReasonOnce) {
  const std::string why = "by root: the frame reports E-stop";
  status.instruments = {instrument(InstrumentCondition::unasked),
                        instrument(InstrumentCondition::fault, why.c_str())};
  status.last_run.emplace();
  status.last_run->reason = why;
  const std::string once = words();
  EXPECT_EQ(once.find(why), once.rfind(why)) << once;
  EXPECT_THAT(once, HasSubstr(why));
}

TEST_F(StatusOfMonitoring, AQueueIsJudgedByWhyItWaits) {
  status.queue.emplace();
  status.queue->cause = HoldCause::failure;
  EXPECT_EQ(verdict(), Verdict::ok) << "nothing is in it";
  status.queue->count = 3;
  EXPECT_EQ(verdict(), Verdict::warning);
  for (const auto wanted : {HoldCause::person, HoldCause::not_started}) {
    status.queue->cause = wanted;
    EXPECT_EQ(verdict(), Verdict::ok) << to_string(wanted);
  }
  status.queue->going = true;
  status.queue->gate = QueueGate::time;
  EXPECT_EQ(verdict(), Verdict::ok);
  status.queue->gate = QueueGate::specimen;
  status.queue->prompt = "put paper-2 on";
  EXPECT_EQ(verdict(), Verdict::warning);
  EXPECT_THAT(words(), HasSubstr("put paper-2 on"));
  status.queue->gate.reset();  // a gate that only a newer daemon knows
  EXPECT_EQ(verdict(), Verdict::warning);
}

TEST(StatusCheckWithoutADaemon, IsCritical) {
  support::Cli cli;
  EXPECT_EQ(cli.run({"status", "--check"}), 2);
  EXPECT_THAT(cli.out.str(), HasSubstr("LCRIG CRITICAL: "));
  EXPECT_EQ(cli.run({"status", "--check", "--json"}), 2);
  EXPECT_EQ(json::parse(cli.out.str())["check"], "CRITICAL");
}

TEST(StatusCheckOfAnotherProgram, IsUnknown) {
  support::Cli cli;
  const std::string path = cli.env.daemon_socket.string();
  asio::io_context io;
  asio::local::stream_protocol::acceptor acceptor(io, asio::local::stream_protocol::endpoint(path));
  std::thread other([&] {
    asio::local::stream_protocol::socket peer(io);
    acceptor.accept(peer);
    asio::write(peer, asio::buffer("garbage\n", 8));
    boost::system::error_code closed;
    char request[4096];
    while (peer.read_some(asio::buffer(request), closed) > 0) continue;
  });
  EXPECT_EQ(cli.run({"status", "--check"}), 3);
  other.join();
  EXPECT_THAT(cli.out.str(), HasSubstr("LCRIG UNKNOWN: "));
}

using StatusCheckOfADaemon = support::Served;

TEST_F(StatusCheckOfADaemon, IsOneLineAndItsExitCode) {
  EXPECT_EQ(cli.run({"status", "--check"}), 0) << cli.err.str();
  EXPECT_EQ(cli.out.str(), "LCRIG OK: no run in progress\n");
  on_server([this] {
    handler.state.instruments.push_back(instrument(InstrumentCondition::fault, "no answer"));
  });
  EXPECT_EQ(cli.run({"status", "--check"}), 1);
  EXPECT_EQ(cli.out.str(), "LCRIG WARNING: meter: no answer\n");
}

TEST_F(StatusCheckOfADaemon, MetricsAreThePageThatTheDaemonSends) {
  EXPECT_EQ(cli.run({"metrics"}), 0) << cli.err.str();
  EXPECT_EQ(cli.out.str(), "lcrig_run_active 0\n");
  EXPECT_EQ(cli.run({"metrics", "--json"}), 0);
  EXPECT_EQ(json::parse(cli.out.str())["text"], "lcrig_run_active 0\n");
}

}  // namespace
}  // namespace lcrig::cli
