// SPDX-License-Identifier: Apache-2.0
// `lcrig doctor` asks for what the frame does not state, and writes it into the config file.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <deque>
#include <filesystem>
#include <fstream>

#include "base/strict_json.hpp"
#include "tests/support/without_rights.hpp"
#include "tests/unit/tools/served.hpp"
#include "tools/lcrig/state_frame.hpp"

namespace lcrig::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// A daemon whose frame states neither its force loop nor its step of travel, and a config file.
class DoctorOfAnOldGateway : public support::Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    cli.env.daemon_config = cli.dir.file("lcrigd.json");
    std::ofstream(config()) << before_;
    on_server([&] {
      InstrumentState frame;
      frame.which = Instrument::frame;
      frame.statements_known = true;
      frame.unstated = {"frame.travel_step_um", "frame.force_loop"};
      handler.state.instruments = {frame};
    });
  }
  std::string config() const { return cli.env.daemon_config.string(); }
  std::string text() const { return read_text_file(config()).value(); }
  // Values of the file as `lcrig config check` shows them.
  std::string shown() {
    EXPECT_EQ(cli.run({"config", "check", config()}), kOk) << cli.err.str();
    return cli.out.str();
  }
  const std::string before_ = fmt::format(R"({{ "format": "lcrigd-config/1",  // of the lab
  "database": "{0}/rig.db", "socket": "{0}/s.sock",
  "meter": {{ "driver": "lcr6100", "port": "serial:2184:005f" }},
  "frame": {{ // the Z0.5
    "driver": "zwick", "port": "tcp://192.0.2.10:4710" }},
  "fixture": {{ "probe_diameter_mm": 4 }} }}
)",
                                          cli.dir.path().string());
};

TEST_F(DoctorOfAnOldGateway, SaysWhatNobodyStatesAndAsksNobodyWithoutATerminal) {
  cli.typed = "0.1";
  cli.run({"doctor"});
  EXPECT_THAT(cli.out.str(), HasSubstr("states frame.travel_step_um and frame.force_loop"));
  EXPECT_THAT(cli.out.str(), HasSubstr("lcrig doctor --state KEY=VALUE"));
  cli.tty = true;
  cli.run({"doctor", "--json"});
  EXPECT_EQ(text(), before_);
}

TEST_F(DoctorOfAnOldGateway, AsksOnceAtATerminalAndKeepsTheRestOfTheFile) {
  cli.tty = true;
  cli.typed = "0.5";
  cli.run({"doctor"});
  EXPECT_THAT(cli.err.str(), HasSubstr("nothing is guessed"));
  EXPECT_THAT(cli.out.str(), HasSubstr("written into"));
  EXPECT_THAT(cli.out.str(), Not(HasSubstr("neither the frame")));
  const std::string after = text();
  const std::string added =
      R"( "travel_step_um": 0.5, "force_loop": { "approach_mm_s": 0.5, "contact_N": 0.5,)"
      R"( "rate_max_N_s": 0.5, "lag_s": 0.5, "ripple_N": 0.5, "stiffness_max_N_mm": 0.5 },)";
  std::string expected = before_;
  expected.insert(expected.find("{ // the Z0.5") + 1, added);
  EXPECT_EQ(after, expected);
  EXPECT_THAT(shown(), HasSubstr("frame.force_loop.ripple_N"));
  cli.run({"doctor"});
  EXPECT_EQ(cli.err.str().find("nothing is guessed"), std::string::npos) << "asked again";
  EXPECT_EQ(text(), after);
}

TEST(DoctorQuestions, AreAskedAgainAfterNonsenseAndAForceLoopIsStatedWholeOrNot) {
  std::ostringstream out, err;
  Console console(out, err);
  std::deque<std::string> typed{"fine", "-1", "0.1", "0.5", "0.02", ""};
  console.enter = [&]() -> std::optional<std::string> {
    if (typed.empty()) return std::nullopt;
    const std::string line = typed.front();
    typed.pop_front();
    return line;
  };
  const auto stated = ask_for_statements(console, {"frame.travel_step_um", "frame.force_loop"});
  ASSERT_EQ(stated.size(), 1U) << "the third value of the force loop was left out";
  EXPECT_EQ(stated[0].key, "travel_step_um");
  EXPECT_EQ(stated[0].value, 0.1);
  EXPECT_THAT(err.str(), HasSubstr("fine: expected a number from 0 on"));
  EXPECT_TRUE(ask_for_statements(console, {"frame.force_loop"}).empty()) << "the terminal is gone";
}

TEST_F(DoctorOfAnOldGateway, TakesValuesFromAScriptAndGuessesNone) {
  EXPECT_EQ(cli.run({"doctor", "--state", "colour=1"}), kUsage);
  EXPECT_THAT(cli.err.str(), HasSubstr("travel_step_um, force_loop.approach_mm_s"));
  EXPECT_EQ(cli.run({"doctor", "--state", "travel_step_um=fine"}), kUsage);
  cli.run({"doctor", "--state", "force_loop.lag_s=0.1"});
  EXPECT_THAT(cli.out.str(), HasSubstr("force_loop.approach_mm_s is missing"));
  EXPECT_EQ(text(), before_);
  cli.run({"doctor", "--state", "travel_step_um=0.1", "--state", "play_um=3"});
  EXPECT_THAT(text(), HasSubstr(R"({ "travel_step_um": 0.1, "play_um": 3, // the Z0.5)"));
  EXPECT_THAT(cli.out.str(), HasSubstr("states frame.force_loop;"));
  cli.run({"doctor", "--state", "travel_step_um=0.2"});
  EXPECT_THAT(cli.out.str(), HasSubstr("not written"));
  EXPECT_THAT(text(), Not(HasSubstr("0.2,"))) << "it is stated already";
}

TEST_F(DoctorOfAnOldGateway, PrintsTheLineWhereItMayNotWrite) {
  fs::permissions(cli.dir.path(), fs::perms::owner_read | fs::perms::owner_exec);
  {
    const WithoutFileRights nobody;
    cli.run({"doctor", "--state", "travel_step_um=0.1"});
  }
  fs::permissions(cli.dir.path(), fs::perms::owner_all);
  EXPECT_EQ(text(), before_);
  EXPECT_THAT(cli.out.str(), HasSubstr("add to \"frame\" in "));
  EXPECT_THAT(cli.out.str(), HasSubstr(R"("travel_step_um": 0.1,)"));
}

}  // namespace
}  // namespace lcrig::cli
