// SPDX-License-Identifier: Apache-2.0
// The queue of a real daemon. It is filled and started from the command line, and killed in a gate,
// in a run and between runs. Three kills at random instants by default; for more:
//   LCRIG_KILLS=200 e2e_tests --gtest_filter='QueueKills.*'.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>

#include "base/clock.hpp"
#include "base/number.hpp"
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;
using testing::Not;

// A protocol that moves nothing, so that a busy computer is no reason to stop it.
constexpr const char* kPassive = R"({ "format": "load-protocol/1", "name": "passive",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [ { "id": "look", "do": "record", "for_s": 3 } ],
  "finally": [] })";

class QueueRig : public Rig {
 protected:
  void SetUp() override {
    Rig::SetUp();
    write("passive.json", kPassive);
    start_sim();
  }
  Child& daemon() { return start_daemon(config(), "d" + std::to_string(++started_)); }
  void kill(Child& daemon) {
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.wait(5s), 128 + SIGKILL);
    daemons_.clear();
  }
  Ended queue(std::vector<std::string> words) {
    words.insert(words.begin(), "queue");
    words.insert(words.end(), {"--socket", file("control.sock")});
    return lcrig(words);
  }
  void add(int entries) {
    for (int i = 0; i < entries; ++i) {
      const Ended added = queue({"add", file("passive.json"), "-s", "paper-1"});
      EXPECT_EQ(added.code, 0) << added.err;
    }
  }
  // Waits until the queue's status fits.
  void await(Control& client, const std::function<bool(const json&)>& fits) {
    const json status = client.call("watch").at("result").at("queue");
    if (!fits(status)) client.wait_for("queue", fits, 60s);
  }
  static bool at_gate(const json& q) { return q.value("gate", "") == "specimen"; }
  static bool is_held(const json& q) { return !q.value("going", true); }

  int started_ = 0;
};

TEST_F(QueueRig, RunsADayFromTheCommandLine) {
  daemon();
  add(2);
  const Ended held = queue({"list"});
  EXPECT_THAT(held.out, HasSubstr("the queue is held: 2 entries"));
  EXPECT_THAT(held.out, Not(HasSubstr("passive.json"))) << "a protocol has a name of its own";
  const Ended idle = lcrig({"stop", "--after", "run", "--socket", file("control.sock")});
  EXPECT_EQ(idle.code, 0) << idle.err;
  EXPECT_EQ(idle.out, "the queue is held; no run in progress\n");
  EXPECT_EQ(queue({"start"}).code, 0);
  Control client = control();
  await(client, at_gate);
  EXPECT_THAT(queue({"list"}).out, HasSubstr("put paper-1 on"));
  const Ended wrong = queue({"answer", "paper-2"});
  EXPECT_NE(wrong.code, 0);
  EXPECT_THAT(wrong.err, HasSubstr("nothing moves"));
  EXPECT_EQ(queue({"answer", "paper-1"}).code, 0);
  await(client, is_held);
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "success\nsuccess\n");
  EXPECT_THAT(queue({"list"}).out, HasSubstr("nothing is left"));
  EXPECT_THAT(queue({"history"}).out, HasSubstr("begin 2"));
}

TEST_F(QueueRig, ATableOfRunsFromTheCommandLine) {
  daemon();
  write("day.csv",
        "specimen,repeats,protocol\npaper-1,2,static-frame\npaper-2,nought,static-frame\n"
        "paper-9,1,static-frame\n");
  const Ended wrong = queue({"add", "--batch", file("day.csv")});
  EXPECT_NE(wrong.code, 0);
  EXPECT_THAT(wrong.err, HasSubstr("day.csv:3:9 repeats"));
  EXPECT_THAT(wrong.err, HasSubstr("day.csv:4:1 specimen"));
  EXPECT_EQ(number("SELECT count(*) FROM queue_entry"), 0) << "a part of a wrong table";

  const std::string table = "specimen,protocol,repeats,note\npaper-1," + file("passive.json") +
                            ",2,first\npaper-2," + file("passive.json") + ",1,second\n";
  write("day.csv", table);
  const Ended added =
      queue({"add", "--batch", file("day.csv"), "--order", "blocks", "--seed", "7"});
  EXPECT_EQ(added.code, 0) << added.err;
  EXPECT_THAT(added.out, HasSubstr("batch day: entries 1 to 3, in blocks, seed 7"));
  const Ended again = queue({"add", "--batch", file("day.csv")});
  EXPECT_NE(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr("exists already"));
  EXPECT_THAT(again.err, HasSubstr("--name"));
  EXPECT_EQ(query("SELECT text FROM queue_text JOIN batch ON sha256 = file_sha256"), table + "\n")
      << "the table as it was written";

  EXPECT_EQ(queue({"start"}).code, 0);
  Control client = control();
  for (const char* specimen : {"paper-1", "paper-2"}) {
    await(client, [specimen](const json& q) {
      return at_gate(q) && q.value("prompt", "").find(specimen) != std::string::npos;
    });
    EXPECT_EQ(queue({"answer", specimen}).code, 0);
  }
  // The simulator still shows paper-1.
  await(client, [](const json& q) { return q.value("gate", "") == "stranger"; });
  EXPECT_EQ(queue({"answer", "paper-2"}).code, 0);
  await(client, is_held);
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "success\nsuccess\nsuccess\n");
  const Ended report =
      lcrig({"report", "--batch", "day", "--db", file("lcrig.db"), "-o", file("day.html")});
  EXPECT_EQ(report.code, 0) << report.err;
}

TEST_F(QueueRig, KilledInAGateItWaitsForAPerson) {
  Child& first = daemon();
  add(2);
  EXPECT_EQ(queue({"start"}).code, 0);
  Control client = control();
  await(client, at_gate);
  const std::string entry = queue({"show", "2", "--json"}).last_line().value("specimen", "");
  kill(first);
  // While no daemon runs, its database is read.
  const auto at_rest = [this](std::vector<std::string> words) {
    words.insert(words.end(), {"--db", file("lcrig.db")});
    return queue(words);
  };
  const Ended listed = at_rest({"list"});
  EXPECT_EQ(listed.code, 0) << listed.err;
  EXPECT_THAT(listed.out, HasSubstr("held: 2 entries; lcrigd does not run"));
  EXPECT_THAT(listed.err, HasSubstr("no daemon answers"));
  EXPECT_EQ(at_rest({"show", "2", "--json"}).last_line().value("specimen", "?"), entry);
  EXPECT_NE(at_rest({"show", "9"}).code, 0);
  EXPECT_THAT(at_rest({"history"}).out, HasSubstr("add 2"));
  daemon();
  const Ended late = queue({"answer", "paper-1"});
  EXPECT_NE(late.code, 0);
  EXPECT_THAT(late.err, HasSubstr("waits for no answer"));
  EXPECT_THAT(queue({"list"}).out, HasSubstr("held: 2 entries; lcrigd was restarted"));
  EXPECT_EQ(number("SELECT count(*) FROM run"), 0);
}

TEST_F(QueueRig, KilledInARunItAsksWhatBecomesOfIt) {
  Child& first = daemon();
  add(2);
  EXPECT_EQ(queue({"start"}).code, 0);
  {
    Control client = control();
    await(client, at_gate);
    EXPECT_EQ(queue({"answer", "paper-1"}).code, 0);
    client.wait_for("status", [](const json& s) { return s.value("step", "") == "look"; }, 60s);
  }
  const Ended last = lcrig({"stop", "--after", "run", "--socket", file("control.sock")});
  EXPECT_EQ(last.out, "the queue ends with the run in progress\n") << last.err;
  kill(first);
  daemon();
  const Ended none = queue({"start"});
  EXPECT_NE(none.code, 0);
  EXPECT_THAT(none.err, HasSubstr("--resume"));
  EXPECT_EQ(number("SELECT count(*) FROM run"), 1) << "nothing started by itself";
  EXPECT_EQ(queue({"start", "--repeat"}).code, 0);
  Control client = control();
  await(client, at_gate);
  EXPECT_EQ(queue({"answer", "paper-1"}).code, 0);
  await(client, is_held);
  EXPECT_EQ(query("SELECT state FROM queue_entry"), "done\ndone\n");
  EXPECT_EQ(query("SELECT exit_status FROM run_end ORDER BY run_id"),
            "interrupted\nsuccess\nsuccess\n");
}

class QueueKills : public QueueRig {
 protected:
  static int kills_wanted() {
    const char* text = std::getenv("LCRIG_KILLS");
    return number_from<int>(text == nullptr ? "" : text).value_or(3);
  }
  // Queues a batch of runs of two specimens in random order.
  void add_batch(int of_each) {
    const std::string run = "," + file("passive.json") + "," + std::to_string(of_each) + "\n";
    write("day.csv", "specimen,protocol,repeats\npaper-1" + run + "paper-2" + run);
    const Ended added =
        queue({"add", "--batch", file("day.csv"), "--order", "random", "--seed", "20261123"});
    EXPECT_EQ(added.code, 0) << added.err;
  }
  // Starts the queue with whatever consent its head needs, and counts the consents.
  void start(Control& client) {
    json answer = client.call("queue.start");
    if (answer.contains("error")) {
      const json head = client.call("queue.list", {{"most", 1}}).at("result").at("entries").at(0);
      ++repeats_[head.value("entry", std::int64_t{0})];
      answer = client.call("queue.start", {{"head", "repeat"}});
    }
    EXPECT_TRUE(answer.contains("result")) << answer;
  }
  // For this time, does what the gates ask for.
  void attend(Control& client, Timeout time) {
    const RealClock clock;
    for (const MonoTime end = clock.now() + time; clock.now() < end;) {
      const json status = client.call("status").at("result").at("queue");
      if (!status.value("gate", "").empty()) {  // a stranger, too: the simulator shows paper-1
        const json entry = client.call("queue.show", {{"entry", status.at("entry")}}).at("result");
        client.call("queue.answer", {{"text", entry.at("specimen")}});
      }
      const auto left = std::chrono::duration_cast<Timeout>(end - clock.now());
      client.listen(std::clamp(left, Timeout(0), Timeout(100)));
    }
  }

  std::map<std::int64_t, std::int64_t> repeats_;
};

TEST_F(QueueKills, AtRandomInstantsOfABatchLoseNoEntryAndBeginNoneByThemselves) {
  const int kills = kills_wanted();
  const int entries = 2 * kills;  // more than can be finished
  std::mt19937 random(20261123);
  std::uniform_int_distribution<int> instant_ms(0, 8000);
  {
    Child& first = daemon();
    add_batch(kills);
    kill(first);
  }
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE(i);
    Child& running = daemon();
    Control client = control();
    start(client);
    attend(client, Timeout(instant_ms(random)));
    kill(running);
  }
  daemon();
  Control client = control();
  client.call("status");
  EXPECT_EQ(number("SELECT count(*) FROM queue_entry"), entries) << "an entry is lost";
  EXPECT_EQ(number("SELECT count(*) FROM batch_entry"), entries);
  std::int64_t twice = 0;
  for (std::int64_t entry = 1; entry <= entries; ++entry) {
    const auto begun = static_cast<std::int64_t>(
        number("SELECT count(*) FROM queue_attempt WHERE entry_id = " + std::to_string(entry)));
    twice += std::max<std::int64_t>(0, begun - 1 - repeats_[entry]);
  }
  EXPECT_EQ(twice, 0) << "begun again without a word";
  EXPECT_EQ(number("SELECT count(*) FROM run"), number("SELECT count(*) FROM queue_attempt"));
  std::printf("%d kills: %.0f runs begun, %.0f entries done, %lld begun twice without a word\n",
              kills, number("SELECT count(*) FROM run"),
              number("SELECT count(*) FROM queue_entry WHERE state = 'done'"),
              static_cast<long long>(twice));
}

}  // namespace
}  // namespace lcrig::e2e
