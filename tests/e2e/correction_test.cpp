// SPDX-License-Identifier: Apache-2.0
// The meter's open correction from the command line, with a meter on a pty that takes its time.
#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::HasSubstr;

TEST_F(Rig, AnOpenCorrectionIsMadeKeptByTheMeterAndStandsInTheNextRun) {
  start_sim();
  start_daemon(config());
  const std::vector<std::string> where{"--socket", file("control.sock")};
  const auto lcr = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "lcr");
    words.insert(words.end(), where.begin(), where.end());
    return lcrig(words, 60s);
  };
  const Ended unprepared = lcr({"correct", "open"});
  EXPECT_EQ(unprepared.code, 2) << "nobody is at a terminal";
  const Ended made = lcr({"correct", "open", "--yes", "--json"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.last_line().at("open").at("on"), true);
  const Ended shown = lcr({"show", "--json"});
  EXPECT_EQ(shown.code, 0) << shown.err;
  const json meter = shown.last_line().at("meters").at(0);
  EXPECT_EQ(meter.at("open").at("on"), true);
  EXPECT_EQ(meter.at("short").at("on"), false);
  EXPECT_EQ(query("SELECT kind || ' ' || meter FROM lcr_correction"), "open LCR-6100 SIM000001\n");

  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kQuickProtocol).contains("result"));
  const Ended refused = lcr({"correct", "short", "--yes"});
  EXPECT_NE(refused.code, 0);
  EXPECT_THAT(refused.err, HasSubstr("run 1 is going on"));
  EXPECT_EQ(client.run_ended(30s).value("exit_status", ""), "success");
  const json of_run = json::parse(query("SELECT correction_json FROM run"));
  EXPECT_EQ(of_run.at("open").at("on"), true);
  EXPECT_EQ(of_run.at("open").at("made_unix_ns"), made.last_line().at("open").at("made_unix_ns"));
  EXPECT_EQ(of_run.at("short").at("on"), false);
  const Ended report = lcrig({"report", "1", "--db", file("lcrig.db"), "-o", file("r.html")});
  EXPECT_EQ(report.code, 0) << report.err;
}

}  // namespace
}  // namespace lcrig::e2e
