// SPDX-License-Identifier: Apache-2.0
// The daemon on a frame that shares no code with it: the reference gateway in Python
// (tools/gateway), which was written from docs/frame-link.md alone. It has its own simulated
// machine and records the true force.
#include <algorithm>
#include <csignal>
#include <cstdlib>

#include "tests/e2e/gateway.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

TEST_F(Gateway, ARunOnAForeignFrameSucceedsWithinItsLimit) {
  start_rig();
  start_daemon(foreign_config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, foreign_protocol("0.2", "0.05")).contains("result"));
  const json end = client.run_ended(60s);
  EXPECT_EQ(end.value("exit_status", ""), "success") << end;
  EXPECT_EQ(number("SELECT simulated FROM run"), 1) << "the gateway says that it is not real";
  // The contact (120 N/mm) is measured from a few samples of a cell that scatters. The upper bound
  // must hold, and so must every prediction.
  const std::string of_contact = "') FROM event WHERE kind='stiffness'";
  EXPECT_GE(number("SELECT json_extract(detail,'$.at_most_N_m" + of_contact), 118e3);
  EXPECT_NEAR(number("SELECT json_extract(detail,'$.stiffness_N_m" + of_contact), 120e3, 25e3);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind='overshoot'"), 2);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind='overshoot_exceeded'"), 0);
  const json sums = end_gateway();
  EXPECT_GT(sums.value("peak_force_N", 0.0), 0.75);
  EXPECT_LT(sums.value("peak_force_N", 9.0), 1.5);
  EXPECT_LT(sums.value("force_N", 9.0), 0.01) << "left loaded";
  EXPECT_FALSE(sums.value("moved_after_last_stop", true));
  gateway_.reset();
}

TEST_F(Gateway, AThousandSamplesASecondAreStoredWithoutAGap) {
  auto machine = kForeign;
  machine.emplace_back("rate_max_hz=1000");
  start_rig(machine);
  start_daemon(foreign_config());
  Control client = control();
  client.call("watch");
  std::string text = foreign_protocol("0.2", "0.05");
  const std::string rate = R"("rate_Hz": 100)";
  ASSERT_NE(text.find(rate), text.npos);
  text.replace(text.find(rate), rate.size(), R"("rate_Hz": 1000)");
  ASSERT_TRUE(start_run(client, text).contains("result"));
  EXPECT_EQ(client.run_ended(60s).value("exit_status", ""), "success");
  const double samples = number("SELECT count(*) FROM frame_sample");
  EXPECT_GT(samples, 3000);
  EXPECT_EQ(samples, number("SELECT max(device_seq) - min(device_seq) + 1 FROM frame_sample"));
  EXPECT_NEAR(
      number("SELECT (max(device_time_s) - min(device_time_s)) * 1000 + 1 FROM frame_sample"),
      samples, 0.001 * samples);
}

TEST_F(Gateway, WhatWouldPressTooHardIsRefusedWithTheSpeedThatIsThenAccepted) {
  start_rig();
  start_daemon(foreign_config());
  Control client = control();
  json no = start_run(client, foreign_protocol("2", "0.05"));
  ASSERT_TRUE(no.contains("error")) << no;
  const std::string why = no["error"]["message"];
  const std::string place = "(/steps/1/speed_mm_s: ";
  const auto at = why.find(place);
  ASSERT_NE(at, why.npos) << why;
  const double fastest = std::stod(why.substr(at + place.size()));
  EXPECT_LT(fastest, 2);
  client.call("watch");
  const json yes = start_run(client, foreign_protocol(std::to_string(fastest), "0.05"));
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
  ASSERT_TRUE(start_run(client, foreign_protocol("0.2", "0.01")).contains("result"));
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
    ASSERT_TRUE(start_run(client, foreign_protocol("0.2", "0.002")).contains("result"));
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

// In the meantime testXpert or a person at the panel works with the machine.
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
  ASSERT_TRUE(start_run(client, foreign_protocol("0.2", "0.05")).contains("result"));
  EXPECT_EQ(client.run_ended(60s).value("exit_status", ""), "success");
  end_gateway();
  gateway_.reset();
}

// A contact that the machine's force loop can hold.
TEST_F(Gateway, AnOldGatewayHoldsForcesWithWhatDoctorAskedForAndWrote) {
  start_rig({"stiffness_N_mm=20", "stiffness_curvature_per_mm=0", "stiffness_most_N_mm=30",
             "contact_travel_mm=30", "start_travel_mm=29.8"},
            {"--revision", "1"});
  Child& daemon = start_daemon(foreign_config(30));
  const auto here = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--socket", file("control.sock"), "--config", file("d1.json")});
    return lcrig(std::move(words), 90s);
  };
  const std::vector<std::string> run{"run", "static-frame", "--specimen", "paper-1",
                                     "-p",  "levels=2",     "-p",         "repeats=1",
                                     "-p",  "readings=2",   "-p",         "rate_N_s=1"};
  EXPECT_THAT(here(run).err, HasSubstr("state frame.force_loop in the config"));
  EXPECT_THAT(here({"doctor", "--ask"}).out,
              HasSubstr("states frame.travel_step_um and frame.force_loop"));
  const Ended stated =
      here({"doctor", "--state", "travel_step_um=0.1", "--state", "force_loop.approach_mm_s=0.5",
            "--state", "force_loop.contact_N=0.02", "--state", "force_loop.rate_max_N_s=2",
            "--state", "force_loop.lag_s=0.02", "--state", "force_loop.ripple_N=0.006", "--state",
            "force_loop.stiffness_max_N_mm=60"});
  EXPECT_THAT(stated.out, HasSubstr("written into"));
  daemon.signal(SIGHUP);
  Control client = control();
  client.listen(500ms);
  const Ended held = here(run);
  EXPECT_EQ(held.code, 0) << held.err;
  EXPECT_THAT(here({"doctor", "--ask"}).out, testing::Not(HasSubstr("frame's facts")));
  end_gateway();
  gateway_.reset();
}

// After a new zero the samples of the first run no longer mean anything.
TEST_F(Gateway, ARunIsNotContinuedUnderAnotherZero) {
  start_rig();
  Child& daemon = start_daemon(foreign_config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, foreign_protocol("0.2", "0.002")).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "load"; });
  daemon.signal(SIGKILL);
  daemon.wait(5s);
  EXPECT_THAT(panel("ZERO force=1 travel=0"), HasSubstr("OK"));
  start_daemon(foreign_config(), "d2");
  Control again = control();
  EXPECT_EQ(again.call("status")["result"]["resumable"].size(), 1U);
  const json answer = again.call("run.resume", {{"run", 1}, {"confirm_specimen", true}});
  EXPECT_EQ(again.call("status")["result"]["resumable"].size(), 0U) << "not proposed again";
  EXPECT_THAT(answer.dump(), HasSubstr("the zero of force or travel was lost or changed since"));
  EXPECT_THAT(answer.dump(), testing::Not(HasSubstr("interrupted while it zeroed")));
  EXPECT_EQ(number("SELECT count(*) FROM run"), 1);
  end_gateway();
  gateway_.reset();
}

// A frame whose stop is polled and slow. Only the stiffness in the config makes a run possible.
TEST_F(Gateway, ASlowPollingFrameIsSlowedDownAndStaysWithinTheLimit) {
  auto slow = kForeign;
  slow.insert(slow.end(), {"device_stop=false", "poll_reaction_s=0.05", "start_travel_mm=29.9"});
  start_rig(slow);
  start_daemon(foreign_config(400));
  std::string text = foreign_protocol("0.5", "0.012");
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

// lcrig's own simulator must pass the check for authors of gateways.
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
