// SPDX-License-Identifier: Apache-2.0
// The runner of the queue, with a host that has no rig: it asks for turns and stores their ends.
#include "daemon/queue/runner.hpp"

#include <gmock/gmock.h>

#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Every turn ends at once, in the way that the test sets.
class Host final : public QueueHost {
 public:
  bool is_running() const override { return false; }
  Task<Result<EntryPlan>> plan_entry(RunRequest& run, PlanOn) override {
    if (run.protocol_text.empty()) co_return fail(Errc::invalid_request, "no text");
    EntryPlan out;
    out.duration_s = 60;
    co_return out;
  }
  Task<TurnEnd> take_turn(TurnOfQueue turn) override {
    turns.push_back(turn.entry);
    TurnEnd out;
    RunOutcome ended;
    ended.exit_status = ExitStatus::success;
    out.outcome = ended;
    out.hazard = hazard;
    co_return out;
  }
  double left_s() const override { return 0; }
  void forget_identities() override { ++forgotten; }
  Task<std::string> name_of(const PeerCredentials& peer) override { co_return peer.user; }
  void queue_changed(const QueueStatus& status) override { last = status; }

  std::vector<std::int64_t> turns;
  std::optional<Hazard> hazard;  // of each turn
  int forgotten = 0;
  QueueStatus last;
};

class Runner : public AppPartsTest {
 protected:
  void SetUp() override {
    AppPartsTest::SetUp();
    ada_.user = "ada";
    auto db = open_read_write(database).value();
    ASSERT_FALSE(runner.open(db).value()) << "it was not going";
    begin(runner.run());
  }
  void TearDown() override {
    runner.end();
    AppPartsTest::TearDown();
    EXPECT_TRUE(runner.over());
  }
  std::int64_t add() {
    QueueAdd wanted;
    wanted.run = one_level();
    const auto added = run(runner.add(std::move(wanted), ada_));
    EXPECT_TRUE(added) << added.error().what;
    return added ? added->entry : 0;
  }
  void start() {
    ASSERT_TRUE(run(runner.start(HeadChoice::none, ada_)));
    ASSERT_EQ(runner.status().gate, QueueGate::specimen) << runner.status().why;
    ASSERT_TRUE(run(runner.answer("paper-1", std::nullopt, ada_)));
    pass(std::chrono::seconds(30));
  }

  Host host;
  QueueRunner runner{io.get_executor(), clock, host, database, ""};
  PeerCredentials ada_;
};

TEST_F(Runner, BeginsNothingBeforeAPersonStartsIt) {
  add();
  pass(std::chrono::minutes(5));
  EXPECT_TRUE(host.turns.empty());
  EXPECT_EQ(runner.status().count, 1);
  EXPECT_EQ(runner.status().cause, HoldCause::not_started);
}

TEST_F(Runner, TakesEntriesInTheirOrderAndEndsEmpty) {
  const auto first = add(), second = add();
  QueuePlace place;
  place.where = QueuePlace::Where::first;
  ASSERT_TRUE(run(runner.move(second, place, ada_)));
  start();
  // A second consent, because each turn that moves the frame needs a person.
  ASSERT_TRUE(run(runner.answer("yes", std::nullopt, ada_)));
  pass(std::chrono::seconds(30));
  EXPECT_THAT(host.turns, ElementsAre(second, first));
  EXPECT_EQ(host.forgotten, 1) << "a person said which instruments are right";
  EXPECT_EQ(runner.status().cause, HoldCause::empty);
  EXPECT_EQ(host.last.count, 0);
}

TEST_F(Runner, HoldsAfterAHazard) {
  host.hazard = Hazard::left_loaded;
  const auto first = add();
  add();
  start();
  EXPECT_THAT(host.turns, ElementsAre(first));
  EXPECT_FALSE(runner.goes());
  EXPECT_EQ(runner.status().cause, HoldCause::left_loaded);
  EXPECT_THAT(runner.status().why, HasSubstr("may still be loaded"));
}

TEST_F(Runner, LeavesALockedQueueToWhoLockedIt) {
  const auto entry = add();
  ada_.uid = 1;
  ASSERT_TRUE(run(runner.lock("night", ada_)));
  PeerCredentials bob;
  bob.user = "bob";
  bob.uid = 2;
  EXPECT_THAT(run(runner.remove(entry, bob)).error().what, HasSubstr("locked by ada (night)"));
  EXPECT_TRUE(run(runner.hold("", bob))) << "no lock is in the way";
  EXPECT_TRUE(run(runner.unlock(true, bob)));
  EXPECT_TRUE(run(runner.remove(entry, bob)));
}

}  // namespace
}  // namespace lcrig::support
