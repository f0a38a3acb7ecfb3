// SPDX-License-Identifier: Apache-2.0
// kill -9 at random instants: nothing that was acknowledged is missing, the frame is made safe
// first, and the run continues in a new run. Five kills by default; for more:
//   LCRIG_KILLS=200 e2e_tests --gtest_filter='Kills.*'.
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <map>
#include <random>

#include "storage/chain.hpp"
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

int kills_wanted() {
  const char* text = std::getenv("LCRIG_KILLS");
  int n = 5;
  if (text != nullptr) std::from_chars(text, text + std::strlen(text), n);
  return n;
}

struct Acknowledged {
  std::int64_t readings = 0, samples = 0;
};

class Kills : public Rig {
 protected:
  // Continues the last run if possible, otherwise starts another one. Returns its number.
  std::int64_t begin(Control& client, std::int64_t interrupted) {
    if (interrupted > 0) {
      const json answer =
          client.call("run.resume", {{"run", interrupted}, {"confirm_specimen", true}});
      if (answer.contains("result")) {
        ++resumed_;
        return answer["result"].value("run", std::int64_t{0});
      }
      // The only valid refusals: there is nothing to continue, or nobody can confirm the zero.
      EXPECT_THAT(answer.dump(),
                  testing::AnyOf(HasSubstr("in `finally`"), HasSubstr("before its first step"),
                                 HasSubstr("interrupted while it zeroed")));
    }
    const json answer = start_run(client, kSlowProtocol);
    EXPECT_TRUE(answer.contains("result")) << answer;
    return answer.contains("result") ? answer["result"].value("run", std::int64_t{0}) : 0;
  }

  static void note(const json& news, std::map<std::int64_t, Acknowledged>& shown) {
    if (news.value("method", "") != "status") return;
    const json& s = news["params"];
    Acknowledged& a = shown[s.value("run", std::int64_t{0})];
    a.readings = std::max(a.readings, s.value("lcr_readings", std::int64_t{0}));
    a.samples = std::max(a.samples, s.value("frame_samples", std::int64_t{0}));
  }

  void expect_whole(std::int64_t run, const Acknowledged& shown) {
    const std::string of_run = " WHERE run_id = " + std::to_string(run);
    const auto missing_readings =
        shown.readings - static_cast<std::int64_t>(
                             number("SELECT count(*) FROM lcr_reading" + of_run + " AND fresh"));
    const auto missing_samples =
        shown.samples -
        static_cast<std::int64_t>(number("SELECT count(*) FROM frame_sample" + of_run));
    EXPECT_LE(missing_readings, 0) << "run " << run;
    EXPECT_LE(missing_samples, 0) << "run " << run;
    acknowledged_ += shown.readings + shown.samples;
    missing_ +=
        std::max<std::int64_t>(0, missing_readings) + std::max<std::int64_t>(0, missing_samples);
    auto db = open_read_only(file("lcrig.db"));
    ASSERT_TRUE(db);
    const auto chain = verify_chain(*db, run);
    ASSERT_TRUE(chain);
    EXPECT_TRUE(chain->intact) << "run " << run << ": " << chain->finding;
  }

  int resumed_ = 0;
  std::int64_t acknowledged_ = 0, missing_ = 0;
};

TEST_F(Kills, AtRandomInstantsLoseNothingAndTheRunGoesOn) {
  start_sim();
  std::mt19937 random(20261121);
  std::uniform_int_distribution<int> instant_ms(0, 2500);
  std::map<std::int64_t, Acknowledged> shown;
  std::int64_t last = 0;
  const int kills = kills_wanted();
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE(i);
    Child& daemon = start_daemon(config(), "d" + std::to_string(i));
    Control client = control();
    client.call("watch");
    last = begin(client, last);
    ASSERT_GT(last, 0);
    for (const json& news : client.listen(std::chrono::milliseconds(instant_ms(random)))) {
      note(news, shown);
    }
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.wait(5s), 128 + SIGKILL);
    for (const json& news : client.drain()) note(news, shown);
    daemons_.clear();
  }
  EXPECT_FALSE(sim("settle").value("moving", true));
  start_daemon(config(), "last");
  Control client = control();
  client.call("status");
  for (const auto& [run, acknowledged] : shown) expect_whole(run, acknowledged);
  EXPECT_EQ(query("SELECT DISTINCT exit_status FROM run_end"), "interrupted\n");
  EXPECT_GT(acknowledged_, kills);
  EXPECT_GT(resumed_, 0);
  std::printf("%d kills, %d resumed: %lld acknowledged rows, %lld missing\n", kills, resumed_,
              static_cast<long long>(acknowledged_), static_cast<long long>(missing_));
}

// The whole process is stopped, so nothing may report that it works. Hangs inside the process are
// tested in tests/unit/daemon and tests/scenario.
TEST_F(Kills, TheServiceManagerHearsOfAWorkingDaemonAndOfNoStoppedOne) {
  start_sim();
  daemon_variables_["WATCHDOG_USEC"] = "400000";
  const NotifySocket manager(file("d1.notify"));
  Child& daemon = launch_daemon(config(), "d1");
  ASSERT_TRUE(manager.wait("READY=1", 20s)) << daemon.log();
  Control client = control();
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(manager.wait("WATCHDOG=1", 2s)) << i;
  daemon.signal(SIGSTOP);
  while (manager.wait("WATCHDOG=1", 300ms)) continue;  // sent before it was stopped
  EXPECT_FALSE(manager.wait("WATCHDOG=1", 1s));
  daemon.signal(SIGCONT);
  EXPECT_TRUE(manager.wait("WATCHDOG=1", 5s));
}

TEST_F(Kills, TheFrameIsMadeSafeFirstEvenWithoutAMeter) {
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "away"; });
  daemon.signal(SIGKILL);
  daemon.wait(5s);
  sim("unplug lcr");
  start_daemon(config(), "d2");
  Control again = control();
  // A start waits until the frame is safe. This one then fails because the meter is absent.
  EXPECT_TRUE(start_run(again, kQuickProtocol).contains("error"));
  EXPECT_FALSE(sim("status").value("moving", true));
  EXPECT_THAT(query("SELECT text FROM run_note WHERE run_id = 1"),
              HasSubstr("the frame confirmed standstill"));
}

// Another program may hold the database, or the disk may be full. The frame must not wait for
// either.
TEST_F(Kills, TheFrameIsMadeSafeBeforeTheDatabaseIsOpened) {
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "away"; });
  daemon.signal(SIGKILL);
  daemon.wait(5s);
  {
    const auto db = open_read_write(file("lcrig.db"));
    ASSERT_TRUE(db) << db.error().what;
    const auto held = Transaction::begin(*db);
    ASSERT_TRUE(held) << held.error().what;
    Child& refused = launch_daemon(config(), "d2");
    EXPECT_EQ(refused.wait(30s), 1) << refused.log();
    EXPECT_THAT(refused.log(), HasSubstr("the frame confirmed standstill"));
    EXPECT_FALSE(sim("status").value("moving", true));
  }
  start_daemon(config(), "d3");
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "interrupted\n");
}

TEST_F(Kills, AResumedRunAsksForTheSpecimenAndGoesOnAtItsStep) {
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", [](const json& s) {
    return s.value("step", "") == "away" && s.value("lcr_readings", 0) > 5;
  });
  daemon.signal(SIGKILL);
  daemon.wait(5s);
  sim("settle");
  const Child& second = start_daemon(config(), "d2");
  EXPECT_THAT(lcrig({"status", "--socket", file("control.sock")}).out,
              HasSubstr("interrupted: run 1, slow on paper-1, in step away; lcrig resume 1"));
  const Ended resumed = lcrig({"resume", "--socket", file("control.sock")});
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("run 2 continues run 1"));
  Control again = control();
  again.call("watch");
  const json waiting = again.wait_for(
      "status", [](const json& s) { return s.value("state", "") == "waiting_for_operator"; });
  EXPECT_THAT(waiting.value("prompt", ""), HasSubstr("step away"));
  EXPECT_FALSE(sim("status").value("moving", true)) << "it moves before anybody looked";
  EXPECT_EQ(lcrig({"confirm", "--socket", file("control.sock")}).code, 0);
  again.wait_for("status", [](const json& s) { return s.value("step", "") == "away"; });
  EXPECT_EQ(query("SELECT step_id FROM event WHERE run_id = 2 AND kind = 'step_begin'"), "away\n")
      << "steps that were done are not done again";
  again.call("run.abort");
  EXPECT_EQ(again.run_ended().value("exit_status", ""), "abort");
  EXPECT_EQ(query("SELECT detail FROM event WHERE kind = 'step_end' AND step_id = 'clear'"),
            "done\n")
      << "the gap of the first run is known to the second";
  EXPECT_THAT(query("SELECT text FROM run_note WHERE run_id = 1"), HasSubstr("continued by run 2"));
  EXPECT_THAT(second.log(), HasSubstr("run 1: continued by run 2"));
  // The database is neither the daemon's default nor the user's own.
  const Ended noted =
      lcrig({"runs", "note", "2", "looked at it", "--socket", file("control.sock")});
  EXPECT_EQ(noted.code, 0) << noted.err;
  EXPECT_THAT(lcrig({"runs", "show", "2", "--socket", file("control.sock")}).out,
              HasSubstr("looked at it"));
  EXPECT_EQ(lcrig({"verify", "2", "--socket", file("control.sock")}).code, 0);
  // A run can be continued only once.
  const json twice = again.call("run.resume", {{"run", 1}, {"confirm_specimen", true}});
  EXPECT_THAT(twice.dump(), HasSubstr("was continued by run 2"));
}

}  // namespace
}  // namespace lcrig::e2e
