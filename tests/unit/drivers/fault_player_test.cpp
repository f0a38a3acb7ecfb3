// SPDX-License-Identifier: Apache-2.0
#include "drivers/faults/player.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>

#include "drivers/lcr6100/sim.hpp"
#include "drivers/zwick/sim.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;
using Kind = LineFault::Kind;

// Instruments that only remember what was done to them.
class FakeBench final : public FaultBench {
 public:
  bool has_frame() const override { return true; }
  void unplug_meter() override { done.emplace_back("unplug"); }
  void plug_meter(bool other) override { done.emplace_back(other ? "plug elsewhere" : "plug"); }
  void unplug_frame() override { done.emplace_back("unplug frame"); }
  void plug_frame(bool) override { done.emplace_back("plug frame"); }
  void hook_meter(lcr6100::SimHooks hooks) override { meter = std::move(hooks); }
  void break_meter(const std::function<void(lcr6100::SimFaults&)>& change) override {
    change(meter_faults);
  }
  std::string meter_identity() const override { return "mine"; }
  void power_meter(const std::string& identity) override { done.push_back("power " + identity); }
  void turn_meter(PanelKey key, const std::string& to) override {
    done.push_back(fmt::format("{} {}", to_string(key), to.empty() ? "back" : to));
  }
  void say_unasked(std::string text) override { done.push_back("say " + text); }
  void hook_frame(ZwickSimHooks hooks) override { frame = std::move(hooks); }
  void break_frame(const std::function<void(ZwickSimFaults&)>& change) override {
    change(frame_faults);
  }
  void power_frame() override { done.emplace_back("power frame"); }
  void stall_frame() override { done.emplace_back("stall"); }
  void restart_gateway(bool) override { done.emplace_back("restart"); }
  void set_operator_absent(bool absent) override { done.emplace_back(absent ? "away" : "here"); }

  lcr6100::SimHooks meter;
  ZwickSimHooks frame;
  lcr6100::SimFaults meter_faults;
  ZwickSimFaults frame_faults;
  std::vector<std::string> done;
};

struct Stage {
  explicit Stage(const std::string& faults)
      : player(io.get_executor(), clock, bench, nullptr,
               parse_fault_script(
                   R"({ "format": "faults/1", "seed": 3, "faults": [)" + faults + "] }", "f")
                   .value(),
               [this](MonoTime, const std::string& text) { told.push_back(text); }) {}
  ~Stage() {
    player.stop();
    clock.run_for(io, 1s);
    EXPECT_TRUE(player.is_idle());
    EXPECT_EQ(clock.pending(), 0U);
  }
  // Which of n answers something happened to.
  std::vector<int> hit(int n) {
    std::vector<int> out;
    for (int i = 1; i <= n; ++i) {
      if (bench.meter.answer().kind != Kind::none) out.push_back(i);
    }
    return out;
  }
  void pass(Duration d) { clock.run_for(io, d); }

  asio::io_context io{1};
  VirtualClock clock;
  FakeBench bench;
  std::vector<std::string> told;
  FaultPlayer player;
};

using Answers = std::vector<int>;

TEST(FaultPlayer, EveryNthAnswerAtMostSoManyTimes) {
  Stage s(R"({ "fault": "reply_lost", "on": "meter", "every": 4, "times": 2 })");
  EXPECT_EQ(s.hit(20), (Answers{4, 8}));
  EXPECT_EQ(s.told.size(), 2U);
  EXPECT_EQ(s.player.happened(), std::vector<std::int64_t>{2});
}

TEST(FaultPlayer, ProbabilityIsSeeded) {
  const std::string half = R"({ "fault": "reply_cut", "on": "meter", "probability": 0.5 })";
  Stage a(half), b(half);
  const Answers first = a.hit(200);
  EXPECT_EQ(first, b.hit(200));
  EXPECT_NEAR(static_cast<double>(first.size()), 100, 30);
}

TEST(FaultPlayer, ABareTimeHitsTheNextAnswerFromThenOn) {
  Stage s(R"({ "fault": "reply_late", "on": "meter", "at_s": 5, "delay_s": 1.5 })");
  s.player.begin();
  s.pass(4900ms);
  EXPECT_EQ(s.hit(3), Answers{});
  s.pass(200ms);
  const LineFault fault = s.bench.meter.answer();
  EXPECT_EQ(fault.kind, Kind::delay);
  EXPECT_EQ(fault.delay, 1500ms);
  EXPECT_EQ(s.hit(3), Answers{});
}

TEST(FaultPlayer, AWindowEnds) {
  Stage s(R"({ "fault": "reply_lost", "on": "meter", "at_s": 5, "for_s": 2 })");
  s.player.begin();
  s.pass(6s);
  EXPECT_EQ(s.hit(3), (Answers{1, 2, 3}));
  s.pass(2s);
  EXPECT_EQ(s.hit(3), Answers{});
}

TEST(FaultPlayer, AStepIsNamedByItsIdItsKindOrFinally) {
  const std::string in = R"({ "fault": "stall", "on": "frame", "after_s": 1, "in_step": )";
  Stage s(in + R"("load" }, )" + in + R"("hold" }, )" + in + R"("finally" })");
  s.player.enter_step("contact", "find_contact", false);
  s.pass(2s);
  EXPECT_EQ(s.bench.done.size(), 0U);
  s.player.enter_step("load", "move_until", false);
  s.pass(2s);
  EXPECT_EQ(s.bench.done.size(), 1U);
  s.player.enter_step("level", "hold", false);
  s.pass(2s);
  EXPECT_EQ(s.bench.done.size(), 2U);
  s.player.enter_step("clear", "ramp", true);
  s.pass(2s);
  EXPECT_EQ(s.bench.done.size(), 3U);
}

TEST(FaultPlayer, AStepThatIsShorterIsSpared) {
  Stage s(R"({ "fault": "stall", "on": "frame", "in_step": "load", "after_s": 3 })");
  s.player.enter_step("load", "move_until", false);
  s.pass(2s);
  s.player.enter_step("hold", "hold", false);
  s.pass(2s);
  EXPECT_EQ(s.bench.done.size(), 0U);
}

TEST(FaultPlayer, AnswersGoWrongInTheirStepOnly) {
  Stage s(R"({ "fault": "reply_lost", "on": "meter", "in_step": "load", "probability": 1 })");
  s.player.enter_step("load", "move_until", false);
  s.pass(1ms);
  EXPECT_EQ(s.hit(2).size(), 2U);
  s.player.enter_step("hold", "hold", false);
  s.pass(1ms);
  EXPECT_EQ(s.hit(2).size(), 0U);
}

TEST(FaultPlayer, WhatLastsEndsAndComesAgain) {
  Stage s(R"({ "fault": "unplug", "on": "meter", "at_s": 1, "for_s": 2, "every_s": 10, "times": 2,
    "other_port": true })");
  s.player.begin();
  s.pass(5s);
  EXPECT_EQ(s.bench.done, (std::vector<std::string>{"unplug", "plug elsewhere"}));
  s.pass(60s);
  EXPECT_EQ(s.bench.done.size(), 4U);
  EXPECT_EQ(s.told.size(), 4U);
  EXPECT_EQ(s.told[1], "meter unplug, other_port: over");
}

TEST(FaultPlayer, TheFirstMeterComesBackAfterAnotherOne) {
  Stage s(R"({ "fault": "other_instrument", "on": "meter", "at_s": 1, "for_s": 1,
    "identity": "theirs" })");
  s.player.begin();
  s.pass(5s);
  EXPECT_EQ(s.bench.done, (std::vector<std::string>{"unplug", "power theirs", "plug", "unplug",
                                                    "power mine", "plug"}));
}

TEST(FaultPlayer, StoppingMendsWhatLasts) {
  Stage s(R"({ "fault": "stuck", "on": "meter", "at_s": 1 })");
  s.player.begin();
  s.pass(2s);
  EXPECT_TRUE(s.bench.meter_faults.stuck);
  s.player.stop();
  EXPECT_FALSE(s.bench.meter_faults.stuck);
}

TEST(FaultPlayer, EveryLieBeginsAndEnds) {
  Stage s(R"({ "fault": "force_frozen", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "force_held", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "force_gain", "on": "frame", "at_s": 1, "for_s": 2, "factor": 0.1 },
    { "fault": "force_reversed", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "force_drift", "on": "frame", "at_s": 1, "for_s": 2, "rate_N_s": -0.005 },
    { "fault": "force_scatter", "on": "frame", "at_s": 1, "for_s": 2, "factor": 5 },
    { "fault": "drive_reversed", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "creep", "on": "frame", "at_s": 1, "for_s": 2, "speed_um_s": 5 },
    { "fault": "done_early", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "done_unmoved", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "done_late", "on": "frame", "at_s": 1, "for_s": 2, "delay_s": 0.5 },
    { "fault": "order_late", "on": "frame", "at_s": 1, "for_s": 2, "delay_s": 1.5 },
    { "fault": "clock_rate", "on": "frame", "at_s": 1, "for_s": 2, "factor": 2 },
    { "fault": "estop", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "stop_late", "on": "frame", "at_s": 1, "for_s": 2, "delay_s": 2.5 },
    { "fault": "stop_unconfirmed", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "stop_ignored", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "stop_pretended", "on": "frame", "at_s": 1, "for_s": 2 },
    { "fault": "stop_silences", "on": "frame", "at_s": 1, "for_s": 2 })");
  s.player.begin();
  s.pass(2s);
  ZwickSimLies lies;
  lies.force_frozen = lies.force_reversed = lies.drive_reversed = lies.done_early = true;
  lies.done_unmoved = lies.estop = lies.stop_unconfirmed = lies.stop_ignored = true;
  lies.stop_pretended = lies.stop_silences = true;
  lies.force_drift_N_s = -0.005;
  lies.force_scatter = 5;
  lies.force_held = true;
  lies.force_gain = 0.1;
  lies.creep_m_s = 5 * 1e-6;
  lies.done_late_s = 0.5;
  lies.order_late_s = 1.5;
  lies.clock_rate = 2;
  lies.stop_late_s = 2.5;
  EXPECT_TRUE(s.bench.frame_faults.lies == lies);
  s.pass(2s);
  EXPECT_TRUE(s.bench.frame_faults.lies == ZwickSimLies());
}

TEST(FaultPlayer, ATareIsLostOnceAndCapabilitiesChangeWithARestart) {
  Stage s(R"({ "fault": "tare_lost", "on": "frame", "at_s": 1, "origin_changes": true },
    { "fault": "clock_frozen", "on": "frame", "at_s": 1 },
    { "fault": "caps_changed", "on": "frame", "at_s": 1 })");
  s.player.begin();
  s.pass(2s);
  const ZwickSimFaults& f = s.bench.frame_faults;
  EXPECT_TRUE(f.lose_tare && f.tell_origin && f.lies.other_caps);
  EXPECT_EQ(f.lies.clock_rate, 0);
  EXPECT_EQ(s.bench.done, (std::vector<std::string>{"restart"}));
}

TEST(FaultPlayer, CommandsAndCompletionsAreCountedByThemselves) {
  Stage s(R"({ "fault": "refusal", "on": "frame", "every": 2, "code": "limits" },
    { "fault": "completion_lost", "on": "frame", "every": 3 },
    { "fault": "set_lost", "on": "meter", "every": 2 })");
  EXPECT_EQ(s.bench.frame.refuses(), "");
  EXPECT_EQ(s.bench.frame.refuses(), "limits");
  EXPECT_FALSE(s.bench.frame.loses_done());
  EXPECT_FALSE(s.bench.frame.loses_done());
  EXPECT_TRUE(s.bench.frame.loses_done());
  EXPECT_FALSE(s.bench.meter.loses_set());
  EXPECT_TRUE(s.bench.meter.loses_set());
}

}  // namespace
}  // namespace lcrig
