// SPDX-License-Identifier: Apache-2.0
// Questions to people, with the programs as processes: at a terminal, with `lcrig answer`, and
// after the daemon died while one was open.
#include "tests/e2e/rig.hpp"
#include "tests/e2e/terminal.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

constexpr const char* kAsks = R"({ "format": "load-protocol/1", "name": "asks",
  "limits": { "force_N": [-0.2, 1.0], "travel_mm": [-5, 5], "speed_mm_s": 2 },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "internal" }, "frame": { "rate_Hz": 50 } },
  "steps": [
    { "id": "surface", "do": "ask", "text": "The surface", "answer": "choice", "choices": ["clean", "dusty"], "timeout_s": 600 },
    { "id": "thickness", "do": "ask", "text": "Thickness by gauge", "answer": "number", "range_um": [20, 400], "timeout_s": 600 },
    { "id": "away", "do": "ramp", "to": { "travel_mm": -0.2 }, "speed_mm_s": 0.5, "timeout_s": 60 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "travel_mm": -0.3 }, "speed_mm_s": 0.5, "timeout_s": 60 } ] })";

class Asks : public Rig {
 protected:
  static json asked(Control& client, const std::string& step) {
    return client.wait_for("status", [&](const json& s) {
      return s.contains("question") && s["question"].is_object() && s["question"]["step"] == step;
    });
  }
  Ended answer(std::vector<std::string> words) {
    words.insert(words.begin(), "answer");
    words.insert(words.end(), {"--socket", file("control.sock")});
    return lcrig(words);
  }
};

TEST_F(Asks, ATypedLineIsTheAnswerAndAWrongOneIsAskedForAgain) {
  start_sim();
  start_daemon(config());
  write("protocol.json", kAsks);
  Terminal terminal({LCRIG_BIN "/lcrig", "run", file("protocol.json"), "--specimen", "paper-1",
                     "--socket", file("control.sock")},
                    {{"HOME", file("home")}, {"TERM", "xterm"}});
  ASSERT_TRUE(
      terminal.shows("The surface (one of: clean, dusty)  (type the answer and press Enter)"))
      << terminal.received();
  terminal.type("dutsy\n");
  ASSERT_TRUE(terminal.shows("did you mean `dusty`")) << terminal.received();
  terminal.type("dusty\n");
  ASSERT_TRUE(terminal.shows(
      "Thickness by gauge (a number from 20 to 400 um)  (type the answer and press Enter)"))
      << terminal.received();
  terminal.type("125.5\n");
  EXPECT_TRUE(terminal.shows("run 1: success")) << terminal.received();
  EXPECT_EQ(terminal.wait(10s), 0);
  EXPECT_EQ(query("SELECT coalesce(text, number || ' ' || unit) FROM v_answer"),
            "dusty\n125.5 um\n");
  EXPECT_EQ(lcrig({"export", "1", "-o", file("out"), "--socket", file("control.sock")}).code, 0);
  EXPECT_THAT(program({"/usr/bin/cat", file("out/answers.csv")}).out,
              HasSubstr("thickness,0,Thickness by gauge,number,125.5,um,,person,"));
}

TEST_F(Asks, ADaemonThatDiesWhileItWaitsAsksAgainAndKeepsWhatWasAnswered) {
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kAsks).contains("result"));
  asked(client, "surface");
  const Ended missing = answer({});
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.err, HasSubstr("step surface asks \"The surface\", expected one of: clean"));
  const Ended wrong = answer({"wet"});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("\"wet\" is no choice"));
  const Ended good = answer({"dusty"});
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_EQ(good.out, "step surface: dusty\n");
  asked(client, "thickness");
  daemon.signal(SIGKILL);
  EXPECT_EQ(daemon.wait(5s), 128 + SIGKILL);
  start_daemon(config(), "d2");
  const Ended nothing = answer({"125"});
  EXPECT_EQ(nothing.code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("no run is going on"));
  Control again = control();
  again.call("watch");
  ASSERT_TRUE(
      again.call("run.resume", {{"run", 1}, {"confirm_specimen", true}}).contains("result"));
  asked(again, "thickness");
  EXPECT_EQ(answer({"-5"}).code, 1) << "a number below zero is an answer, not an option";
  EXPECT_EQ(answer({"125"}).out, "step thickness: 125 um\n");
  EXPECT_EQ(again.run_ended().value("exit_status", ""), "success");
  EXPECT_EQ(query("SELECT step || ' ' || coalesce(text, number) || ' ' || coalesce(from_run, '-') "
                  "FROM v_answer WHERE run = 2"),
            "surface dusty 1\nthickness 125.0 -\n");
  EXPECT_EQ(lcrig({"verify", "2", "--socket", file("control.sock")}).code, 0);
}

}  // namespace
}  // namespace lcrig::e2e
