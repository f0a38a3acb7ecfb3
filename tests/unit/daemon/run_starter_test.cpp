// SPDX-License-Identifier: Apache-2.0
// Runs that begin or fail to, and stops by people in the meantime.
#include "daemon/app/run_starter.hpp"

#include <gmock/gmock.h>

#include <future>

#include "daemon/app/queue_turns.hpp"
#include "daemon/app/run_steering.hpp"
#include "daemon/rig/operator.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

class Starter : public AppPartsTest {
 protected:
  Starter() { ada_.user = "ada"; }
  Task<Result<RunStarted>> begin_one() {
    auto claimed = co_await use.claim(RigUse::State::starting);
    if (!claimed) co_return fail(claimed.error());
    auto request = one_level();
    auto prepared = co_await starter.read(std::move(request));
    co_return co_await starter.start(std::move(prepared));
  }
  void wait_for_end() {
    clock.run(io, [this] { return use.is_idle(); });
  }
  std::int64_t runs() const { return count("SELECT count(*) FROM run"); }

  RunStarter starter = make_starter();
  std::string vfs_;
  QueueTurns turns{io.get_executor(), clock, {database, vfs_, use, starter, plans, callers, news}};
  RemoteOperator person_{io.get_executor()};
  RunSteering stops{clock, {use, callers, person_, turns, recorder}};
  PeerCredentials ada_;
};

TEST_F(Starter, KeepsARunUntilItHasEnded) {
  std::vector<std::string> events;
  news.on_event([&events](const RunEvent& e) { events.emplace_back(e.kind.word()); });
  const auto started = run(begin_one());
  ASSERT_TRUE(started) << started.error().what;
  EXPECT_EQ(use.state(), RigUse::State::running);
  wait_for_end();
  ASSERT_TRUE(use.last_run());
  EXPECT_EQ(use.last_run()->run, started->run);
  EXPECT_EQ(use.last_run()->exit_status, ExitStatus::success) << use.last_run()->reason;
  EXPECT_THAT(events, testing::Contains("contact"));
  EXPECT_TRUE(plans.last_rig(false)) << "the queue plans on it";
}

TEST_F(Starter, GivesTheRigBackWhenItsPortsDoNotOpen) {
  rig.refuses = Error(Errc::disconnected, "no such port");
  const auto started = run(begin_one());
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().what, HasSubstr("no such port"));
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(runs(), 0);
}

TEST_F(Starter, BeginsNothingThatItsGuardRefuses) {
  starter.set_guard(
      [](const Session&) -> Result<> { return fail(Errc::refused, "another meter answered"); });
  const auto started = run(begin_one());
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, Errc::refused);
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(runs(), 0);
}

TEST_F(Starter, BeginsNothingThatWasStoppedWhileThePortsOpened) {
  rig.hangs = true;
  std::optional<Result<RunStarted>> started;
  begin(keep(begin_one(), started));
  pass(1s);
  const auto later = run(stops.stop_after(StopPlace::step, "", ada_));
  EXPECT_THAT(later.error().what, HasSubstr("lcrig abort"));
  const auto stopped = run(stops.abort("wrong specimen", ada_));
  ASSERT_TRUE(stopped);
  EXPECT_EQ(stopped->state, StopState::not_begun);
  rig.hangs = false;
  clock.run(io, [&started] { return started.has_value(); });
  ASSERT_FALSE(started->has_value());
  EXPECT_EQ(started->error().code, Errc::aborted);
  EXPECT_THAT(started->error().what, HasSubstr("wrong specimen (by ada)"));
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(runs(), 0);
}

TEST_F(Starter, PlansWithoutARun) {
  auto request = one_level();
  const auto plan = run(starter.plan(std::move(request)));
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_GT(plan->duration_s, 1);
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(runs(), 0);
}

TEST_F(Starter, LooksForASpecimenInTheDatabaseAndAmongThoseThatShip) {
  RunRequest wanted = one_level();
  wanted.specimen_text.clear();
  ASSERT_TRUE(starter.find_texts(wanted));
  EXPECT_EQ(wanted.specimen_text, one_level().specimen_text);
  wanted.specimen_text.clear();
  wanted.specimen_name = "nobody";
  EXPECT_THAT(starter.find_texts(wanted).error().what, HasSubstr("lcrig specimen list"));
}

TEST_F(Starter, AStopWithoutARunIsRefused) {
  EXPECT_EQ(run(stops.abort("", ada_)).error().code, Errc::invalid_request);
  EXPECT_EQ(run(stops.freeze("", ada_)).error().code, Errc::invalid_request);
  EXPECT_EQ(run(stops.pause(ada_)).error().code, Errc::invalid_request);
  EXPECT_EQ(run(stops.pause_at(StopPlace::step, ada_)).error().code, Errc::invalid_request);
}

TEST_F(Starter, AStopIsAnsweredWhenTheFrameStands) {
  ASSERT_TRUE(run(begin_one()));
  pass(3s);
  const auto frozen = run(stops.freeze("look", ada_));
  ASSERT_TRUE(frozen) << frozen.error().what;
  EXPECT_EQ(frozen->state, StopState::standing);
  EXPECT_THAT(frozen->note, HasSubstr("stays where it is"));
  wait_for_end();
  EXPECT_THAT(use.last_run()->reason, HasSubstr("look (by ada)"));
  EXPECT_EQ(count("SELECT count(*) FROM event WHERE kind = 'request' AND detail LIKE "
                  "'%run.freeze%ada%look%'"),
            1);
}

class Turns : public Starter {
 protected:
  Turns() {
    starter.set_guard([this](const Session& session) { return turns.may_begin(session); });
    news.on_event([this](const RunEvent& event) { turns.note(event); });
  }
  static TurnOfQueue turn() {
    TurnOfQueue out;
    out.entry = 1;
    out.run = one_level();
    out.compares = false;
    return out;
  }
};

TEST_F(Turns, OfAnEntryThatNobodyStartedBeginNothing) {
  const TurnEnd end = run(turns.take_turn(turn()));
  ASSERT_FALSE(end.outcome);
  EXPECT_THAT(end.outcome.error().what, HasSubstr("nobody has started it"));
  EXPECT_FALSE(end.hazard);
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(runs(), 0);
}

TEST_F(Turns, TellTheWorstThatHappenedInThem) {
  rig.hangs = true;
  std::optional<TurnEnd> ended;
  begin(keep(turns.take_turn(turn()), ended));
  pass(1s);
  turns.note(RunEvent(clock.now(), EventKind::limit, "", "force"));
  rig.hangs = false;
  clock.run(io, [&ended] { return ended.has_value(); });
  EXPECT_EQ(ended->hazard, Hazard::limit);
  EXPECT_FALSE(run(turns.take_turn(turn())).hazard) << "each has its own";
}

TEST_F(Turns, OfPortsThatDoNotOpenEndWithTheError) {
  rig.refuses = Error(Errc::disconnected, "no such port");
  const TurnEnd end = run(turns.take_turn(turn()));
  ASSERT_FALSE(end.outcome);
  EXPECT_EQ(end.outcome.error().code, Errc::disconnected);
  EXPECT_TRUE(use.is_idle());
}

TEST_F(Turns, ArePlannedOnceForTheSameRun) {
  RunRequest wanted = one_level();
  auto checked = run(turns.plan_entry(wanted, PlanOn::nothing));
  ASSERT_TRUE(checked) << checked.error().what;
  EXPECT_FALSE(checked->duration_s);
  EXPECT_EQ(rig.opened, 0) << "the request is only checked";
  ASSERT_TRUE(run(turns.plan_entry(wanted, PlanOn::rig))->duration_s);
  ASSERT_TRUE(run(turns.plan_entry(wanted, PlanOn::rig))->duration_s);
  EXPECT_EQ(rig.opened, 1);
}

TEST_F(Turns, ArePlannedOnTheRigAsItWasSeenWhileItIsUsed) {
  RunRequest wanted = one_level();
  ASSERT_TRUE(run(turns.plan_entry(wanted, PlanOn::rig))->duration_s);
  turns.forget_identities();
  ASSERT_TRUE(run(use.claim(RigUse::State::asking)));
  EXPECT_TRUE(run(turns.plan_entry(wanted, PlanOn::rig))->duration_s);
  EXPECT_EQ(rig.opened, 1);
}

class AppAnswers : public Turns {
 protected:
  RunSteering& answers = stops;
};

TEST_F(AppAnswers, WithoutAQuestionAreRefused) {
  EXPECT_THAT(run(answers.confirm(ada_)).error().what, HasSubstr("nothing waits"));
  EXPECT_THAT(run(answers.answer(AnswerRequest(), ada_)).error().what, HasSubstr("no run"));
}

TEST_F(AppAnswers, ConfirmWhatAPersonIsAskedFor) {
  std::optional<Result<>> asked;
  begin(keep(person_.confirm("put 100 g on the rod"), asked));
  io.poll();
  EXPECT_TRUE(run(answers.confirm(ada_)));
  clock.run(io, [&asked] { return asked.has_value(); });
  EXPECT_TRUE(*asked);
}

constexpr const char* kTwoQuestions = R"({ "format": "load-protocol/1", "name": "asks",
  "limits": {},
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1, "aperture": "fast" } },
  "steps": [
    { "id": "lid", "do": "ask", "text": "Close the lid.", "answer": "confirmation", "timeout_s": 600 },
    { "id": "probe", "do": "ask", "text": "Lower the probe.", "answer": "confirmation", "timeout_s": 600 },
    { "id": "rest", "do": "measure", "count": 3, "within_s": 2 } ],
  "finally": [] })";

// The look-up of one user's name takes until the test releases it.
class SlowName : public AppAnswers {
 protected:
  SlowName() {
    bob_.uid = 7;
    EXPECT_TRUE(named_.listen(dir.file("socket")));
  }
  void TearDown() override {
    begin(named_.close(1s));
    AppAnswers::TearDown();
  }
  // Ends once `name_bob` has been called.
  void confirm_slowly() {
    begin(keep(slow_.confirm(bob_), late_));
    io.poll();
    EXPECT_FALSE(late_);
  }
  Result<> name_bob() {
    known_.set_value();
    clock.run(io, [this] { return late_.has_value(); });
    return *late_;
  }
  ControlOptions options() {
    ControlOptions out;
    out.user_name = [known = std::shared_future<void>(known_.get_future())](std::uint32_t) {
      known.wait();
      return std::optional<std::string>("bob");
    };
    return out;
  }

  std::promise<void> known_;
  PeerCredentials bob_;
  std::optional<Result<>> late_;
  ControlServer named_{io.get_executor(), clock, handler, options()};
  Callers slow_callers_{clock, named_, recorder};
  RunSteering slow_{clock, {use, slow_callers_, person_, turns, recorder}};
};

TEST_F(SlowName, ConfirmsTheQuestionThatWasAskedWhenItCame) {
  rig.person = &person_;
  RunRequest request = one_level();
  request.protocol_text = kTwoQuestions;
  ASSERT_TRUE(run(use.claim(RigUse::State::starting)));
  const auto started = run(starter.start(prepare_run(std::move(request))));
  ASSERT_TRUE(started) << started.error().what;
  const auto asks = [this](std::int64_t number) {
    const auto& open = use.live_run()->question();
    return open && open->number == number;
  };
  clock.run(io, [&asks] { return asks(1); });
  confirm_slowly();
  ASSERT_TRUE(run(answers.confirm(ada_)));
  clock.run(io, [&asks] { return asks(2); });
  const auto late = name_bob();
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().what, HasSubstr("question 1 waits no more"));
  EXPECT_TRUE(asks(2));
  ASSERT_TRUE(run(answers.confirm(ada_)));
  wait_for_end();
  EXPECT_EQ(use.last_run()->exit_status, ExitStatus::success) << use.last_run()->reason;
}

TEST_F(SlowName, ConfirmsThePromptThatStoodWhenItCame) {
  std::optional<Result<>> first, second;
  begin(keep(person_.confirm("put 100 g on the rod"), first));
  io.poll();
  confirm_slowly();
  ASSERT_TRUE(run(answers.confirm(ada_)));
  clock.run(io, [&first] { return first.has_value(); });
  begin(keep(person_.confirm("put 200 g on the rod"), second));
  io.poll();
  const auto late = name_bob();
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().what, HasSubstr("nothing waits"));
  EXPECT_FALSE(second);
  ASSERT_TRUE(run(answers.confirm(ada_)));
  clock.run(io, [&second] { return second.has_value(); });
}

}  // namespace
}  // namespace lcrig::support
