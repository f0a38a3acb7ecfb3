// SPDX-License-Identifier: Apache-2.0
// The daemon on a frame that shares no code with it: the reference gateway in Python
// (tools/gateway), written from docs/frame-link.md alone, with a simulated machine of its own and a
// witness that knows the true force.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

// Contact at 30 mm of 0 to 60, 120 N/mm, a device that reacts within 8 ms.
const std::vector<std::string> kForeign{"stiffness_N_mm=120",      "stiffness_curvature_per_mm=0",
                                        "stiffness_most_N_mm=200", "contact_travel_mm=30",
                                        "start_travel_mm=29.6",    "device_reaction_s=0.008",
                                        "cell_offset_N=0.02"};

class Gateway : public Rig {
 protected:
  // The meter comes from lcrig-sim, which has no frame then.
  void start_rig(std::vector<std::string> machine = kForeign,
                 const std::vector<std::string>& options = {}) {
    start_sim({"--weights"});
    std::vector<std::string> command{"tools/gateway/lcrig-gateway",
                                     "--port",
                                     "0",
                                     "--panel-port",
                                     "0",
                                     "--truth",
                                     file("truth.jsonl")};
    for (const std::string& set : machine) command.insert(command.end(), {"--set", set});
    command.insert(command.end(), options.begin(), options.end());
    gateway_ = std::make_unique<Child>(command, file("gateway.log"));
    const auto line = gateway_->out().next(20s);
    ASSERT_TRUE(line) << "the gateway does not start: " << gateway_->log();
    ready_ = json::parse(*line);
    ports_["frame"] = ready_.at("frame");
  }
  void TearDown() override {
    for (auto& daemon : daemons_) daemon->signal(SIGTERM);
    for (auto& daemon : daemons_) daemon->wait(20s);
    if (gateway_) end_gateway();
    if (HasFailure() && gateway_) std::cerr << "--- gateway\n" << gateway_->log();
    Rig::TearDown();
  }
  // Its last words: the sums of what was really there.
  json end_gateway() {
    gateway_->signal(SIGTERM);
    EXPECT_EQ(gateway_->wait(10s), 0) << gateway_->log();
    json last;
    for (const json& line : truth()) last = line;
    EXPECT_EQ(last.value("event", ""), "summary");
    return last;
  }
  std::vector<json> truth() const {
    std::vector<json> out;
    std::ifstream in(file("truth.jsonl"));
    for (std::string line; std::getline(in, line);) {
      json one = json::parse(line, nullptr, false);
      if (one.is_object()) out.push_back(std::move(one));
    }
    return out;
  }
  json foreign_config(std::optional<double> stiffness_N_mm = 150) const {
    json c = config();
    c["frame"] = {{"driver", "zwick"}, {"port", ports_.at("frame")}};
    if (stiffness_N_mm) c["frame"]["stiffness_N_mm"] = *stiffness_N_mm;
    return c;
  }
  std::string panel(const std::string& order) const {
    const std::string at = ready_.at("panel").get<std::string>();
    const auto colon = at.rfind(':');
    const std::string host =
        at.substr(0, colon).substr(at.find("//") == at.npos ? 0 : at.find("//") + 2);
    std::vector<std::string> command{
        "/usr/bin/python3",
        "-c",
        "import socket,sys\n"
        "s=socket.create_connection((sys.argv[1],int(sys.argv[2])),5)\n"
        "s.sendall((sys.argv[3]+'\\n').encode())\n"
        "print(s.makefile().readline().strip())",
        host,
        at.substr(colon + 1),
        order};
    Child child(command, file("panel.log"));
    return child.out().rest(10s);
  }

  std::unique_ptr<Child> gateway_;
  json ready_;
};

std::string protocol(const std::string& contact_mm_s, const std::string& load_mm_s) {
  return R"({ "format": "load-protocol/1", "name": "foreign",
  "limits": { "force_N": [-0.2, 1.5], "gap_mm": [-1, 25] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0, "aperture": "fast",
      "trigger": "internal" }, "frame": { "rate_Hz": 100 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": )" +
         contact_mm_s + R"(, "force_N": 0.02, "back_off_mm": 0.05, "timeout_s": 60 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.8 }, "speed_mm_s": )" +
         load_mm_s + R"(, "timeout_s": 60 },
    { "id": "stay", "do": "hold", "hold": "travel", "for_s": 3 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.2 }, "speed_mm_s": 0.5, "timeout_s": 20 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 1 }, "speed_mm_s": 0.5, "timeout_s": 20 } ] })";
}

TEST_F(Gateway, ARunOnAForeignFrameSucceedsWithinItsLimit) {
  start_rig();
  start_daemon(foreign_config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, protocol("0.2", "0.05")).contains("result"));
  const json end = client.run_ended(60s);
  EXPECT_EQ(end.value("exit_status", ""), "success") << end;
  EXPECT_EQ(number("SELECT simulated FROM run"), 1) << "the gateway says that it is not real";
  // The contact is measured, and every prediction held.
  EXPECT_NEAR(
      number("SELECT json_extract(detail,'$.stiffness_N_m') FROM event WHERE kind='stiffness'"),
      120e3, 25e3);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind='overshoot'"), 2);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind='overshoot_exceeded'"), 0);
  const json sums = end_gateway();
  EXPECT_GT(sums.value("peak_force_N", 0.0), 0.75);
  EXPECT_LT(sums.value("peak_force_N", 9.0), 1.5);
  EXPECT_LT(sums.value("force_N", 9.0), 0.01) << "left loaded";
  EXPECT_FALSE(sums.value("moved_after_last_stop", true));
  gateway_.reset();
}

TEST_F(Gateway, WhatWouldPressTooHardIsRefusedWithTheSpeedThatIsThenAccepted) {
  start_rig();
  start_daemon(foreign_config());
  Control client = control();
  json no = start_run(client, protocol("2", "0.05"));
  ASSERT_TRUE(no.contains("error")) << no;
  const std::string why = no["error"]["message"];
  const std::string place = "(/steps/1/speed_mm_s: ";
  const auto at = why.find(place);
  ASSERT_NE(at, why.npos) << why;
  const double fastest = std::stod(why.substr(at + place.size()));
  EXPECT_LT(fastest, 2);
  client.call("watch");
  const json yes = start_run(client, protocol(std::to_string(fastest), "0.05"));
  ASSERT_TRUE(yes.contains("result")) << yes;
  EXPECT_EQ(client.run_ended(60s).value("exit_status", ""), "success");
  const json sums = end_gateway();
  EXPECT_LT(sums.value("peak_force_N", 9.0), 1.5);
  EXPECT_EQ(sums.value("hellos", 0), 1) << "a plan that is refused commands nothing";
  gateway_.reset();
}

TEST_F(Gateway, AnAbortAtTheForceStopsAtOnceAndUnloads) {
  start_rig();
  start_daemon(foreign_config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, protocol("0.2", "0.01")).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "stay"; }, 60s);
  const json stopped = client.call("run.abort");
  EXPECT_EQ(stopped["result"].value("state", ""), "standing") << stopped;
  const json end = client.run_ended(30s);
  EXPECT_EQ(end.value("exit_status", ""), "abort");
  const json sums = end_gateway();
  EXPECT_LT(sums.value("force_N", 9.0), 0.01) << "left loaded";
  gateway_.reset();
}

TEST_F(Gateway, AKilledDaemonLeavesAFrameThatStandsAndTheNextOneStopsItFirst) {
  start_rig();
  Child& first = start_daemon(foreign_config());
  {
    Control client = control();
    client.call("watch");
    ASSERT_TRUE(start_run(client, protocol("0.2", "0.002")).contains("result"));
    client.wait_for("status", [](const json& s) { return s.value("step", "") == "load"; }, 60s);
  }
  first.signal(SIGKILL);
  first.wait(10s);
  start_daemon(foreign_config(), "d2");
  const json status = control().call("status");
  const auto lines = truth();
  const auto stop = std::ranges::find_if(lines.rbegin(), lines.rend(), [](const json& l) {
    return l.value("event", "") == "stop_received";
  });
  EXPECT_NE(stop, lines.rend()) << status;
  const json sums = end_gateway();
  EXPECT_FALSE(sums.value("moved_after_last_stop", true));
  EXPECT_LT(sums.value("peak_force_N", 9.0), 1.5);
  gateway_.reset();
}

// testXpert, or a person at the panel, works with the machine.
TEST_F(Gateway, AnIdleDaemonLeavesTheFrameAlone) {
  start_rig();
  start_daemon(foreign_config());
  const char* seconds = std::getenv("LCRIG_IDLE_S");
  EXPECT_THAT(panel("MOVE travel_mm=20 speed_mm_s=0.5"), HasSubstr("OK"));
  control().listen(seconds != nullptr ? std::chrono::seconds(std::stoi(seconds)) : 3s);
  const json sums = end_gateway();
  EXPECT_EQ(sums.value("bytes_received", -1), 0) << sums;
  gateway_.reset();
}

TEST_F(Gateway, FollowRecordsAFrameThatSomebodyElseMoves) {
  start_rig();
  start_daemon(foreign_config());
  EXPECT_THAT(panel("MOVE travel_mm=25 speed_mm_s=0.4"), HasSubstr("OK"));
  const Ended ended = lcrig({"run", "follow", "--specimen", "paper-1", "-p", "duration_s=4",
                             "--json", "--socket", file("control.sock")});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_GT(number("SELECT max(travel_m) - min(travel_m) FROM frame_sample"), 1e-3);
  const Ended asked = lcrig({"status", "--ask", "--socket", file("control.sock")});
  EXPECT_EQ(asked.code, 0) << asked.err;
  EXPECT_THAT(asked.out, HasSubstr("ready"));
  const auto lines = truth();
  const auto has = [&](const char* event) {
    return std::ranges::any_of(lines, [&](const json& l) { return l.value("event", "") == event; });
  };
  EXPECT_FALSE(has("stop_begun")) << "the motion was stopped";
  const json sums = end_gateway();
  EXPECT_EQ(sums.value("stops", -1), 0);
  EXPECT_EQ(sums.value("hellos", -1), 0);
  EXPECT_EQ(sums.value("commands", -1), 0);
  gateway_.reset();
}

TEST_F(Gateway, AnOldGatewayIsCommandedButNotObserved) {
  start_rig(kForeign, {"--revision", "1"});
  start_daemon(foreign_config());
  const Ended follow = lcrig({"run", "follow", "--specimen", "paper-1", "-p", "duration_s=2",
                              "--socket", file("control.sock")});
  EXPECT_EQ(follow.code, 4) << follow.err;
  EXPECT_THAT(follow.err, HasSubstr("no observer sessions"));
  const Ended loop = lcrig({"run", "static-frame", "--specimen", "paper-1", "--dry-run", "--socket",
                            file("control.sock")});
  EXPECT_THAT(loop.err, HasSubstr("state frame.force_loop in the config"));
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, protocol("0.2", "0.05")).contains("result"));
  EXPECT_EQ(client.run_ended(60s).value("exit_status", ""), "success");
  end_gateway();
  gateway_.reset();
}

// What the samples of the first run said means nothing any more.
TEST_F(Gateway, ARunIsNotContinuedUnderAnotherZero) {
  start_rig();
  Child& daemon = start_daemon(foreign_config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, protocol("0.2", "0.002")).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "load"; });
  daemon.signal(SIGKILL);
  daemon.wait(5s);
  EXPECT_THAT(panel("ZERO force=1 travel=0"), HasSubstr("OK"));
  start_daemon(foreign_config(), "d2");
  Control again = control();
  const json answer = again.call("run.resume", {{"run", 1}, {"confirm_specimen", true}});
  EXPECT_THAT(answer.dump(), HasSubstr("the zero of force or travel was lost or changed since"));
  EXPECT_EQ(number("SELECT count(*) FROM run"), 1);
  end_gateway();
  gateway_.reset();
}

// A frame whose stop is polled and slow: nothing but the config's stiffness makes it possible.
TEST_F(Gateway, ASlowPollingFrameIsSlowedDownAndStaysWithinTheLimit) {
  auto slow = kForeign;
  slow.insert(slow.end(), {"device_stop=false", "poll_reaction_s=0.05", "start_travel_mm=29.9"});
  start_rig(slow);
  start_daemon(foreign_config(400));
  std::string text = protocol("0.5", "0.012");
  const std::string search = R"("back_off_mm": 0.05, "timeout_s": 60)";
  text.replace(text.find(search), search.size(),
               R"("back_off_mm": 0.05, "slow_down": true, "timeout_s": 300)");
  Control client = control();
  client.call("watch");
  const json started = start_run(client, text);
  ASSERT_TRUE(started.contains("result")) << started;
  const json end = client.run_ended(90s);
  EXPECT_EQ(end.value("exit_status", ""), "success") << end;
  const json sums = end_gateway();
  EXPECT_LT(sums.value("peak_force_N", 9.0), 1.5);
  EXPECT_GT(sums.value("peak_force_N", 0.0), 0.79);
  gateway_.reset();
}

// lcrig's own simulator under the check for authors of gateways.
TEST_F(Rig, TheSimulatorPassesTheCheckForGateways) {
  start_sim();
  const std::string url = ports_.at("frame").get<std::string>();
  const auto colon = url.rfind(':');
  std::vector<std::string> command{"/usr/bin/python3",
                                   "tools/gateway/check_gateway.py",
                                   url.substr(url.find("//") + 2, colon - url.find("//") - 2),
                                   url.substr(colon + 1),
                                   "--move",
                                   "--travel-mm=-2:0.4",
                                   "--force-max-N",
                                   "1",
                                   "--speed-mm-s",
                                   "1",
                                   "--zero"};
  Child check(command, file("check.log"));
  const std::string out = check.out().rest(120s);
  EXPECT_EQ(check.wait(10s), 0) << out << check.log();
  EXPECT_THAT(out, HasSubstr(" 0 failed"));
}

}  // namespace
}  // namespace lcrig::e2e
