// SPDX-License-Identifier: Apache-2.0
// What `lcrig status` and `lcrig watch` say between runs, for every state of the queue: what it
// waits for, who has to act, and the command.
#include <gmock/gmock.h>

#include "base/spawn.hpp"
#include "tests/unit/tools/served.hpp"
#include "tools/lcrig/queue_words.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

QueueStatus held(HoldCause cause, std::int64_t count = 3) {
  QueueStatus out;
  out.cause = cause;
  out.why = "because of " + std::string(to_string(cause));
  out.count = count;
  return out;
}

QueueStatus waiting(QueueGate gate) {
  QueueStatus out;
  out.going = true;
  out.count = 3;
  out.entry = 7;
  out.gate = gate;
  out.prompt = "entry 7: at the gate " + std::string(to_string(gate));
  return out;
}

// The next command in the state: the truth of this table is docs/queue.md.
const char* expected_next(const QueueStatus& q) {
  if (q.going) {
    if (q.gate == QueueGate::time || !q.gate) return "";
    return q.gate == QueueGate::person ? "next: lcrig queue answer yes"
                                       : "next: lcrig queue answer NAME";
  }
  switch (*q.cause) {
    case HoldCause::not_started:
    case HoldCause::person: return "next: lcrig queue start";
    case HoldCause::empty: return "";
    default: return "next: lcrig queue list";
  }
}

class QueueWords : public support::Served {
 protected:
  std::string said_by(const char* command) {
    if (std::string(command) == "watch")
      on_server([this] { spawn(io.get_executor(), end_soon()); });
    EXPECT_EQ(cli.run({command}), 0) << cli.err.str();
    return cli.out.str() + cli.err.str();
  }
  Task<> end_soon() {
    while (!server.watched()) co_await clock.wait_for(1ms);
    server.publish_run_ended(ended);
  }
  void expect(const QueueStatus& q, const std::string& reason) {
    on_server([&] { handler.state.queue = q; });
    for (const char* command : {"status", "watch"}) {
      const auto said = said_by(command);
      EXPECT_THAT(said, HasSubstr("no run in progress" + reason)) << command;
      const std::string next = expected_next(q);
      if (next.empty()) {
        EXPECT_THAT(said, Not(HasSubstr("next: lcrig queue"))) << command << reason;
      } else {
        EXPECT_THAT(said, HasSubstr(next)) << command << reason;
      }
    }
  }
};

TEST_F(QueueWords, AHeldQueueSaysWhyAndHowItGoesOn) {
  for (const auto& [word, cause] : word_table<HoldCause>()) {
    if (cause == HoldCause::empty) continue;
    expect(held(cause), ": the queue is held: because of " + std::string(word));
  }
  expect(held(HoldCause::empty, 0), "");
}

TEST_F(QueueWords, AGateSaysWhatItWaitsForWhoHasToActAndTheCommand) {
  for (const auto& [word, gate] : word_table<QueueGate>()) {
    const std::string who = gate == QueueGate::time ? "a time" : "a person";
    expect(waiting(gate),
           ": the queue waits for " + who + ": entry 7: at the gate " + std::string(word));
  }
}

TEST_F(QueueWords, AQueueThatIsAboutToStartARunSaysSo) {
  QueueStatus q;
  q.going = true;
  q.count = 2;
  expect(q, ": the queue is about to start the next one");
}

TEST_F(QueueWords, WithoutAQueueNothingIsSaidOfIt) {
  for (const char* command : {"status", "watch"}) {
    EXPECT_THAT(said_by(command), AllOf(HasSubstr("no run in progress"), Not(HasSubstr("queue"))));
  }
}

TEST_F(QueueWords, AMeterThatIsCorrectedIsNamed) {
  on_server([this] { handler.state.correcting = true; });
  for (const char* command : {"status", "watch"}) {
    EXPECT_THAT(said_by(command), HasSubstr("no run in progress: the meter's open or short"));
  }
}

// A gate that closes later is reported to those who watch already.
TEST_F(QueueWords, WhoWatchesIsToldOfEachChange) {
  on_server([this] {
    handler.state.queue = waiting(QueueGate::time);
    spawn(io.get_executor(), [](auto& t) -> Task<> {
      while (!t.server.watched()) co_await t.clock.wait_for(1ms);
      t.server.publish_queue(waiting(QueueGate::specimen));
      t.server.publish_queue(waiting(QueueGate::specimen));
      t.server.publish_run_ended(t.ended);
    }(*this));
  });
  EXPECT_EQ(cli.run({"watch"}), 0);
  const auto said = cli.err.str();
  const auto at = said.find("waits for a person: entry 7: at the gate specimen");
  EXPECT_NE(at, said.npos) << said;
  EXPECT_EQ(said.find("at the gate specimen", at + 60), said.npos) << "it is said once: " << said;
}

}  // namespace
}  // namespace lcrig
