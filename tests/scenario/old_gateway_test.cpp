// SPDX-License-Identifier: Apache-2.0
// A gateway of revision 1 states neither its force loop nor its steps. With what `lcrig doctor`
// asks for, and no more, the shipped protocols run on it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/config.hpp"
#include "drivers/zwick/sim.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/session_world.hpp"

namespace lcrig {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

class OldGateway final : public SessionWorld {
 public:
  explicit OldGateway(const std::string& protocol, StatedFrame stated = {})
      : SessionWorld(library(protocol)), stated_(std::move(stated)) {}
  // The keys that doctor asks for, once a plan has met the frame.
  std::vector<std::string> asked_for() {
    for (const InstrumentState& i : known_.states(std::nullopt)) {
      if (i.which == Instrument::frame && i.statements_known) return i.unstated;
    }
    ADD_FAILURE() << "nobody knows what the frame states";
    return {};
  }

 private:
  void adjust(SimRequest& sim, Recorder::Options&) override { sim.stated = stated_; }
  void built() override {
    frame(*this).settings().revision = 1;
    known_.declare(Instrument::frame, "sim:frame", "", true);
    session->report_to(known_, LearnedBy::plan);
  }
  StatedFrame stated_;
  KnownRig known_{clock};
};

// A config file that states these keys, as they are true for the bench.
StatedFrame config_with(const std::vector<std::string>& keys) {
  const json truth{{"frame.travel_step_um", 0.1},
                   {"frame.force_loop",
                    {{"approach_mm_s", 0.1},
                     {"contact_N", 0.0025},
                     {"rate_max_N_s", 1000},
                     {"lag_s", 0},
                     {"ripple_N", 0.0025},
                     {"stiffness_max_N_mm", 1e5}}}};
  json file = json::parse(R"({"format": "lcrigd-config/1",
    "meter": {"driver": "lcr6100", "port": "serial:2184:005f"},
    "frame": {"driver": "zwick", "port": "tcp://192.0.2.10:4710"},
    "fixture": {"probe_diameter_mm": 4.0}})");
  for (const std::string& key : keys) {
    file["frame"][key.substr(std::string("frame.").size())] = truth.at(key);
  }
  return parse_config(file.dump(), "rig.json").value().frame.stated;
}

const std::map<std::string, ParameterValues> kShipped{
    {"static-frame", {{"repeats", "1"}, {"levels", "3"}}},
    {"dynamic-cycles", {{"cycles", "1"}, {"gap_mm", "0.2"}}},
    {"preconditioning", {{"cycles", "2"}, {"rest_s", "1"}}},
    {"creep", {{"hold_s", "5"}, {"recovery_s", "5"}}}};

TEST(GatewayOfRevision1, RunsTheShippedProtocolsWithWhatDoctorAsksForAndNoMore) {
  OldGateway bare("static-frame");
  bare.parameters = kShipped.at("static-frame");
  const auto refused = bare.run();
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("state frame.force_loop in the config"));
  const auto keys = bare.asked_for();
  EXPECT_THAT(keys, UnorderedElementsAre("frame.travel_step_um", "frame.force_loop"));
  for (const auto& [name, parameters] : kShipped) {
    SCOPED_TRACE(name);
    OldGateway world(name, config_with(keys));
    world.parameters = parameters;
    const auto r = world.run();
    ASSERT_TRUE(r) << r.error().what;
    EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
    EXPECT_TRUE(world.asked_for().empty());
    const auto stored = json::parse(world.text("SELECT frame_capabilities_json FROM run"));
    EXPECT_EQ(stored.at("force_loop").at("contact_N"), 0.0025);
    EXPECT_DOUBLE_EQ(stored.at("travel_step_m"), 1e-7);
  }
}

// The config states a step that is coarser than that of the samples, so it counts, and is false.
TEST(StatedFacts, ThatSamplesContradictAreAFindingAndEndNoRun) {
  class World final : public SessionWorld {
   public:
    World() : SessionWorld(kLoad) {}

   private:
    void adjust(SimRequest& sim, Recorder::Options&) override {
      sim.stated.travel_step = Length::from_si(2e-6);
    }
  } world;
  const auto r = world.run();
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->exit_status, ExitStatus::success) << r->reason;
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='device_travel_step'"), 1);
  EXPECT_EQ(world.count("SELECT COUNT(*) FROM event WHERE kind='device_force_step'"), 0);
  EXPECT_THAT(world.text("SELECT detail FROM event WHERE kind='device_travel_step'"),
              HasSubstr("steps of 2 um are stated"));
  const auto planned = world.text("SELECT detail FROM event WHERE kind='plan'");
  EXPECT_THAT(planned, HasSubstr("the frame states 0.1 for frame.travel_step_um, the config 2: "
                                 "that of the config counts"));
}

}  // namespace
}  // namespace lcrig
