// SPDX-License-Identifier: Apache-2.0
// The frame after a daemon that died, and the instruments while nothing runs.
#include "daemon/app/rig_watch.hpp"

#include "storage/runs.hpp"
#include "tests/support/app_parts.hpp"

namespace lcrig::support {
namespace {

using namespace std::chrono_literals;

class Rescue : public AppPartsTest {
 protected:
  void SetUp() override {}
  // Opens the database. With `orphan` it contains a run without an end.
  void open(bool orphan) {
    if (orphan) {
      const auto db = open_read_write(database).value();
      RunRow row;
      row.protocol_text = "unreadable, which counts as one that commands";
      ASSERT_TRUE(insert_run(db, row));
    }
    AppPartsTest::SetUp();
    known.declare(Instrument::lcr, "serial:x", "not yet", false);
    watcher.look_at_orphans();
  }
  std::int64_t notes() const {
    return count("SELECT count(*) FROM run_note WHERE text LIKE '%confirmed standstill%'");
  }
  void watch() { begin(watcher.ask()); }

  RigWatch watcher{clock, {database, rig, known, use, recorder, writes}};
};

TEST_F(Rescue, AsksTheFrameUntilItStandsAndNotesIt) {
  open(true);
  rig.stands = false;
  EXPECT_FALSE(run(watcher.make_safe()));
  EXPECT_EQ(notes(), 0);
  rig.stands = true;
  EXPECT_TRUE(run(watcher.make_safe()));
  EXPECT_EQ(notes(), 1);
  EXPECT_TRUE(run(watcher.make_safe()));
  EXPECT_EQ(rig.stops, 2) << "it stands already";
}

TEST_F(Rescue, AsksNoFrameThatNobodyLeftMoving) {
  open(false);
  EXPECT_TRUE(run(watcher.make_safe()));
  EXPECT_EQ(rig.stops, 0);
}

TEST_F(Rescue, AsksNoSimulatedFrame) {
  rig.real = false;
  EXPECT_FALSE(watcher.may_be_left());
  open(true);
  EXPECT_TRUE(run(watcher.make_safe()));
  EXPECT_EQ(rig.stops, 0);
}

Task<bool> stop_first(RigWatch& watcher) {
  co_await watcher.stop_first();
  co_return true;
}

TEST_F(Rescue, BeforeTheDatabaseIsOpenCounts) {
  run(stop_first(watcher));
  EXPECT_EQ(rig.stops, 1);
  open(true);
  EXPECT_TRUE(run(watcher.make_safe()));
  EXPECT_EQ(rig.stops, 1) << "not twice";
  EXPECT_EQ(notes(), 1);
}

TEST_F(Rescue, OfAFrameThatDoesNotStandIsTriedEveryTenSeconds) {
  open(true);
  rig.stands = false;
  rig.asked = [this] { known.answered(Instrument::lcr, Identity(), Learned(LearnedBy::look)); };
  watch();
  pass(35s);
  EXPECT_EQ(rig.stops, 4);
  rig.stands = true;
  pass(65s);
  EXPECT_EQ(rig.stops, 5);
}

TEST_F(Rescue, TheMeterIsAskedOftenUntilItAnswersAndThenEveryMinute) {
  open(false);
  rig.asked = [this] {
    const Error absent(Errc::disconnected, "no such port");
    known.failed(Instrument::lcr, absent, Learned(LearnedBy::look));
  };
  watch();
  pass(35s);
  EXPECT_EQ(rig.asks, 4);
  rig.asked = [this] { known.answered(Instrument::lcr, Identity(), Learned(LearnedBy::look)); };
  pass(10s);
  const int before = rig.asks;
  pass(150s);
  EXPECT_EQ(rig.asks, before + 2);
}

TEST_F(Rescue, NobodyAsksWhileARunIsPreparedOrGoesOn) {
  open(false);
  rig.asked = [this] { known.answered(Instrument::lcr, Identity(), Learned(LearnedBy::look)); };
  watch();
  begin(watcher.watch_ports());
  pass(1s);
  use.enter(RigUse::State::running);
  const int before = rig.asks;
  pass(300s);
  EXPECT_EQ(rig.asks, before);
  EXPECT_GT(rig.looks, 250) << "no session has the ports";
  use.give_back();
  pass(1s);
  EXPECT_EQ(rig.asks, before + 1);
}

}  // namespace
}  // namespace lcrig::support
