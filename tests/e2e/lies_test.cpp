// SPDX-License-Identifier: Apache-2.0
// The daemon on a rig that lies behind an honest link: the reference gateway in Python with --lie
// (docs/faults.md), which also records the truth. In real time.
#include <algorithm>
#include <cmath>
#include <csignal>

#include "base/clock.hpp"
#include "tests/e2e/gateway.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

std::string protocol(const std::string& load_mm_s, const std::string& more = "") {
  return R"({ "format": "load-protocol/1", "name": "lies", )" + more + R"(
  "limits": { "force_N": [-1, 1.5], "gap_mm": [-1, 25] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0, "aperture": "fast",
      "trigger": "internal" }, "frame": { "rate_Hz": 100 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": 0.2, "force_N": 0.02,
      "back_off_mm": 0.05, "timeout_s": 60 },
    { "id": "ready", "do": "hold", "hold": "travel", "for_s": 2 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.8 }, "speed_mm_s": )" +
         load_mm_s + R"(, "timeout_s": 60 },
    { "id": "stay", "do": "hold", "hold": "travel", "for_s": 5 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.2 }, "speed_mm_s": 0.2, "timeout_s": 20 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 1 }, "speed_mm_s": 0.5, "timeout_s": 20 } ] })";
}

class Lies : public Gateway {
 protected:
  // Starts a daemon on a machine with these lies, and a run.
  void begin(const std::vector<std::string>& lies, const std::string& text = protocol("0.05"),
             const std::vector<std::string>& machine = kForeign, double stiffness_N_mm = 150) {
    std::vector<std::string> options;
    for (const std::string& lie : lies) options.insert(options.end(), {"--lie", lie});
    start_rig(machine, options);
    start_daemon(foreign_config(stiffness_N_mm));
    client_.emplace(control());
    client_->call("watch");
    const json started = start_run(*client_, text);
    ASSERT_TRUE(started.contains("result")) << started;
  }
  void lie(const std::string& what) const {
    EXPECT_THAT(panel("LIE text=\"" + what + "\""), HasSubstr("OK"));
  }
  void lie_in(const std::string& step, const std::string& what) {
    await(step);
    lie(what);
  }
  void await_load(double force_N) {
    client_->wait_for(
        "status",
        [&](const json& s) {
          const json shown = s.value("force_N", json());
          return s.value("step", "") == "load" && shown.is_number() && shown > force_N;
        },
        60s);
  }
  void await(const std::string& step) {
    client_->wait_for("status", [&](const json& s) { return s.value("step", "") == step; }, 60s);
  }
  // Waits for the end of the run, then ends the gateway. sums_ and lines_ then hold the truth.
  json ended(Timeout within) {
    const json end = client_->run_ended(within);
    client_->listen(1s);  // time for motions that might still come
    sums_ = end_gateway();
    lines_ = truth();
    gateway_.reset();
    lied_ = find("lie", 0);
    stopped_ = find("stop_received", lied_);
    RecordProperty("reason", end.dump());
    RecordProperty("watch", query("SELECT detail FROM event WHERE kind='watch'"));
    RecordProperty("peak_force_N", std::to_string(peak()));
    RecordProperty("to_stop_s", std::to_string(to_stop_s()));
    return end;
  }
  double peak() const { return sums_.value("peak_force_N", 99.0); }
  double at_the_end() const { return sums_.value("force_N", 99.0); }
  double to_stop_s() const { return at_s(stopped_) - at_s(lied_); }
  void expect_failed(const json& end, const std::vector<std::string>& any_of) const {
    EXPECT_EQ(end.value("exit_status", ""), "fail") << end;
    const std::string reason = end.value("reason", "");
    const bool named = std::ranges::any_of(
        any_of, [&](const std::string& word) { return reason.find(word) != reason.npos; });
    EXPECT_TRUE(named) << "the reason does not name what cannot be true: " << reason;
  }
  void expect_stop_within(double time_s) const {
    EXPECT_LT(to_stop_s(), time_s) << "STOP came late, or never";
  }
  // Checks from the first STOP after the lie on, with some time for braking.
  void expect_nothing_moves_after_the_stop() const {
    ASSERT_LT(stopped_, lines_.size());
    const double t_s = lines_[stopped_].value("t_s", 0.0) + 0.3;
    double low_mm = HUGE_VAL, high_mm = -HUGE_VAL;
    for (std::size_t i = stopped_; i < lines_.size(); ++i) {
      if (lines_[i].value("t_s", 0.0) < t_s) continue;
      low_mm = std::min(low_mm, lines_[i].value("travel_mm", 0.0));
      high_mm = std::max(high_mm, lines_[i].value("travel_mm", 0.0));
    }
    EXPECT_LT(high_mm - low_mm, 0.001) << "moved after STOP";
  }
  std::size_t find(const std::string& event, std::size_t from) const {
    while (from < lines_.size() && lines_[from].value("event", "") != event) ++from;
    return from;
  }
  double at_s(std::size_t line) const {
    return line < lines_.size() ? lines_[line].value("t_s", 0.0) : HUGE_VAL;
  }

  std::optional<Control> client_;
  json sums_;
  std::vector<json> lines_;
  // lines at which the lie begins and at which the first STOP follows
  std::size_t lied_ = 0, stopped_ = 0;
};

// Once this pressed with 206 N.
TEST_F(Lies, AForceThatFreezesInTheSearchStopsIt) {
  begin({"force_frozen,motion=1,after_s=0.5"});
  const json end = ended(30s);
  expect_failed(end, {"frozen"});
  expect_stop_within(1);
  EXPECT_LT(peak(), 1.5);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

// The force keeps scattering. Once this pressed to the end of the gap limits, with 120 N.
TEST_F(Lies, AForceThatIsHeldWhileItIsPressedIsNotFollowed) {
  begin({});
  lie_in("load", "force_held");
  const json end = ended(60s);
  expect_failed(end, {"does not follow the way into the specimen"});
  EXPECT_LT(peak(), 3);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

TEST_F(Lies, AGainThatFellToATenthIsNoticedNearContact) {
  begin({});
  lie_in("ready", "force_gain,factor=0.1");
  const json end = ended(60s);
  expect_failed(end, {"does not follow the way into the specimen"});
  EXPECT_LT(peak(), 1.5);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

// Once this pressed with 6.8 N at 1 mm/s, and stayed there because no contact was found.
TEST_F(Lies, AForceWithTheWrongSignStopsTheSearch) {
  begin({"force_reversed,motion=1"});
  const json end = ended(30s);
  expect_failed(end, {"wrong way"});
  EXPECT_LT(peak(), 1.5);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

// Once this pressed with 5.6 N: `finally` went the wrong way, too, five times faster.
TEST_F(Lies, ADriveThatGoesTheWrongWayIsNotUsedAgain) {
  begin({});
  lie_in("stay", "drive_reversed");
  const json end = ended(30s);
  expect_failed(end, {"against the command"});
  EXPECT_LT(peak(), 2.5);
  expect_nothing_moves_after_the_stop();
}

TEST_F(Lies, ADriveThatStallsIsNoticedBeforeTheTimeoutOfItsStep) {
  begin({"drive_stalled,motion=1,after_s=0.5"});
  const json end = ended(30s);
  expect_failed(end, {"does not move"});
  expect_stop_within(5);
  EXPECT_LT(peak(), 0.01);
  expect_nothing_moves_after_the_stop();
}

// Once the force rose from 0.5 N to 1.1 N, and the run succeeded.
TEST_F(Lies, AnAxisThatCreepsAfterDoneIsStopped) {
  auto soft = kForeign;
  soft.insert(soft.end(), {"stiffness_N_mm=20", "stiffness_most_N_mm=25"});
  begin({}, protocol("0.05"), soft, 30);
  lie_in("load", "creep,speed_um_s=5");
  const json end = ended(40s);
  expect_failed(end, {"moves without a command"});
  EXPECT_LT(peak(), 1.2);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

// Once five readings at 0 N were stored as readings at 1.0 N.
TEST_F(Lies, ADoneThatIsNotTrueIsNoLevel) {
  begin({});
  lie_in("ready", "done_unmoved,times=1");
  const json end = ended(30s);
  expect_failed(end, {"DONE"});
  EXPECT_LT(peak(), 0.5);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

TEST_F(Lies, APulseOfTheEmergencyStopEndsAllMotion) {
  begin({}, protocol("0.005"));
  await_load(0.3);
  lie("estop,for_s=0.05");
  const json end = ended(30s);
  EXPECT_EQ(end.value("exit_status", ""), "fail") << end;
  EXPECT_THAT(end.value("reason", ""), AnyOf(HasSubstr("E-stop"), HasSubstr("estop"))) << end;
  expect_nothing_moves_after_the_stop();
  EXPECT_THAT(end.value("reason", ""), HasSubstr("loaded")) << "left at about 0.3 N";
  EXPECT_LT(peak(), 0.8);
  const auto moved = std::ranges::count_if(
      lines_.begin() + static_cast<std::ptrdiff_t>(lied_), lines_.end(),
      [](const json& line) { return line.value("event", "") == "motion_begin"; });
  EXPECT_EQ(moved, 0) << "moved after an E-stop that nobody has looked at";
}

// Once the frame was armed again, and the run succeeded at a true force of 1.81 N.
class LostTare : public Lies, public testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(TellsANewOrigin, LostTare,
                         testing::Values("origin_changes=0", "origin_changes=1"));

TEST_P(LostTare, WithTheLinkIsNotGoneOnWith) {
  auto machine = kForeign;
  // once the zero is lost, the true force is 0.4 N above the one shown
  machine.push_back("cell_offset_N=-0.4");
  begin({}, protocol("0.01", R"("on_loss": "wait",)"), machine);
  await_load(0.3);
  lie(std::string("tare_lost,restart=1,") + GetParam());
  const json end = ended(40s);
  expect_failed(end, {"zero of force"});
  EXPECT_LT(peak(), 0.8) << "it would have gone to 1.2 N";
  expect_nothing_moves_after_the_stop();
}

// Once the force rose from 0 N to 1.0 N while the status said "paused".
TEST_F(Lies, AnOrderThatIsObeyedInAPauseIsStopped) {
  begin({}, protocol("0.05"));
  lie_in("ready", "order_late,delay_s=3,times=1");
  await("load");
  client_->call("run.pause");
  const json end = ended(30s);
  expect_failed(end, {"moves without a command"});
  const std::size_t obeyed = find("motion_begin", stopped_);
  EXPECT_LT(at_s(find("stop_received", obeyed)) - at_s(obeyed), 1) << "STOP came late, or never";
  EXPECT_LT(peak(), 1.0);
  EXPECT_LT(at_the_end(), 0.01) << "left loaded";
}

// Once the answer was "paused", exit status 0, and the axis moved on for 5 s.
TEST_F(Lies, APauseThatTheGatewayIgnoresIsNotCalledOne) {
  const auto ask = [this](std::vector<std::string> words) {
    words.insert(words.end(), {"--socket", file("control.sock")});
    return lcrig(words);
  };
  // Soft, so that the motion outlasts the test: at its target it stands, and "paused" is true.
  auto soft = kForeign;
  soft.insert(soft.end(), {"stiffness_N_mm=20", "stiffness_most_N_mm=25"});
  begin({}, protocol("0.003"), soft, 30);
  await_load(0.1);
  lie("stop_ignored");
  const RealClock clock;
  const MonoTime asked = clock.now();
  const Ended pause = ask({"pause"});
  EXPECT_EQ(pause.code, 7) << pause.out << pause.err;
  EXPECT_THAT(pause.err, AllOf(HasSubstr("frame: standstill not confirmed"), HasSubstr("E-stop")));
  EXPECT_EQ(pause.out, "");
  const Ended check = ask({"status", "--check"});
  const double told_s = to_seconds(clock.now() - asked);
  RecordProperty("told_s", std::to_string(told_s));
  EXPECT_LT(told_s, 3) << "on a machine with a free processor";
  EXPECT_EQ(check.code, 2) << check.out;
  EXPECT_THAT(check.out, AllOf(HasSubstr("CRITICAL"), HasSubstr("frame: standstill")));
  const json run = client_->call("status")["result"]["run"];
  EXPECT_EQ(run.value("state", ""), "stopping") << run;
  EXPECT_EQ(run.value("standstill", ""), "not_confirmed") << run;
  EXPECT_THAT(ask({"resume"}).err, HasSubstr("is not paused"));
  // For an abort the alarm does not wait for the end of the run either.
  EXPECT_EQ(ask({"abort"}).code, 7);
  EXPECT_EQ(ask({"status", "--check"}).code, 2);
  const json end = ended(30s);
  EXPECT_FALSE(end.value("stands", true)) << end;
  EXPECT_EQ(ask({"status", "--check"}).code, 2);
}

TEST_F(Lies, AGatewayThatComesBackWithOtherCapabilitiesIsNotWaitedFor) {
  begin({}, protocol("0.05", R"("on_loss": "wait", "on_loss_timeout_s": 600,)"));
  lie_in("stay", "caps_changed,force_max_N=1");
  const json end = ended(20s);
  expect_failed(end, {"other capabilities"});
  EXPECT_LT(peak(), 1.5);
}

}  // namespace
}  // namespace lcrig::e2e
