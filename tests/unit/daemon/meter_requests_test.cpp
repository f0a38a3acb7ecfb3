// SPDX-License-Identifier: Apache-2.0
// Requests by people about the corrections of the meter: who may have the rig meanwhile, and that
// it is given back.
#include "daemon/app/meter_requests.hpp"
#include "daemon/app/queue_turns.hpp"

#include <gmock/gmock.h>

#include "daemon/queue/runner.hpp"
#include "daemon/rig/operator.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class RequestsToTheMeter : public AppPartsTest {
 protected:
  RequestsToTheMeter() { ada_.user = "ada"; }
  void SetUp() override {
    AppPartsTest::SetUp();
    ASSERT_TRUE(turns.open());
    begin(turns.run());
  }
  void TearDown() override {
    turns.runner()->end();
    AppPartsTest::TearDown();
  }

  RunStarter starter = make_starter();
  std::string vfs_;
  QueueTurns turns{io.get_executor(), clock, {database, vfs_, use, starter, plans, callers, news}};
  RemoteOperator person_{io.get_executor()};
  SimulatedRig bench_{io.get_executor(), clock, "paper", known, person_};
  MeterRequests requests{{io.get_executor(), clock, bench_, known, database, vfs_},
                         {use, callers, turns, notifier}};
  PeerCredentials ada_;
};

TEST_F(RequestsToTheMeter, MakeACorrectionWhileNobodyElseHasTheRig) {
  std::optional<Result<MeterCorrections>> made;
  begin(keep(requests.correct(CorrectionKind::open, ada_), made));
  pass(1s);
  EXPECT_EQ(use.state(), RigUse::State::correcting);
  const auto other = run(requests.look());
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Errc::busy);
  clock.run(io, [&made] { return made.has_value(); });
  ASSERT_TRUE(*made) << made->error().what;
  EXPECT_EQ((*made)->open.on, true);
  EXPECT_EQ((*made)->open.made_by, "ada");
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(count("SELECT count(*) FROM lcr_correction WHERE operator = 'ada'"), 1);
  const auto seen = run(requests.look());
  ASSERT_TRUE(seen) << seen.error().what;
  EXPECT_EQ(seen->open.made_unix_ns, (*made)->open.made_unix_ns);
  EXPECT_FALSE(seen->short_circuit.made_unix_ns);
  EXPECT_TRUE(use.is_idle());
}

TEST_F(RequestsToTheMeter, GiveTheRigBackWhenThereIsNoMeter) {
  MeterRequests none{{io.get_executor(), clock, rig, known, database, vfs_},
                     {use, callers, turns, notifier}};
  const auto made = run(none.correct(CorrectionKind::open, ada_));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Errc::unsupported);
  EXPECT_TRUE(use.is_idle());
  EXPECT_FALSE(run(none.look()));
  EXPECT_TRUE(use.is_idle());
  EXPECT_EQ(count("SELECT count(*) FROM lcr_correction"), 0);
}

TEST_F(RequestsToTheMeter, ComeAfterTheQueue) {
  QueueAdd wanted;
  wanted.run = one_level();
  ASSERT_TRUE(run(turns.runner()->add(std::move(wanted), ada_)));
  ASSERT_TRUE(run(turns.runner()->start(HeadChoice::none, ada_)));
  const auto made = run(requests.correct(CorrectionKind::open, ada_));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Errc::busy);
  EXPECT_THAT(made.error().what, HasSubstr("hold it first"));
}

TEST_F(RequestsToTheMeter, EndWithTheDaemon) {
  std::optional<Result<MeterCorrections>> made;
  begin(keep(requests.correct(CorrectionKind::open, ada_), made));
  pass(1s);
  requests.give_up();
  pass(1s);
  ASSERT_TRUE(made);
  ASSERT_FALSE(*made);
  EXPECT_EQ(made->error().code, Errc::aborted);
  EXPECT_TRUE(use.is_idle());
}

}  // namespace
}  // namespace lcrig::support
