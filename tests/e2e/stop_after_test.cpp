// SPDX-License-Identifier: Apache-2.0
// `lcrig stop --after` and `lcrig pause --at`, with programs as processes.
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kCycles = R"({ "format": "load-protocol/1", "name": "cycles",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02, "back_off_mm": 0.1, "timeout_s": 60 },
    { "id": "cycle", "do": "repeat", "count": 50, "steps": [
      { "id": "load", "do": "move_until", "until": { "force_N": 0.3 }, "speed_mm_s": 0.2, "overshoot_N": 0.5, "timeout_s": 60 },
      { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.1 }, "speed_mm_s": 0.2, "timeout_s": 60 } ] } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -0.2 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

class StopAfter : public Rig {
 protected:
  Ended ask(std::vector<std::string> words) {
    words.insert(words.end(), {"--socket", file("control.sock")});
    return lcrig(std::move(words));
  }
};

TEST_F(StopAfter, TheCycleIsFinishedAndTheRunSaysSo) {
  start_sim();
  start_daemon(config());
  const Ended nothing = ask({"stop", "--after", "cycle"});
  EXPECT_EQ(nothing.code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("no run is going on"));
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kCycles).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("repeat", 0) == 2; });
  const Ended paused = ask({"pause", "--at", "cycle"});
  EXPECT_EQ(paused.code, 0) << paused.err;
  EXPECT_THAT(paused.out, HasSubstr("it pauses at the end of the cycle (step unload)"));
  client.wait_for("status", [](const json& s) { return s.value("state", "") == "paused"; });
  sim("settle");
  const Ended stopped = ask({"stop", "--after", "cycle", "--why", "tea"});
  EXPECT_EQ(stopped.code, 0) << stopped.err;
  EXPECT_THAT(stopped.out, AllOf(HasSubstr("it stops at the end of the cycle (step unload)"),
                                 HasSubstr("goes on with `lcrig resume`")));
  EXPECT_EQ(ask({"resume"}).code, 0);
  const json ended = client.run_ended(30s);
  EXPECT_EQ(ended.value("exit_status", ""), "stopped");
  EXPECT_THAT(ended.value("reason", ""), HasSubstr("after the cycle, step unload: tea (by"));
  EXPECT_EQ(query("SELECT count(*) FROM event WHERE kind = 'step_begin' AND step_id = 'load'"),
            query("SELECT count(*) FROM event WHERE kind = 'step_end' AND step_id = 'unload' AND "
                  "detail = 'done'"));
  EXPECT_EQ(query("SELECT detail FROM event WHERE kind = 'step_end' AND step_id = 'clear'"),
            "done\n");
  EXPECT_THAT(ask({"runs"}).out, HasSubstr("stopped"));
  EXPECT_EQ(ask({"verify", "1"}).code, 0);
  const Ended resumed = ask({"resume", "1"});
  EXPECT_EQ(resumed.code, 1);
  EXPECT_THAT(resumed.err, HasSubstr("ended with `stopped`"));
}

TEST_F(StopAfter, WhoeverStartedTheRunIsToldByTheExitCode) {
  start_sim();
  start_daemon(config());
  write("protocol.json", kCycles);
  Child run({LCRIG_BIN "/lcrig", "run", file("protocol.json"), "--specimen", "paper-1", "--socket",
             file("control.sock")},
            file("run.log"), {{"HOME", file("home")}});
  Control client = control();
  client.call("watch");
  client.wait_for("status", [](const json& s) { return s.value("repeat", 0) == 1; });
  EXPECT_EQ(ask({"stop", "--after", "step"}).code, 0);
  EXPECT_EQ(run.wait(30s), 8);
  EXPECT_THAT(run.out().rest(5s), HasSubstr("run 1: stopped (after the step"));
}

}  // namespace
}  // namespace lcrig::e2e
