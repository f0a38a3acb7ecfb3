// SPDX-License-Identifier: Apache-2.0
// A person in front of `lcrig run`: what the terminal shows, Enter, Ctrl-C. Also the rigs that need
// a terminal: weights placed by hand, and the frame link on a serial line.
#include "tests/e2e/terminal.hpp"
#include <algorithm>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

// Two weights placed by hand, then ten readings.
constexpr const char* kWeights = R"({ "format": "load-protocol/1", "name": "weights",
  "limits": { "force_N": [-0.2, 1.0] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0,
      "aperture": "fast", "trigger": "bus" }, "frame": { "rate_Hz": 10 } },
  "steps": [
    { "id": "empty", "do": "place_weight", "mass_g": 0 },
    { "id": "first", "do": "place_weight", "mass_g": 50 },
    { "id": "level", "do": "measure", "count": 10, "within_s": 3 } ],
  "finally": [ { "id": "clear", "do": "mark", "text": "take all weights off" } ] })";

class OnATerminal : public Rig {
 protected:
  Terminal run(const std::string& protocol_text) {
    write("protocol.json", protocol_text);
    return Terminal({LCRIG_BIN "/lcrig", "run", file("protocol.json"), "--specimen", "paper-1",
                     "--socket", file("control.sock")},
                    {{"HOME", file("home")}, {"TERM", "xterm"}});
  }
};

TEST_F(OnATerminal, TheLiveLineIsRewrittenInPlace) {
  start_sim();
  start_daemon(config());
  Terminal terminal = run(kQuickProtocol);
  EXPECT_TRUE(terminal.shows("\rcontact"));
  EXPECT_TRUE(terminal.shows("run 1: success"));
  EXPECT_EQ(terminal.wait(10s), 0);
  const auto& all = terminal.received();
  EXPECT_THAT(all, HasSubstr(" pF  F "));
  EXPECT_THAT(all, HasSubstr("left 0:"));
  // While it runs there is one line, which is redrawn many times and hardly ever scrolls.
  EXPECT_GT(std::count(all.begin(), all.end(), '\r'), 20);
  EXPECT_LT(std::count(all.begin(), all.end(), '\n'), 20) << all;
}

TEST_F(OnATerminal, EnterConfirmsAWeight) {
  start_sim({"--weights"});
  start_daemon(config());
  Terminal terminal = run(kWeights);
  ASSERT_TRUE(terminal.shows("(press Enter when done)")) << terminal.received();
  terminal.type("\n");
  ASSERT_TRUE(terminal.shows("50 g")) << terminal.received();
  sim("load 0.4903325");
  terminal.type("\n");
  EXPECT_TRUE(terminal.shows("run 1: success")) << terminal.received();
  EXPECT_EQ(terminal.wait(10s), 0);
  EXPECT_EQ(number("SELECT count(*) FROM lcr_reading WHERE reading_index IS NOT NULL"), 10);
  EXPECT_NEAR(number("SELECT max(force_N) FROM frame_sample"), 0.4903325, 1e-9);
  EXPECT_EQ(number("SELECT simulated FROM run"), 1) << "real weights, but a simulated meter";
}

TEST_F(OnATerminal, CtrlCStopsTheRunAndUnloads) {
  start_sim();
  start_daemon(config());
  Terminal terminal = run(kSlowProtocol);
  ASSERT_TRUE(terminal.shows("\raway")) << terminal.received();
  terminal.type("\x03");
  EXPECT_TRUE(terminal.shows("stopping the run")) << terminal.received();
  EXPECT_TRUE(terminal.shows("run 1: abort")) << terminal.received();
  EXPECT_EQ(terminal.wait(10s), 130);
  EXPECT_THAT(query("SELECT reason FROM run_end"), HasSubstr("Ctrl-C"));
  EXPECT_EQ(query("SELECT detail FROM event WHERE kind = 'step_end' AND step_id = 'clear'"),
            "done\n");
}

TEST_F(OnATerminal, TheTerminalThatClosesLeavesTheRunGoingOn) {
  start_sim();
  start_daemon(config());
  {
    Terminal terminal = run(kQuickProtocol);
    ASSERT_TRUE(terminal.shows("\rcontact")) << terminal.received();
  }
  Control client = control();
  client.call("watch");
  EXPECT_EQ(client.run_ended(20s).value("exit_status", ""), "success");
}

TEST_F(OnATerminal, TheFrameLinkWorksOnASerialLine) {
  start_sim({"--frame-pty"});
  start_daemon(config());
  Terminal terminal = run(kQuickProtocol);
  EXPECT_TRUE(terminal.shows("run 1: success", 30s)) << terminal.received();
  EXPECT_EQ(terminal.wait(10s), 0);
}

}  // namespace
}  // namespace lcrig::e2e
