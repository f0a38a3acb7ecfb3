// SPDX-License-Identifier: Apache-2.0
// Requests by people to begin a run, to continue one or to look at the rig, while there is a queue.
#include "daemon/app/run_requests.hpp"
#include "daemon/app/queue_turns.hpp"

#include <gmock/gmock.h>

#include "daemon/app/run_steering.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/rig/operator.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class Requests : public AppPartsTest {
 protected:
  Requests() {
    ada_.user = "ada";
    starter.set_guard([this](const Session& session) { return turns.may_begin(session); });
  }
  void SetUp() override {
    AppPartsTest::SetUp();
    ASSERT_TRUE(turns.open());
    begin(turns.run());
  }
  void TearDown() override {
    turns.runner()->end();
    AppPartsTest::TearDown();
  }
  void wait_for_end() {
    clock.run(io, [this] { return use.is_idle(); });
  }
  // One entry, whose turn comes as soon as the rig is free.
  void queue_one() {
    QueueAdd wanted;
    wanted.run = one_level();
    const auto added = run(turns.runner()->add(std::move(wanted), ada_));
    ASSERT_TRUE(added) << added.error().what;
  }
  void start_queue() { ASSERT_TRUE(run(turns.runner()->start(HeadChoice::none, ada_))); }
  // Makes a request while somebody has the rig, who gives it back only after the queue started.
  template <class T>
  Result<T> after_the_queue_was_started(Task<Result<T>> request) {
    queue_one();
    EXPECT_TRUE(run(use.claim(RigUse::State::asking)));
    std::optional<Result<T>> out;
    begin(keep(std::move(request), out));
    pass(1s);
    start_queue();
    EXPECT_TRUE(turns.goes());
    EXPECT_FALSE(out);
    use.give_back();
    clock.run(io, [&out] { return out.has_value(); });
    return std::move(*out);
  }
  std::int64_t requests_of(const std::string& method) const {
    return count("SELECT count(*) FROM event WHERE kind = 'request' AND detail LIKE '%" + method +
                 "%ada%'");
  }

  RunStarter starter = make_starter();
  std::string vfs_;
  QueueTurns turns{io.get_executor(), clock, {database, vfs_, use, starter, plans, callers, news}};
  RemoteOperator person_{io.get_executor()};
  RunSteering stops{clock, {use, callers, person_, turns, recorder}};
  RunRequests requests{
      io.get_executor(), clock, {database, rig, use, callers, writes, starter, turns}};
  PeerCredentials ada_;
};

TEST_F(Requests, StartARunInTheNameOfWhoAsks) {
  const auto started = run(requests.start_run(one_level(), ada_));
  ASSERT_TRUE(started) << started.error().what;
  EXPECT_EQ(use.state(), RigUse::State::running);
  const auto second = run(requests.start_run(one_level(), ada_));
  EXPECT_THAT(second.error().what, HasSubstr("one run at a time"));
  wait_for_end();
  EXPECT_EQ(use.last_run()->exit_status, ExitStatus::success) << use.last_run()->reason;
  EXPECT_EQ(count("SELECT count(*) FROM run WHERE operator = 'ada'"), 1);
  EXPECT_EQ(requests_of("run.start"), 1);
}

TEST_F(Requests, GiveTheRigBackWhenTheProtocolIsBad) {
  RunRequest request = one_level();
  request.protocol_text = "{}";
  const auto started = run(requests.start_run(std::move(request), ada_));
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, Errc::invalid_request);
  EXPECT_TRUE(use.is_idle());
}

TEST_F(Requests, AreRefusedWhileTheQueueGoes) {
  queue_one();
  start_queue();
  EXPECT_THAT(run(requests.start_run(one_level(), ada_)).error().what, HasSubstr("the queue goes"));
  EXPECT_THAT(run(requests.resume(1, true, ada_)).error().what, HasSubstr("the queue goes"));
}

TEST_F(Requests, ToStartAreRefusedWhenTheQueueWasStartedMeanwhile) {
  const auto started = after_the_queue_was_started(requests.start_run(one_level(), ada_));
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, Errc::busy);
  EXPECT_THAT(started.error().what, HasSubstr("the queue goes"));
}

TEST_F(Requests, ToContinueAreRefusedWhenTheQueueWasStartedMeanwhile) {
  const auto started = after_the_queue_was_started(requests.resume(1, true, ada_));
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().what, HasSubstr("the queue goes"));
}

TEST_F(Requests, ToGoOnConcernThePausedRun) {
  EXPECT_THAT(run(requests.resume(std::nullopt, false, ada_)).error().what,
              HasSubstr("no such run is paused"));
  const auto started = run(requests.start_run(one_level(), ada_));
  ASSERT_TRUE(started) << started.error().what;
  EXPECT_THAT(run(requests.resume(started->run, false, ada_)).error().what,
              HasSubstr("is not paused"));
  pass(1s);
  ASSERT_TRUE(run(stops.pause(ada_)));
  clock.run(io, [this] { return use.live_run()->progress().state == RunState::paused; });
  EXPECT_THAT(run(requests.resume(started->run + 1, false, ada_)).error().what,
              HasSubstr("no such run is paused"));
  const auto going = run(requests.resume(std::nullopt, false, ada_));
  ASSERT_TRUE(going) << going.error().what;
  EXPECT_EQ(going->run, started->run);
  wait_for_end();
  EXPECT_EQ(use.last_run()->exit_status, ExitStatus::success) << use.last_run()->reason;
  EXPECT_EQ(requests_of("run.resume"), 1);
}

TEST_F(Requests, ToContinueWantARunThatWasCutOff) {
  const auto started = run(requests.start_run(one_level(), ada_));
  ASSERT_TRUE(started) << started.error().what;
  wait_for_end();
  const auto again = run(requests.resume(started->run, true, ada_));
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().what, HasSubstr("only a run that was interrupted"));
  EXPECT_TRUE(use.is_idle());
}

// The database as a crash leaves it during the run, and the daemon that finds it.
TEST_F(Requests, ContinueARunThatWasCutOff) {
  const auto started = run(requests.start_run(one_level(), ada_));
  ASSERT_TRUE(started) << started.error().what;
  pass(3s);
  const std::string cut = dir.file("cut.db");
  ASSERT_TRUE(open_read_write(database)->execute("VACUUM INTO '" + cut + "'"));
  ASSERT_TRUE(run(stops.freeze("look", ada_)));
  wait_for_end();
  database = cut;
  recorder.reset();
  recorder = std::move(Recorder::open(io, clock, Recorder::Options(database)).value());
  const auto again = run(requests.resume(started->run, true, ada_));
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_GT(again->run, started->run);
  wait_for_end();
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'continues'"), 1);
  EXPECT_EQ(requests_of("run.resume"), 1);
  EXPECT_EQ(count("SELECT count(*) FROM run_note WHERE run_id = 1"), 1) << "it says by which run";
}

TEST_F(Requests, ToPlanOrToAskLeaveTheRigFree) {
  ASSERT_TRUE(run(requests.plan_run(one_level(), ada_)));
  EXPECT_TRUE(use.is_idle());
  ASSERT_TRUE(run(requests.ask_instruments(ada_)));
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(count("SELECT count(*) FROM run"), 0);
}

}  // namespace
}  // namespace lcrig::support
