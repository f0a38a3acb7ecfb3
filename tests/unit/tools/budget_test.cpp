// SPDX-License-Identifier: Apache-2.0
// `lcrig budget`: from a protocol to predicted errors.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/cli_fixture.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/xml.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class BudgetCommand : public testing::Test {
 protected:
  void SetUp() override {
    cli.bench_rig = &bench_rig;
    for (const char* name : {"static-frame", "dynamic-cycles", "follow"}) {
      const std::string path = std::string("protocols/library/") + name + ".json";
      std::ifstream file(path);
      std::stringstream text;
      text << file.rdbuf();
      cli.add_data(std::string("protocols/") + name + ".json", text.str());
      if (name != std::string_view("static-frame")) continue;
      // A protocol that reads the meter during the measure steps only.
      std::string restless = text.str();
      restless.insert(restless.find(R"("trigger": "bus")"), R"("continuous": false, )");
      cli.add_data("protocols/restless.json", restless);
      std::string changed = text.str();
      changed.insert(changed.find(R"({ "id": "zero")"),
                     R"({ "id": "tune", "do": "set_lcr", "frequency_Hz": 2000 }, )");
      cli.add_data("protocols/two-settings.json", changed);
    }
  }
  json budget(std::vector<std::string> args) {
    args.insert(args.begin(), {"--json", "budget"});
    args.insert(args.end(), {"--specimen", "paper-1"});
    EXPECT_EQ(cli.run(args), 0) << cli.err.str();
    return json::parse(cli.out.str(), nullptr, false);
  }
  support::Cli cli;
};

const json& row(const json& budget, const char* aperture, double frequency_Hz = 1000) {
  for (const json& r : budget["rows"]) {
    if (r["aperture"] == aperture && r["frequency_Hz"] == frequency_Hz) return r;
  }
  throw std::runtime_error("no such row");
}

TEST_F(BudgetCommand, ErrorFollowsTheNoiseOfTheAperture) {
  const json out = budget({"static-frame"});
  ASSERT_EQ(out["rows"].size(), 3U);
  const double fast = row(out, "fast")["results"][0]["standard_error"];
  const double medium = row(out, "medium")["results"][0]["standard_error"];
  EXPECT_NEAR(fast / medium, 60.0 / 44, 1e-3);  // the bench's noise; readings are the same
  EXPECT_EQ(row(out, "medium")["readings"], 1680);
}

TEST_F(BudgetCommand, SlopeOfTheShippedStaticTestByHand) {
  const json out = budget({"static-frame"});
  // 35 to 100 kPa: ten of fourteen levels from 10 to 100, 90/13 kPa apart; 30 readings, 4 repeats.
  const double step = 90.0 / 13;
  double sxx = 0;
  for (int i = 0; i < 10; ++i) sxx += std::pow((i - 4.5) * step, 2);
  const double expected = 44 / std::sqrt(30 * 4 * sxx);
  const json& result = row(out, "medium")["results"][1];
  EXPECT_EQ(result["quantity"], "sensitivity 35-100 kPa");
  double variance = 0;
  for (const json& part : result["parts"]) {
    if (!part["included"]) continue;
    const double size = part["standard_uncertainty"];
    if (part["kind"] == "A") variance += size * size;
    if (part["part"] == "scatter of the readings") {
      EXPECT_NEAR(size, expected, 1e-3 * expected);
    }
    if (part["part"] == "drift of C0") {
      EXPECT_NEAR(size / expected, 0.18, 0.03);
    }
  }
  EXPECT_NEAR(result["standard_error"], std::sqrt(variance), 1e-9);
}

TEST_F(BudgetCommand, AConversionThatDoesNotFitGetsItsTime) {
  const json out = budget({"static-frame"});
  const json& slow = row(out, "slow");  // 30 readings of 380 ms do not fit into 10 s
  EXPECT_TRUE(slow["possible"].get<bool>());
  EXPECT_THAT(slow["note"].get<std::string>(), HasSubstr("within_s=11.7"));
  EXPECT_GT(slow["duration_s"], row(out, "medium")["duration_s"]);
}

TEST_F(BudgetCommand, TargetIsMetByTheCheapestSetting) {
  const json out = budget({"static-frame", "--frequency-Hz", "1000,100000", "--target", "1%"});
  ASSERT_EQ(out["rows"].size(), 6U);
  ASSERT_FALSE(out["cheapest"].is_null());
  EXPECT_EQ(out["cheapest"]["frequency_Hz"], 100000);
  EXPECT_LE(out["cheapest"]["worst_percent"], 1);
  for (const json& r : out["rows"]) {
    if (r["to_target"].is_null()) continue;
    EXPECT_LE(r["to_target"]["worst_percent"], 1);
    EXPECT_GE(r["to_target"]["duration_s"], out["cheapest"]["duration_s"]);
  }
}

// Nothing tells the dynamic range of one slow conversion in each loading: the target is unmet.
TEST_F(BudgetCommand, AResultThatNothingPredictsIsUnmet) {
  const json out = budget({"dynamic-cycles", "--frequency-Hz", "100000", "--target", "1000%"});
  const json& slow = row(out, "slow", 100000);
  ASSERT_FALSE(slow["not_predicted"].empty());
  EXPECT_LE(slow["worst_half_width_percent"], 1000) << "what is predicted would do";
  EXPECT_TRUE(slow["to_target"].is_null());
  ASSERT_FALSE(out["cheapest"].is_null());
  EXPECT_NE(out["cheapest"]["aperture"], "slow");
  ASSERT_EQ(cli.run({"budget", "dynamic-cycles", "--specimen", "paper-1", "--frequency-Hz",
                     "100000", "--target", "1000%"}),
            0)
      << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("cannot be told: nothing predicts " +
                                       slow["not_predicted"][0].get<std::string>()));
}

// The target applies to the interval that `analyze` will print. The table shows it beside the
// standard error.
TEST_F(BudgetCommand, TableShowsTheIntervalThatTheTargetIsOn) {
  const json out = budget({"static-frame"});
  const json& slope = row(out, "medium")["results"][1];
  const double half_width = slope["half_width_percent"], error = slope["relative_percent"];
  EXPECT_GT(half_width, 2.5 * error) << "four repeats: Student's t is 3.18";
  ASSERT_EQ(cli.run({"budget", "static-frame", "--specimen", "paper-1"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("std error  interval"),
                                   HasSubstr(fmt::format("+-{:>6.3g}%", half_width))));
}

TEST_F(BudgetCommand, ProposalIsACommandThatPlansExactlyThat) {
  const json out = budget({"static-frame", "--frequency-Hz", "1000,100000", "--target", "3%", "-p",
                           "force_limit_N=1.5"});
  ASSERT_FALSE(out["cheapest"].is_null());
  std::istringstream words(out["command"].get<std::string>());
  std::vector<std::string> args{"--json", "protocol", "plan"};
  std::string word;
  words >> word >> word;  // lcrig run
  while (words >> word) args.push_back(word);
  ASSERT_EQ(cli.run(args), 0) << cli.err.str();
  const json plan = json::parse(cli.out.str());
  EXPECT_EQ(plan["duration_s"], out["cheapest"]["duration_s"]);
  EXPECT_EQ(plan["measure_readings"], out["cheapest"]["readings"]);
}

TEST_F(BudgetCommand, NoiseComesFromARecordedRun) {
  SyntheticRun recorded;
  recorded.begin();
  SyntheticRun::Static quiet;
  quiet.noise_F = 4.4e-15;  // a tenth of the bench's, medium at 1 kHz
  quiet.baseline = 2000;
  recorded.play(quiet);
  recorded.end();
  const json out = budget({"static-frame", "--noise-from", "last", "--db", recorded.db().path()});
  const auto scatter = [&out](const char* aperture) {
    return row(out, aperture)["results"][1]["parts"][0];
  };
  const double step = 90.0 / 13;
  double sxx = 0;
  for (int i = 0; i < 10; ++i) sxx += std::pow((i - 4.5) * step, 2);
  const double expected = 4.4 / std::sqrt(30 * 4 * sxx);
  EXPECT_NEAR(scatter("medium")["standard_uncertainty"], expected, 0.05 * expected);
  EXPECT_THAT(scatter("medium")["basis"], HasSubstr("run 1"));
  EXPECT_FALSE(row(out, "medium")["noise_guessed"].get<bool>());
  EXPECT_THAT(scatter("slow")["basis"], HasSubstr("a guess"));
  EXPECT_NEAR(scatter("fast")["standard_uncertainty"], expected * 60 / 44, 0.05 * expected);
  // The rows that this test made are in no link of the chain.
  EXPECT_THAT(cli.err.str(), HasSubstr("run 1 is not as it was recorded: level 1 is in no link"));
  EXPECT_EQ(cli.run({"budget", "static-frame", "--specimen", "paper-1", "--noise-from", "77",
                     "--db", recorded.db().path()}),
            1);
}

TEST_F(BudgetCommand, NoiseThatNobodyMeasuredIsMarked) {
  const json out = budget({"static-frame"});
  EXPECT_FALSE(row(out, "fast")["noise_guessed"].get<bool>());
  EXPECT_TRUE(row(out, "medium")["noise_guessed"].get<bool>());
  EXPECT_TRUE(row(out, "slow")["noise_guessed"].get<bool>());
}

TEST_F(BudgetCommand, DynamicCyclesPredictTheRange) {
  const json out = budget({"dynamic-cycles"});
  const json& results = row(out, "fast")["results"];
  EXPECT_EQ(results.back()["quantity"], "dynamic range");
  EXPECT_GT(results.back()["standard_error"], 0);
  const json more = budget({"dynamic-cycles", "-p", "cycles=20"});
  const double four_times = row(more, "fast")["results"].back()["standard_error"];
  EXPECT_NEAR(results.back()["standard_error"].get<double>() / four_times, 2, 0.05);
}

TEST_F(BudgetCommand, PictureIsWellFormedAndMarksTheFront) {
  const std::string svg = cli.dir.file("budget.svg");
  ASSERT_EQ(cli.run({"budget", "static-frame", "--specimen", "paper-1", "--svg", svg}), 0)
      << cli.err.str();
  std::ifstream file(svg);
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(XmlCheck::fault(text.str()), "");
  EXPECT_THAT(text.str(), AllOf(HasSubstr("Pareto front"), HasSubstr("run time, s")));
  EXPECT_THAT(cli.out.str(), HasSubstr("sensitivity 0-30 kPa"));
}

// The analysis would note that it cannot tell a drift: the plan says so before the run.
TEST_F(BudgetCommand, PictureReplacesNothingButAnEarlierOne) {
  const std::string file = cli.dir.file("mine.svg");
  std::ofstream(file) << "<svg xmlns='x'>mine</svg>";
  EXPECT_EQ(cli.run({"budget", "static-frame", "--specimen", "paper-1", "--svg", file}),
            cli::kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("mine.svg: holds something else, which would be lost"));
  EXPECT_EQ(std::filesystem::file_size(file), 25U);
}

TEST_F(BudgetCommand, PlanSaysWhenNoRestsTellADrift) {
  const auto assumed = [this](const char* protocol) {
    EXPECT_EQ(cli.run({"protocol", "plan", protocol, "--specimen", "paper-1"}), 0) << cli.err.str();
    return cli.out.str();
  };
  EXPECT_THAT(assumed("restless"), HasSubstr("capacitance does not drift"));
  for (const char* shipped : {"static-frame", "dynamic-cycles", "follow"}) {
    EXPECT_THAT(assumed(shipped), testing::Not(HasSubstr("capacitance does not drift"))) << shipped;
  }
}

TEST_F(BudgetCommand, WhatCannotBePredictedIsRefused) {
  EXPECT_EQ(cli.run({"budget", "follow", "--specimen", "paper-1"}), 6);
  EXPECT_THAT(cli.err.str(), HasSubstr("never loads"));
  EXPECT_EQ(cli.run({"budget", "two-settings", "--specimen", "paper-1"}), 6);
  EXPECT_THAT(cli.err.str(), HasSubstr("changes the meter's settings"));
  EXPECT_EQ(cli.run({"budget", "static-frame", "--specimen", "paper-1", "--target", "fine"}), 2);
  EXPECT_EQ(cli.run({"budget", "static-frame", "--specimen", "paper-1", "--frequency-Hz", "1,,2"}),
            2);
  EXPECT_EQ(cli.run({"budget", "static-frame", "--specimen", "nothing"}), 1);
}

}  // namespace
}  // namespace lcrig::cli
