// SPDX-License-Identifier: Apache-2.0
// lcrigd with a config file that is good, bad or missing.
#include <filesystem>

#include "tests/e2e/rig.hpp"

namespace lcrig::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ConfigFile : public Rig {
 protected:
  Ended lcrigd(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), LCRIG_BIN "/lcrigd");
    return program(arguments, 15s);
  }
};

TEST_F(ConfigFile, TheShippedExampleIsInOrder) {
  const auto done = lcrigd({"--check-config", "--config", "systemd/lcrigd.example.json"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("in order"), HasSubstr("simulated bench paper")));
}

TEST_F(ConfigFile, AnAnswerThatNobodyGetsIsAFailure) {
  for (const std::string asked :
       {"lcrigd --help", "lcrigd --version", "lcrig-sim --help", "lcrig --version",
        "lcrigd --check-config --config systemd/lcrigd.example.json"}) {
    const auto done = program({"/bin/sh", "-c", LCRIG_BIN "/" + asked + " > /dev/full"});
    EXPECT_EQ(done.code, 1) << asked;
    EXPECT_THAT(done.err, AllOf(HasSubstr("cannot write to standard output"), HasSubstr("next: ")));
  }
}

TEST_F(ConfigFile, AMetricsFileReplacesNothingElse) {
  json config{{"format", "lcrigd-config/1"},
              {"bench", "paper"},
              {"database", file("new.db")},
              {"socket", file("new.sock")}};
  write("precious.prom", "not ours");
  write("ours.prom", "# HELP lcrig_up whatever\n");
  std::filesystem::create_symlink(file("precious.prom"), file("link.prom"));
  const std::vector<std::pair<std::string, std::string>> bad{
      {file("new.db"), "needs for something else"},
      {file("new.db-wal"), "needs for something else"},
      {file("new.sock"), "needs for something else"},
      {file("metrics.json"), "needs for something else"},
      {file("precious.prom"), "holds something else"},
      {file("link.prom"), "no plain file"},
      {"/dev/full", "no plain file"},
      {file("nowhere/a.prom"), "there is no folder"}};
  for (const auto& [path, words] : bad) {
    config["metrics_file"] = path;
    write("metrics.json", config.dump());
    const auto done = lcrigd({"--check-config", "--config", file("metrics.json")});
    EXPECT_EQ(done.code, 2) << path;
    EXPECT_THAT(done.err, AllOf(HasSubstr("metrics_file"), HasSubstr(words))) << path;
  }
  for (const char* good : {"ours.prom", "new.prom"}) {
    config["metrics_file"] = file(good);
    write("metrics.json", config.dump());
    const auto done = lcrigd({"--check-config", "--config", file("metrics.json")});
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr(good));
  }
}

TEST_F(ConfigFile, ACheckNamesTheInstrumentsAndOpensNothing) {
  write("real.json", R"({"format": "lcrigd-config/1",
    "meter": {"driver": "lcr6100", "port": "/dev/no-such-port"},
    "frame": {"driver": "dead_weight"},
    "fixture": {"probe_diameter_mm": 4.0}})");
  const auto done = lcrigd({"--check-config", "--config", file("real.json")});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("/dev/no-such-port"), HasSubstr("dead weights")));
}

TEST_F(ConfigFile, WhatCannotBeOpenedIsRefusedAndLeavesNothingBehind) {
  struct Case {
    std::string key, value, words;
  };
  const std::vector<Case> bad{{"bench", "papier", "no bench `papier`"},
                              {"bench", file("none.json"), "none.json"},
                              {"bench", "replay:" + file("nowhere"), "nowhere"},
                              {"database", file(""), "is a folder"},
                              {"database", file("nowhere/a.db"), "there is no folder"},
                              {"socket", file("nowhere/s.sock"), "there is no folder"},
                              {"socket", file("text"), "exists and is no socket"},
                              {"socket", file(std::string(120, 's')), "at most 107"}};
  write("text", "of somebody");
  for (const auto& [key, value, words] : bad) {
    json config{{"format", "lcrigd-config/1"},
                {"bench", "paper"},
                {"database", file("new.db")},
                {"socket", file("new.sock")}};
    config[key] = value;
    write("bad.json", config.dump());
    for (const bool check : {true, false}) {
      std::vector<std::string> arguments{"--config", file("bad.json")};
      if (check) arguments.emplace_back("--check-config");
      const auto done = lcrigd(arguments);
      EXPECT_EQ(done.code, 2) << config << done.err;
      EXPECT_THAT(done.err, AllOf(HasSubstr("bad.json"), HasSubstr(words), HasSubstr("next: ")));
    }
    EXPECT_FALSE(std::filesystem::exists(file("new.db"))) << config;
  }
}

TEST_F(ConfigFile, ACheckSaysWhatItTookAndWarnsOfAMissingLogFolder) {
  json real = json::parse(R"({"format": "lcrigd-config/1",
    "meter": {"driver": "lcr6100", "port": "/dev/no-meter"},
    "frame": {"driver": "zwick", "port": "/dev/no-frame", "stiffness_N_mm": 200, "force_class": 0.5},
    "fixture": {"probe_diameter_mm": 4.0}})");
  real["wire_log_directory"] = file("nowhere");
  write("real.json", real.dump());
  const auto done = lcrigd({"--check-config", "--config", file("real.json")});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("200 N/mm"), HasSubstr("0.5"), HasSubstr("4 mm"),
                              HasSubstr("9.80665 m/s2"), HasSubstr("nowhere")));
  EXPECT_THAT(done.err, HasSubstr("there is no such folder"));
  real["frame"]["port"] = "/dev/no-meter";
  write("real.json", real.dump());
  const auto same = lcrigd({"--check-config", "--config", file("real.json")});
  EXPECT_EQ(same.code, 2);
  EXPECT_THAT(same.err, HasSubstr("both /dev/no-meter"));
}

TEST_F(ConfigFile, ACheckWarnsOfADatabaseThatCannotBeMadeNow) {
  const json config{{"format", "lcrigd-config/1"}, {"bench", "paper"}};
  write("c.json", config.dump());
  const auto check = [this](const std::string& database) {
    const auto done =
        lcrigd({"--check-config", "--config", file("c.json"), "--db", file(database)});
    EXPECT_EQ(done.code, 0) << done.err;
    return done.err;
  };
  EXPECT_EQ(check("a.db"), "");
  write("a.db-wal", "readings");
  EXPECT_THAT(check("a.db"), HasSubstr("move the database back beside it"));
  std::filesystem::create_symlink(file("none.db"), file("link.db"));
  EXPECT_THAT(check("link.db"), HasSubstr("a link to nothing"));
  if (std::filesystem::exists("/var/lib/lcrig")) return;
  const auto shipped = lcrigd({"--check-config", "--config", "systemd/lcrigd.example.json"});
  EXPECT_THAT(shipped.err, HasSubstr("there is no folder /var/lib/lcrig for `database`"));
}

// With exit status 2 the unit does not start the daemon again (RestartPreventExitStatus).
TEST_F(ConfigFile, ABadOneIsRefusedWithItsPlaceAndStatus2) {
  write("bad.json", "{ \"format\": \"lcrigd-config/1\",\n  \"meters\": {} }");
  for (const bool check : {true, false}) {
    std::vector<std::string> arguments{"--config", file("bad.json")};
    if (check) arguments.emplace_back("--check-config");
    const auto done = lcrigd(arguments);
    EXPECT_EQ(done.code, 2) << done.err;
    EXPECT_THAT(done.err, AllOf(HasSubstr("bad.json"), HasSubstr("meters")));
  }
}

TEST_F(ConfigFile, ACheckTellsAllThatIsWrong) {
  const json config{{"format", "lcrigd-config/1"},
                    {"bench", file("none.json")},
                    {"database", file("nowhere/a.db")},
                    {"socket", file(std::string(120, 's'))}};
  write("bad.json", config.dump());
  const auto daemons = lcrigd({"--check-config", "--config", file("bad.json")});
  const auto commands = lcrig({"config", "check", file("bad.json")});
  EXPECT_EQ(daemons.code, 2);
  EXPECT_EQ(commands.code, 1);
  for (const auto& said : {daemons.err, commands.err}) {
    EXPECT_THAT(said, AllOf(HasSubstr("none.json"), HasSubstr("there is no folder"),
                            HasSubstr("at most 107")));
  }
}

TEST_F(ConfigFile, AMissingOneSaysWhereTheExampleIs) {
  const auto done = lcrigd({"--config", file("none.json")});
  EXPECT_EQ(done.code, 2) << done.err;
  EXPECT_THAT(done.err, AllOf(HasSubstr("none.json"), HasSubstr("lcrigd.example.json")));
}

}  // namespace
}  // namespace lcrig::e2e
