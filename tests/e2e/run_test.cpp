// SPDX-License-Identifier: Apache-2.0
// A run on ptys and TCP from the first command to the CSV, and the stops that a person can ask for.
#include <algorithm>
#include <fstream>
#include <iterator>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

const auto in_step = [](const char* id) {
  return [id](const json& status) { return status.value("step", "") == id; };
};
const auto in_state = [](const char* state) {
  return [state](const json& status) { return status.value("state", "") == state; };
};

std::int64_t lines_of(const std::string& path) {
  std::ifstream file(path);
  return std::count(std::istreambuf_iterator<char>(file), {}, '\n');
}

TEST_F(Rig, DaemonRunsAProtocolOnPtyAndTcp) {
  start_sim();
  start_daemon(config());
  write("quick.json", kQuickProtocol);
  const Ended run = lcrig({"run", file("quick.json"), "--specimen", "paper-1", "--json", "--socket",
                           file("control.sock")});
  EXPECT_EQ(run.code, 0) << run.err;
  const json end = run.last_line();
  ASSERT_TRUE(end.is_object()) << run.out;
  EXPECT_EQ(end.value("exit_status", ""), "success") << end;
  EXPECT_GT(end.value("lcr_readings", 0), 10);
  EXPECT_GT(end.value("frame_samples", 0), 50);
  EXPECT_EQ(number("SELECT count(*) FROM lcr_reading"), end.value("lcr_readings", 0));
  // The force that the device reports when it stops; 50 samples a second may miss the peak.
  EXPECT_NEAR(number("SELECT json_extract(detail, '$.force_N') FROM event "
                     "WHERE step_id = 'load' AND kind = 'motion'"),
              0.3, 0.03);
  const Ended exported = lcrig({"export", "last", "--db", file("lcrig.db"), "-o", file("csv")});
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_EQ(lines_of(file("csv/lcr.csv")), 1 + end.value("lcr_readings", 0));
  EXPECT_EQ(lines_of(file("csv/frame.csv")), 1 + end.value("frame_samples", 0));
}

// A simulator with a bench file of its own, derived from that of the other tests.
TEST_F(Rig, AThousandSamplesASecondAreStoredWithoutAGap) {
  std::ifstream quick(file("bench.json"));
  std::string bench(std::istreambuf_iterator<char>(quick), {});
  const std::string frame = R"("frame": { )";
  bench.insert(bench.find(frame) + frame.size(), R"("rate_max_Hz": 1000, )");
  write("bench.json", bench);
  std::string text = kQuickProtocol;
  const std::string rate = R"("rate_Hz": 50)";
  text.replace(text.find(rate), rate.size(), R"("rate_Hz": 1000)");
  write("fast.json", text);
  start_sim();
  start_daemon(config());
  const std::vector<std::string> run{"run",     file("fast.json"), "--specimen",
                                     "paper-1", "--socket",        file("control.sock")};
  std::vector<std::string> dry = run;
  dry.emplace_back("--dry-run");
  EXPECT_THAT(lcrig(dry).out, HasSubstr("of the frame, 1000 a second"));
  const Ended ran = lcrig(run);
  EXPECT_EQ(ran.code, 0) << ran.err;
  const double samples = number("SELECT count(*) FROM frame_sample");
  EXPECT_GT(samples, 2000);
  EXPECT_EQ(samples, number("SELECT max(device_seq) - min(device_seq) + 1 FROM frame_sample"));
  EXPECT_NEAR(
      number("SELECT (max(device_time_s) - min(device_time_s)) * 1000 + 1 FROM frame_sample"),
      samples, 0.5);
}

TEST_F(Rig, ASimulatorBeyondItsModelTellsTheRun) {
  start_sim({"--max-force-N", "0.1"});  // the run goes to 0.3 N
  start_daemon(config());
  write("quick.json", kQuickProtocol);
  const Ended run =
      lcrig({"run", file("quick.json"), "--specimen", "paper-1", "--socket", file("control.sock")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_GE(number("SELECT count(*) FROM event WHERE kind = 'device_extrapolated'"), 1);
  const Ended analysed = lcrig({"analyze", "last", "--db", file("lcrig.db")});
  EXPECT_THAT(analysed.out, HasSubstr("computed up to 0.1 N only"));
}

TEST_F(Rig, ADaemonThatHangsIsCriticalToMonitoring) {
  start_sim();
  Child& daemon = start_daemon(config());
  EXPECT_EQ(lcrig({"status", "--check", "--socket", file("control.sock")}).code, 0);
  daemon.signal(SIGSTOP);
  const Ended hangs = lcrig({"status", "--check", "--socket", file("control.sock")}, 10s);
  EXPECT_EQ(hangs.code, 2) << "within the 10 s that such programs wait";
  EXPECT_THAT(hangs.out, HasSubstr("LCRIG CRITICAL: "));
  daemon.signal(SIGCONT);
}

// A bench that the daemon simulates ends with the daemon.
TEST_F(Rig, OfABenchOnlyARunThatHasNotUsedItsFrameIsProposed) {
  const json bench{{"format", "lcrigd-config/1"},
                   {"bench", file("bench.json")},
                   {"database", file("lcrig.db")},
                   {"socket", file("control.sock")}};
  std::string waits_first = kSlowProtocol;
  const std::string steps = "\"steps\": [";
  waits_first.insert(waits_first.find(steps) + steps.size(),
                     R"({ "id": "air", "do": "record", "for_s": 60 },)");
  const auto cut_off_in = [&](const std::string& protocol, const char* step,
                              const std::string& name) {
    Child& daemon = start_daemon(bench, name);
    Control client = control();
    client.call("watch");
    ASSERT_TRUE(start_run(client, protocol).contains("result"));
    client.wait_for("status", in_step(step), 30s);
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.wait(5s), 128 + SIGKILL);
  };
  cut_off_in(kSlowProtocol, "away", "d1");
  cut_off_in(waits_first, "air", "d2");
  start_daemon(bench, "d3");
  Control again = control();
  const json proposed = again.call("status")["result"]["resumable"];
  ASSERT_EQ(proposed.size(), 1U) << proposed;
  EXPECT_EQ(proposed[0]["run"], 2);
  const json refused = again.call("run.resume", {{"run", 1}, {"confirm_specimen", true}});
  EXPECT_THAT(refused.dump(), HasSubstr("cannot be continued"));
  const json taken = again.call("run.resume", {{"run", 2}, {"confirm_specimen", true}});
  EXPECT_TRUE(taken.contains("result")) << taken;
}

TEST_F(Rig, ABundleOfARunHoldsNoMeasuredValueUnlessAsked) {
  start_sim();
  start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kQuickProtocol).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("lcr_readings", 0) > 3; });
  const auto bundled = [&](std::vector<std::string> options) {
    const std::string folder = file("bundle" + std::to_string(options.size()));
    const std::string packed = folder + ".tar.gz";
    options.insert(options.begin(), {"doctor", "--socket", file("control.sock"), "--db",
                                     file("lcrig.db"), "--bundle", packed});
    const Ended done = lcrig(options);
    EXPECT_THAT(done.out, testing::Not(HasSubstr("but this lcrig is")));
    std::filesystem::create_directories(folder);
    EXPECT_EQ(std::system(("tar -xzf " + packed + " -C " + folder).c_str()), 0);  // NOLINT
    return json::parse(std::ifstream(folder + "/doctor-bundle/status.json"))["run"];
  };
  const json bare = bundled({}), full = bundled({"--with-data"});
  EXPECT_EQ(bare.value("protocol", ""), "quick");
  for (const char* measured : {"capacitance_pF", "force_N", "travel_mm", "pressure_kPa"}) {
    EXPECT_FALSE(bare.contains(measured)) << measured;
    EXPECT_TRUE(full.contains(measured)) << measured;
  }
  client.run_ended(20s);
}

TEST_F(Rig, TheNextRunFindsTheSamePorts) {
  start_sim();
  start_daemon(config());
  for (int run = 1; run <= 2; ++run) {
    Control client = control();
    client.call("watch");
    const json started = start_run(client, kQuickProtocol);
    ASSERT_TRUE(started.contains("result")) << started;
    EXPECT_EQ(client.run_ended(20s).value("exit_status", ""), "success");
  }
}

TEST_F(Rig, PauseResumeAbort) {
  start_sim();
  start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", in_step("away"));

  EXPECT_TRUE(client.call("run.pause").contains("result"));
  client.wait_for("status", in_state("paused"));
  wait_until_standing();
  const double paused_mm = sim("status").value("travel_mm", 0.0);

  EXPECT_TRUE(client.call("run.resume").contains("result"));
  client.wait_for("status", in_state("running"));
  client.wait_for(
      "status", [=](const json& s) { return s.value("travel_mm", paused_mm) < paused_mm - 0.02; });

  EXPECT_TRUE(client.call("run.abort", {{"why", "enough"}}).contains("result"));
  const json end = client.run_ended();
  EXPECT_EQ(end.value("exit_status", ""), "abort");
  EXPECT_THAT(end.value("reason", ""), HasSubstr("enough"));
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "abort\n");
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind = 'step_begin' AND step_id = 'clear'"), 1)
      << "`finally` did not run";
}

TEST_F(Rig, FreezeStaysWhereItIs) {
  start_sim();
  start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", in_step("away"));
  EXPECT_TRUE(client.call("run.freeze", {{"why", "look"}}).contains("result"));
  wait_until_standing();
  const double frozen_mm = sim("status").value("travel_mm", 0.0);
  EXPECT_EQ(client.run_ended().value("exit_status", ""), "abort");
  EXPECT_EQ(sim("status").value("travel_mm", 0.0), frozen_mm);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE step_id = 'clear'"), 0);
}

TEST_F(Rig, TermInTheMiddleOfAStepStopsTheFrameAndClosesTheRun) {
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", in_step("away"));
  ASSERT_TRUE(sim("status").value("moving", false));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(15s), 0) << daemon.log();
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "abort\n");
  EXPECT_THAT(query("SELECT reason FROM run_end"), HasSubstr("SIGTERM"));
  EXPECT_GE(number("SELECT count(*) FROM event WHERE kind = 'stopped'"), 1);
  EXPECT_EQ(query("SELECT detail FROM event WHERE kind = 'step_end' AND step_id = 'clear'"),
            "done\n");
  EXPECT_FALSE(sim("settle").value("moving", true));
}

// Wide and nearly incompressible layers of two thicknesses between thin films need fine meshes. As
// many as a specimen may have, so that a fast computer needs far longer than the daemon waits: 120
// of them took one 4 s.
std::string specimen_of_many_layers() {
  std::string capacitors;
  for (int i = 0; i < 490; ++i) {
    capacitors += std::string(i > 0 ? "," : "") +
                  R"({ "layers": [ { "material": "PDMS", "thickness_um": )" +
                  (i % 2 == 0 ? "15" : "60") + R"( },
                                   { "material": "kapton", "thickness_um": 12.5 } ] })";
  }
  return R"({ "format": "specimen/1", "name": "many", "disc_diameter_mm": 8.0,
    "faces": "bonded_laminate", "top": "bonded_plate", "materials": {
      "PDMS": { "relative_permittivity": 2.75, "youngs_modulus_kPa": 200, "poisson_ratio": 0.499 },
      "kapton": { "relative_permittivity": 3.5, "youngs_modulus_kPa": 2500000,
                  "poisson_ratio": 0.34 } },
    "capacitors": [)" +
         capacitors + "] }";
}

TEST_F(Rig, TermDoesNotWaitForASpecimenThatIsStillReckoned) {
  Child& daemon = start_daemon(json{{"format", "lcrigd-config/1"},
                                    {"database", file("lcrig.db")},
                                    {"socket", file("control.sock")},
                                    {"bench", "paper"}});
  const NotifySocket told(file("d1.notify"));
  LineClient client(file("control.sock"));
  client.send(json{{"jsonrpc", "2.0"},
                   {"id", 1},
                   {"method", "run.start"},
                   {"params",
                    {{"protocol", "e2e"},
                     {"protocol_text", kQuickProtocol},
                     {"specimen", "many"},
                     {"specimen_text", specimen_of_many_layers()}}}}
                  .dump());
  ASSERT_TRUE(told.wait("computes the simulated specimen", 20s)) << daemon.log();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(15s), 0) << daemon.log();
  EXPECT_THAT(daemon.log(), HasSubstr("ended without the simulated specimen"));
  EXPECT_EQ(number("SELECT count(*) FROM run"), 0);
}

TEST_F(Rig, KillNineLeavesNothingLost) {
  start_sim();
  Child& daemon = start_daemon(config());
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kSlowProtocol).contains("result"));
  client.wait_for("status", [](const json& s) {
    return s.value("step", "") == "away" && s.value("lcr_readings", 0) >= 30;
  });
  daemon.signal(SIGKILL);
  EXPECT_EQ(daemon.wait(5s), 128 + SIGKILL);
  std::int64_t readings = 30, samples = 0;
  for (const json& news : client.drain()) {
    if (news.value("method", "") != "status") continue;
    readings = news["params"].value("lcr_readings", readings);
    samples = news["params"].value("frame_samples", samples);
  }
  EXPECT_FALSE(sim("settle").value("moving", true)) << "the gateway does not miss its host";
  const Child& next = start_daemon(config(), "d2");
  EXPECT_THAT(next.log(), HasSubstr("interrupted"));
  EXPECT_EQ(query("SELECT exit_status FROM run_end"), "interrupted\n");
  EXPECT_GE(number("SELECT count(*) FROM lcr_reading"), readings);
  EXPECT_GE(number("SELECT count(*) FROM frame_sample"), samples);
  // The ports of the killed daemon are free again.
  Control again = control();
  again.call("watch");
  ASSERT_TRUE(start_run(again, kQuickProtocol).contains("result"));
  EXPECT_EQ(again.run_ended(20s).value("exit_status", ""), "success");
}

}  // namespace
}  // namespace lcrig::e2e
