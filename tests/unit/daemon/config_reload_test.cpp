// SPDX-License-Identifier: Apache-2.0
#include "daemon/config_reload.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/config_check.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

json real_rig() {
  return json::parse(R"({"format": "lcrigd-config/1",
    "meter": {"driver": "lcr6100", "port": "serial:2184:005f"},
    "frame": {"driver": "zwick", "port": "tcp://192.0.2.10:4710", "stiffness_N_m": 120000},
    "fixture": {"probe_diameter_mm": 4.0}})");
}

Config config_of(const json& file) {
  return parse_config(file.dump(), "rig.json").value();
}

class Reload : public testing::Test {
 protected:
  const ConfigKeyView& key(const std::string& name) {
    view_ = reload_.view();
    for (const auto& k : view_.keys) {
      if (k.key == name) return k;
    }
    ADD_FAILURE() << name;
    return view_.keys.front();
  }
  std::vector<std::string> waiting() {
    std::vector<std::string> out;
    const auto view = reload_.view();
    for (const auto& k : view.keys) {
      if (k.waiting) out.push_back(k.key);
    }
    return out;
  }
  json file_ = real_rig();
  Config config_ = config_of(file_);
  ConfigReload reload_{config_};
  ConfigView view_;
};

TEST_F(Reload, OfTheSameFileChangesNothing) {
  EXPECT_THAT(reload_.take(config_of(file_), true), IsEmpty());
  EXPECT_THAT(waiting(), IsEmpty());
}

TEST_F(Reload, TakesAtOnceWhatConcernsNoRun) {
  file_["log_level"] = "debug";
  file_["metrics_file"] = "/var/lib/x.prom";
  EXPECT_THAT(reload_.take(config_of(file_), false),
              ElementsAre("log_level: info -> debug, from now on",
                          "metrics_file: none -> /var/lib/x.prom, from now on"));
  EXPECT_EQ(config_.log_level, "debug");
  EXPECT_EQ(config_.metrics_file, "/var/lib/x.prom");
  EXPECT_EQ(key("log_level").source, ConfigSource::file);
  EXPECT_EQ(key("database").source, ConfigSource::built_in);
}

TEST_F(Reload, ChangesNoFixtureAndNoFrameUnderARun) {
  file_["fixture"]["probe_diameter_mm"] = 5.0;
  file_["frame"]["stiffness_N_m"] = 100000;
  file_["wire_log_directory"] = "/tmp";
  EXPECT_THAT(reload_.take(config_of(file_), false),
              ElementsAre("frame.stiffness_N_mm: 120 -> 100, as soon as the rig is idle",
                          "fixture.probe_diameter_mm: 4 -> 5, as soon as the rig is idle",
                          "wire_log_directory: none -> /tmp, as soon as the rig is idle"));
  EXPECT_DOUBLE_EQ(config_.fixture.probe_diameter_m.value(), 0.004);
  EXPECT_DOUBLE_EQ(config_.frame.stiffness_N_m.value(), 120000);
  EXPECT_EQ(config_.wire_log_directory, "");
  EXPECT_TRUE(key("fixture.probe_diameter_mm").waiting);
  EXPECT_EQ(to_text(key("fixture.probe_diameter_mm").waiting->value), "5");
  EXPECT_EQ(to_text(key("fixture.probe_diameter_mm").value), "4");
  EXPECT_THAT(reload_.take_when_idle(),
              ElementsAre(HasSubstr("100"), HasSubstr("5"), HasSubstr("/tmp")));
  EXPECT_DOUBLE_EQ(config_.fixture.probe_diameter_m.value(), 0.005);
  EXPECT_DOUBLE_EQ(config_.frame.stiffness_N_m.value(), 100000);
  EXPECT_THAT(waiting(), IsEmpty());
  EXPECT_THAT(reload_.take_when_idle(), IsEmpty());
}

TEST_F(Reload, OfAnIdleDaemonTakesThemAtOnce) {
  file_["fixture"]["probe_diameter_mm"] = 5.0;
  EXPECT_THAT(reload_.take(config_of(file_), true),
              ElementsAre("fixture.probe_diameter_mm: 4 -> 5, from the next run on"));
  EXPECT_DOUBLE_EQ(config_.fixture.probe_diameter_m.value(), 0.005);
}

TEST_F(Reload, NamesOneByOneWhatNeedsARestart) {
  file_["database"] = "/var/lib/other.db";
  file_["socket"] = "/run/other.sock";
  const auto told = reload_.take(config_of(file_), true);
  EXPECT_THAT(told, ElementsAre(AllOf(HasSubstr("database: "), HasSubstr("needs a restart")),
                                AllOf(HasSubstr("socket: "), HasSubstr("needs a restart"))));
  EXPECT_EQ(config_.database, Config().database);
  EXPECT_THAT(waiting(), ElementsAre("database", "socket"));
  EXPECT_EQ(key("socket").waiting->effect, ConfigEffect::restart);
  EXPECT_THAT(reload_.take_when_idle(), IsEmpty());
  EXPECT_THAT(reload_.take(config_of(real_rig()), true), IsEmpty()) << "put back";
  EXPECT_THAT(waiting(), IsEmpty());
}

// A probe that belongs to another frame is not mounted on this one.
TEST_F(Reload, NeverTakesHalfARig) {
  file_["frame"]["port"] = "tcp://192.0.2.11:4710";
  file_["fixture"]["probe_diameter_mm"] = 5.0;
  file_["log_level"] = "warn";
  reload_.take(config_of(file_), true);
  EXPECT_DOUBLE_EQ(config_.fixture.probe_diameter_m.value(), 0.004);
  EXPECT_EQ(config_.log_level, "warn");
  EXPECT_THAT(waiting(), UnorderedElementsAre("frame.port", "fixture.probe_diameter_mm"));
  EXPECT_EQ(key("fixture.probe_diameter_mm").waiting->effect, ConfigEffect::restart);
}

TEST_F(Reload, OfABenchInThePlaceOfInstrumentsWaitsForTheRestart) {
  const json bench{{"format", "lcrigd-config/1"}, {"bench", "paper"}};
  reload_.take(config_of(bench), true);
  EXPECT_FALSE(config_.bench);
  EXPECT_EQ(config_.meter_port, "serial:2184:005f");
  EXPECT_TRUE(key("bench").waiting);
  EXPECT_TRUE(key("meter.port").waiting);
}

TEST_F(Reload, OfABadFileIsToldUntilAGoodOneComes) {
  reload_.refuse("rig.json:1:1 / is empty");
  EXPECT_EQ(reload_.view().refused, "rig.json:1:1 / is empty");
  EXPECT_DOUBLE_EQ(config_.fixture.probe_diameter_m.value(), 0.004);
  reload_.take(config_of(file_), true);
  EXPECT_EQ(reload_.view().refused, "");
}

TEST_F(Reload, KeepsWhatTheCommandLineSays) {
  const auto overridden = [this] {
    Config out = config_of(file_);
    out.database = "/tmp/by-hand.db";
    out.of_command_line = {"database"};
    return out;
  };
  config_ = overridden();
  file_["database"] = "/var/lib/other.db";
  EXPECT_THAT(reload_.take(overridden(), true), IsEmpty());
  EXPECT_EQ(key("database").source, ConfigSource::command_line);
}

TEST_F(Reload, ViewSurvivesTheSocket) {
  file_["database"] = "/var/lib/other.db";
  file_["frame"]["force_class"] = 2;
  reload_.take(config_of(file_), false);
  reload_.refuse("no");
  const auto view = to_json(reload_.view());
  const auto read = parse_config_view(view);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(to_json(*read), view);
  for (const char* wrong :
       {"1", "{}", R"({"keys": [1], "file": ""})",
        R"({"keys": [{"key": "a", "value": [], "source": "file"}], "file": ""})",
        R"({"keys": [{"key": "a", "value": 1, "source": "sky"}], "file": ""})"}) {
    EXPECT_FALSE(parse_config_view(json::parse(wrong))) << wrong;
  }
}

// Add a new key of the file here, together with what a change of it requires.
TEST_F(Reload, KnowsEveryKeyOfTheFile) {
  file_ = json::parse(R"({"format": "lcrigd-config/1", "database": "/a.db", "socket": "/s",
    "log_level": "warn", "metrics_file": "/m", "wire_log_directory": "/w",
    "meter": {"driver": "lcr6100", "port": "serial:2184:0060", "serial_number": "7"},
    "frame": {"driver": "zwick", "port": "tcp://192.0.2.1:1", "stiffness_N_mm": 1,
              "start_gap_mm": 1, "force_class": 2, "cell_serial": "X1",
              "travel_step_um": 1, "force_step_mN": 1, "filter_s": 1, "play_um": 1,
              "force_loop": {"approach_mm_s": 1, "contact_N": 1, "rate_max_N_s": 1, "lag_s": 1,
                             "ripple_N": 1, "stiffness_max_N_mm": 1}},
    "fixture": {"probe_diameter_mm": 5, "probe_serial": "P1", "probe_name": "steel",
                "local_gravity_m_s2": 9.81, "stray_limit_fF": 300}})");
  const auto config = config_of(file_);
  std::vector<std::string> given = config.given, known;
  std::erase(given, "format");
  for (const auto& k : keys_of(config)) {
    known.push_back(k.key);
    EXPECT_EQ(k.source, ConfigSource::file) << k.key;
  }
  EXPECT_THAT(known, testing::UnorderedElementsAreArray(given));
  constexpr std::size_t kDrivers = 2;  // the same in both
  EXPECT_EQ(changes_of(config_, config).size(), known.size() - kDrivers) << "a change is noticed";
}

}  // namespace
}  // namespace lcrig
