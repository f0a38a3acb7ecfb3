// SPDX-License-Identifier: Apache-2.0
// lcrigd when it is asked to read its config file again (SIGHUP, systemctl reload).
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <thread>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ReloadedDaemon : public Rig {
 protected:
  void SetUp() override {
    Rig::SetUp();
    start_sim();
    config_ = config();
    daemon_ = &start_daemon(config_);
    notify_.emplace(file("d1.notify"));
  }
  // Writes the file and waits until the daemon says that it has read it.
  void reload(const std::string& text) {
    // Drains the socket first: it holds ten messages, and a run sends one a second.
    EXPECT_FALSE(notify_->wait("what nobody says", 100ms));
    write("d1.json", text);
    daemon_->signal(SIGHUP);
    EXPECT_TRUE(notify_->wait("RELOADING=1\nMONOTONIC_USEC=", 15s)) << daemon_->log();
    EXPECT_TRUE(notify_->wait("READY=1", 15s)) << daemon_->log();
  }
  // A thread of its own writes the log, so this waits.
  void expect_logged(const std::string& words) const {
    const auto there = [&] { return daemon_->log().find(words) != std::string::npos; };
    for (int i = 0; i < 250 && !there(); ++i) std::this_thread::sleep_for(20ms);
    EXPECT_TRUE(there()) << words << "\n" << daemon_->log();
  }
  json view() const {
    Control client = control();
    return client.call("config.show")["result"];
  }
  static json key(const json& view, const std::string& name) {
    for (const json& k : view["keys"]) {
      if (k["key"] == name) return k;
    }
    return nullptr;
  }

  json config_;
  Child* daemon_ = nullptr;
  std::optional<NotifySocket> notify_;
};

TEST_F(ReloadedDaemon, TakesAGoodFileAndNeverABadOne) {
  EXPECT_EQ(key(view(), "log_level")["source"], "default");
  config_["log_level"] = "debug";
  reload(config_.dump());
  expect_logged("log_level: info -> debug, from now on");
  EXPECT_EQ(key(view(), "log_level")["value"], "debug");
  EXPECT_EQ(key(view(), "log_level")["source"], "file");
  json wrong = config_;
  wrong["fixture"]["probe_diameter_mm"] = -1;
  json elsewhere = config_;
  elsewhere["database"] = file("nowhere/a.db");
  for (const auto& text : {std::string(), std::string("{"), wrong.dump(), elsewhere.dump()}) {
    reload(text);
    const json now = view();
    EXPECT_THAT(now["refused"].dump(), HasSubstr("d1.json")) << text;
    EXPECT_EQ(key(now, "log_level")["value"], "debug") << text;
    const auto checked = lcrig({"config", "check", file("d1.json")});
    EXPECT_NE(checked.code, 0) << text;
    EXPECT_THAT(checked.err, AllOf(HasSubstr("d1.json"), HasSubstr("next: "))) << text;
  }
  expect_logged("the config file is not taken: lcrigd goes on");
  reload("{\n  \"format\": \"lcrigd-config/1\",\n  \"databse\": \"a.db\"\n}\n");
  expect_logged("\"databse\": \"a.db\"\n");
  expect_logged("  ^\n");
  EXPECT_THAT(daemon_->log(), testing::Not(HasSubstr("\\x0a"))) << "one entry for each line";
  reload(config_.dump());
  EXPECT_TRUE(view()["refused"].is_null());
  EXPECT_FALSE(daemon_->wait(0ms)) << "a reload is no stop";
}

TEST_F(ReloadedDaemon, APipeInTheFilesPlaceIsRefusedAndHoldsUpNothing) {
  std::filesystem::remove(file("d1.json"));
  ASSERT_EQ(::mkfifo(file("d1.json").c_str(), 0600), 0);
  daemon_->signal(SIGHUP);
  EXPECT_TRUE(notify_->wait("READY=1", 15s)) << daemon_->log();
  EXPECT_THAT(view()["refused"].dump(), HasSubstr("a pipe or a device"));
  const auto checked = lcrig({"config", "check", file("d1.json")}, 10s);
  EXPECT_EQ(checked.code, 1) << checked.err;
  EXPECT_THAT(checked.err, HasSubstr("a pipe or a device"));
}

// Such as a link that points to itself, or a folder without access.
TEST_F(ReloadedDaemon, AFileThatCannotBeReachedIsRefusedAndEndsNoRun) {
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kQuickProtocol).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "load"; });
  std::filesystem::remove(file("d1.json"));
  std::filesystem::create_symlink("d1.json", file("d1.json"));
  daemon_->signal(SIGHUP);
  expect_logged("the config file is not taken: lcrigd goes on");
  EXPECT_THAT(view()["refused"].dump(), HasSubstr("Too many levels of symbolic links"));
  EXPECT_EQ(client.run_ended().value("exit_status", ""), "success") << daemon_->log();
  const auto checked =
      program({LCRIG_BIN "/lcrigd", "--check-config", "--config", file("d1.json")}, 15s);
  EXPECT_EQ(checked.code, 2) << checked.err;
  EXPECT_THAT(checked.err, HasSubstr("Too many levels of symbolic links"));
}

TEST_F(ReloadedDaemon, NamesWhatNeedsARestart) {
  config_["socket"] = file("other.sock");
  config_["meter"]["port"] = "/dev/no-such-port";
  reload(config_.dump());
  for (const char* words : {"socket: ", "meter.port: ", "needs a restart"}) expect_logged(words);
  const json now = view();
  EXPECT_EQ(key(now, "meter.port")["waiting"]["value"], "/dev/no-such-port");
  EXPECT_EQ(key(now, "meter.port")["waiting"]["for"], "restart");
  const auto shown = lcrig({"config", "show", "--socket", file("control.sock")});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, AllOf(HasSubstr("in force, of "), HasSubstr("takes a restart of lcrigd")));
  const auto of_file =
      lcrig({"config", "show", "--config", file("d1.json"), "--socket", file("nobody.sock")});
  EXPECT_EQ(of_file.code, 0) << of_file.err;
  EXPECT_THAT(of_file.out, HasSubstr("/dev/no-such-port"));
}

TEST_F(ReloadedDaemon, LeavesARunAlone) {
  Control client = control();
  client.call("watch");
  ASSERT_TRUE(start_run(client, kQuickProtocol).contains("result"));
  client.wait_for("status", [](const json& s) { return s.value("step", "") == "load"; });
  const double before_mm = config_["fixture"]["probe_diameter_mm"];
  config_["fixture"]["probe_diameter_mm"] = before_mm + 1;
  config_["log_level"] = "debug";
  reload(config_.dump());
  EXPECT_EQ(key(view(), "fixture.probe_diameter_mm")["waiting"]["for"], "when idle");
  EXPECT_EQ(key(view(), "log_level")["value"], "debug");
  reload("");
  const json ended = client.run_ended();
  EXPECT_EQ(ended.value("exit_status", ""), "success") << ended;
  EXPECT_NEAR(number("SELECT probe_diameter_m FROM run WHERE id = 1") * 1e3, before_mm, 1e-9);
  EXPECT_EQ(number("SELECT count(*) FROM event WHERE kind IN ('request', 'stop', 'lost')"), 1)
      << "the start";
  const json after = key(view(), "fixture.probe_diameter_mm");
  EXPECT_TRUE(after["waiting"].is_null()) << after;
  EXPECT_NEAR(after["value"].get<double>(), before_mm + 1, 1e-9);
}

}  // namespace
}  // namespace lcrig::e2e
