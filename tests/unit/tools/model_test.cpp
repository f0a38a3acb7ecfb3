// SPDX-License-Identifier: Apache-2.0
// The five `model` commands: tables, JSON, and what they refuse before they start working.
#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "model/specimen_file.hpp"
#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class ModelCommands : public ::testing::Test {
 protected:
  json run_json(std::vector<std::string> args) {
    args.emplace_back("--json");
    EXPECT_EQ(cli.run(args), kOk) << cli.err.str();
    return json::parse(cli.out.str());
  }
  // The command must fail in this way, print no result and say why.
  void expect_refused(const std::vector<std::string>& args, int code, const std::string& why) {
    EXPECT_EQ(cli.run(args), code) << ::testing::PrintToString(args);
    EXPECT_EQ(cli.out.str(), "") << ::testing::PrintToString(args);
    EXPECT_THAT(cli.err.str(), HasSubstr(why)) << ::testing::PrintToString(args);
  }
  // A copy of paper-1 with one piece of text replaced.
  std::string variant(const std::string& from, const std::string& to) {
    std::string text(shipped_specimens().front().text);
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    const std::string path = cli.dir.file("variant.json");
    std::ofstream(path) << text.replace(at, from.size(), to);
    return path;
  }
  support::Cli cli;
};

TEST_F(ModelCommands, CurvePrintsATableAndItsJson) {
  ASSERT_EQ(cli.run({"model", "curve", "-s", "paper-1", "--pressure-kPa", "0:100:50"}), kOk)
      << cli.err.str();
  EXPECT_THAT(cli.out.str(),
              AllOf(HasSubstr("level hyperelastic"), HasSubstr("left out"), HasSubstr("viscosity"),
                    HasSubstr("capacitance_pF"), HasSubstr("3.6457044")));
  const auto curve =
      run_json({"model", "curve", "--specimen", "paper-1", "--pressure-kPa", "0:100:10"});
  EXPECT_EQ(curve["level"], "hyperelastic");
  EXPECT_EQ(curve["choice"]["left_out"].size(), 5U);
  EXPECT_LT(curve["error_estimate"].get<double>(), 1e-12);
  ASSERT_EQ(curve["points"].size(), 11U);
  EXPECT_EQ(curve["points"][10]["pressure_kPa"], 100.0);
  EXPECT_NEAR(curve["points"][10]["capacitance_pF"].get<double>() * 5, 20.855, 1e-3);
  EXPECT_GT(curve["points"][1]["delta_C_fF"], 0.0);
}

TEST_F(ModelCommands, CurveTakesLevelsAndTheirOptions) {
  const auto at = [&](const std::vector<std::string>& more) {
    std::vector<std::string> args{"model", "curve", "-s", "paper-1", "--pressure-kPa", "50"};
    args.insert(args.end(), more.begin(), more.end());
    return run_json(args)["points"][0]["delta_C_fF"].get<double>();
  };
  const double dead = at({"--level", "hyperelastic"});
  EXPECT_GT(at({"--level", "hyperelastic", "--pressure-kind", "true"}), 1.2 * dead);
  EXPECT_LT(at({"--level", "hyperelastic", "--lateral", "confined"}), 0.2 * dead);
  EXPECT_NEAR(at({"--level", "fem_finite"}), dead, 1e-6 * dead);
  EXPECT_NE(at({"--level", "hyperelastic", "--form", "B"}), dead);
  EXPECT_LT(at({"--level", "bonded", "--faces", "bonded_laminate"}), 0.1 * dead);
}

TEST_F(ModelCommands, CurveRefusesBadInputBeforeWorkStarts) {
  const auto curve = [](const std::vector<std::string>& more) {
    std::vector<std::string> args{"model", "curve", "-s", "paper-1"};
    args.insert(args.end(), more.begin(), more.end());
    return args;
  };
  expect_refused(curve({"--pressure-kPa", "0:1000000:1"}), kUsage, "at most 100000");
  expect_refused(curve({"--pressure-kPa", "nan"}), kUsage, "expected FROM:TO:STEP");
  expect_refused(curve({"--pressure-kPa=-5"}), kUsage, ">= 0");
  expect_refused(curve({"--tolerance", "nan"}), kUsage, "--tolerance");
  expect_refused(curve({"--tolerance=0"}), kUsage, "--tolerance must be positive");
  expect_refused(curve({"--level", "magic"}), kUsage, "--level");
  expect_refused(curve({"--form", "B"}), kUsage, "belong to a --level");
  expect_refused(curve({"--level", "fem_finite", "--form", "B"}), kFailed, "form A only");
  expect_refused(curve({"--level", "bonded"}), kFailed, "bonded_laminate");
  expect_refused(curve({"--level", "linear", "--pressure-kPa", "200"}), kFailed,
                 "not below Young's modulus");
  expect_refused({"model", "curve", "-s", "paper-9"}, kFailed, "paper-1");
}

TEST_F(ModelCommands, CurveRefusesBadSpecimens) {
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& why) {
    expect_refused({"model", "curve", "-s", variant(from, to)}, kFailed, why);
  };
  expect("\"thickness_um\": 25", "\"thickness_um\": -25", "thickness_um");
  expect("\"thickness_um\": 25", "\"thickness_um\": 0", "thickness_um");
  expect("\"thickness_um\": 25", "\"thickness_um\": NaN", "variant.json");
  expect("\"poisson_ratio\": 0.49", "\"poisson_ratio\": 0.51", "poisson_ratio");
  expect("\"material\": \"PDMS\"", "\"material\": \"PMDS\"", "unknown material");
  const std::string text(shipped_specimens().front().text);
  const auto open = text.find("\"layers\": [") + 11;
  expect(text.substr(open, text.find(']', open) - open), "", "layers");
}

// A bonded disc without a film on top, whose rim folds over at a moderate load.
constexpr const char* kSoftDisc = R"({ "format": "specimen/1", "name": "soft-disc",
  "disc_diameter_mm": 4.0, "faces": "bonded_base", "materials": { "PDMS": {
    "relative_permittivity": 2.75, "youngs_modulus_kPa": 125, "poisson_ratio": 0.49 } },
  "capacitors": [ { "layers": [ { "material": "PDMS", "thickness_um": 100 } ] } ] })";

TEST_F(ModelCommands, CurveSaysWhichErrorCanBeMetAndAtWhatCost) {
  const std::string disc = cli.dir.file("disc.json");
  std::ofstream(disc) << kSoftDisc;
  const std::vector<std::string> curve{"model",          "curve", "-s",          disc,
                                       "--pressure-kPa", "10",    "--tolerance", "1e-9"};
  const auto with_limit = [&](const std::string& seconds) {
    auto args = curve;
    args.insert(args.end(), {"--time-limit-s", seconds});
    return args;
  };
  EXPECT_EQ(cli.run(with_limit("1e-6")), kFailed);
  EXPECT_THAT(
      cli.err.str(),
      ContainsRegex("[0-9] can be met by fem_linear \\(mesh 0\\) in .* s; "
                    "fem_finite \\(mesh 1\\) would take about .* s more, over the limit of"));
  expect_refused(with_limit("0"), kUsage, "must be positive");
  expect_refused(with_limit("-1"), kUsage, "must be positive");
  expect_refused(with_limit("1e999"), kUsage, "expected a number");
  expect_refused(with_limit("nan"), kUsage, "--time-limit-s");
}

TEST_F(ModelCommands, CurveMarksWhatIsExtrapolated) {
  const std::string disc = cli.dir.file("disc.json");
  std::ofstream(disc) << kSoftDisc;
  const std::vector<std::string> curve{"model",          "curve",      "-s",     disc,
                                       "--level",        "fem_linear", "--mesh", "0",
                                       "--pressure-kPa", "10,110"};
  ASSERT_EQ(cli.run(curve), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("finite strain has no solution beyond"),
                                   ContainsRegex("\n +110 [^\n]*  extrapolated\n"),
                                   Not(ContainsRegex("\n +10 [^\n]*  extrapolated\n"))));
  const json j = run_json(curve);
  EXPECT_GT(j["lost_beyond_kPa"], 10.0);
  EXPECT_LT(j["lost_beyond_kPa"], 110.0);
  EXPECT_FALSE(j["points"][0].contains("extrapolated"));
  EXPECT_EQ(j["points"][1]["extrapolated"], true);
}

TEST_F(ModelCommands, CurveRefusesAModulusOfNoSolid) {
  for (const char* modulus : {"1e999", "1e-320", "1e300", "-1"}) {
    const std::string path = cli.dir.file("modulus.json");
    std::string text = kSoftDisc;
    std::ofstream(path) << text.replace(text.find("125"), 3, modulus);
    expect_refused({"model", "curve", "-s", path}, kFailed, "PDMS");
  }
}

// 1000 layers on the finest mesh are refused by counting, not by running out of memory.
TEST_F(ModelCommands, CurveRefusesAMeshLargerThanMemory) {
  const std::string text(shipped_specimens().front().text);
  const auto begin = text.find("{ \"layers\"");
  const auto end = text.find('}', text.rfind("\"thickness_um\"")) + 1;
  const auto close = text.find('}', end) + 1;
  const std::string one = text.substr(begin, close - begin);
  std::string many = one;
  for (int i = 1; i < 500; ++i) many += ", " + one;
  std::string soft = variant(one, many);
  expect_refused({"model", "curve", "-s", soft, "--faces", "bonded_base", "--level", "fem_finite",
                  "--mesh", "3", "--pressure-kPa", "1"},
                 kFailed, "coarser mesh");
}

TEST_F(ModelCommands, DesignPutsThinLayersAtTheFreeSide) {
  ASSERT_EQ(cli.run({"model", "design"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("searched all partitions"), HasSubstr("gain_%"),
                                   HasSubstr("thin layers at the top")));
  const auto design = run_json({"model", "design", "--capacitors", "3"});
  ASSERT_EQ(design["options"].size(), 4U);
  EXPECT_THAT(design["options"][0]["placement"], HasSubstr("at the top"));
  EXPECT_GT(design["options"][0]["gain_percent"], 50.0);
  EXPECT_EQ(design["options"][0]["thickness_um"].size(), 3U);
  EXPECT_GT(design["search_grid_um"], 0.0);
  for (const auto& option : design["options"]) EXPECT_TRUE(option.contains("gain_percent"));
  EXPECT_EQ(run_json({"model", "design", "--faces", "free"})["search_grid_um"], nullptr);
}

TEST_F(ModelCommands, DesignRefusesBadInput) {
  expect_refused({"model", "design", "--capacitors", "0"}, kUsage, "--capacitors");
  expect_refused({"model", "design", "--capacitors", "2.5"}, kUsage, "--capacitors");
  expect_refused({"model", "design", "--total-mm=-1"}, kFailed, "must be positive");
  expect_refused({"model", "design", "--least-mm", "0"}, kFailed, "must be positive");
  expect_refused({"model", "design", "--least-mm", "nan"}, kUsage, "--least-mm");
  expect_refused({"model", "design", "--capacitors", "11"}, kFailed, "do not fit");
  expect_refused({"model", "design", "--poisson-ratio", "0.51"}, kFailed, "Poisson");
  expect_refused({"model", "design", "--youngs-modulus-kPa", "0"}, kFailed, "Young");
}

TEST_F(ModelCommands, LadderPrintsATableAPictureAndItsJson) {
  const auto svg = cli.dir.file("ladder.svg");
  ASSERT_EQ(cli.run({"model", "ladder", "-s", "paper-1", "--svg", svg}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("seconds"), HasSubstr("reference")));
  std::ifstream file(svg);
  const std::string picture((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(picture, AllOf(HasSubstr("<svg"), HasSubstr("</svg>")));
  const auto ladder = run_json({"model", "ladder", "--specimen", "paper-1"});
  ASSERT_GE(ladder["rows"].size(), 8U);
  for (const auto& row : ladder["rows"]) {
    EXPECT_TRUE(row["level"].is_string());
    EXPECT_TRUE(row["setting"].is_string());
    EXPECT_GT(row["seconds"], 0.0);
    EXPECT_TRUE(row["relative_error"].is_number()) << row.dump();
  }
}

TEST_F(ModelCommands, LadderRefusesBadInput) {
  expect_refused({"model", "ladder", "-s", "paper-1", "--pressure-kPa", "x"}, kUsage,
                 "--pressure-kPa");
  expect_refused({"model", "ladder", "-s", "paper-1", "--pressure-kPa=-1"}, kFailed, ">= 0");
  expect_refused({"model", "ladder", "-s", "paper-1", "--svg", cli.dir.file("no/such/dir.svg")},
                 kFailed, "cannot write");
  expect_refused({"model", "ladder"}, kUsage, "--specimen");
}

TEST_F(ModelCommands, CompareListsThePaperAndItsErrors) {
  ASSERT_EQ(cli.run({"model", "compare"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("T1"), HasSubstr("T5"), HasSubstr("assumption"),
                                   HasSubstr("Errors and ambiguities")));
  const auto compare = run_json({"model", "compare"});
  EXPECT_EQ(compare["errata"].size(), 17U);
  for (const char* target : {"T1", "T2", "T3", "T4", "T5"}) {
    EXPECT_TRUE(std::any_of(compare["rows"].begin(), compare["rows"].end(), [&](const auto& row) {
      return row["target"] == target;
    })) << target;
  }
}

class ModelFit : public ModelCommands {
 protected:
  virtual std::string meter_text() const { return "\"frequency_Hz\": 1000,"; }
  virtual ParameterValues parameters() const { return {}; }
  void SetUp() override {
    cli.variables["LCRIG_DB"] = path;
    RehearseRequest request;
    request.protocol_name = "static-frame";
    auto text = read_text_file("protocols/library/static-frame.json");
    ASSERT_TRUE(text) << text.error().what;
    request.protocol_text = *text;
    const std::string meter = "\"frequency_Hz\": 1000,";
    request.protocol_text.replace(text->find(meter), meter.size(), meter_text());
    request.parameters = parameters();
    request.specimen_name = "paper-3";
    request.specimen_text = specimen_text();
    request.db_path = path;
    const auto result = rehearse(request);
    ASSERT_TRUE(result) << result.error().what;
    ASSERT_EQ(result->exit_status, ExitStatus::success) << result->reason;
  }
  virtual std::string specimen_text() const {
    for (const auto& s : shipped_specimens()) {
      if (s.name == "paper-3") return std::string(s.text);
    }
    return {};
  }
  std::string path = cli.dir.file("runs.db");
};

TEST_F(ModelFit, FindsTheModulusOfARecordedRun) {
  ASSERT_EQ(cli.run({"model", "fit", "last"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(),
              AllOf(HasSubstr("simulated run 1: "), HasSubstr("shear modulus"), HasSubstr("95 %"),
                    HasSubstr("not in these intervals: force (limits of 1 %)")));
  EXPECT_EQ(cli.err.str(), "");
  const auto fit = run_json({"model", "fit", "1"});
  EXPECT_EQ(fit["run"], 1);
  EXPECT_EQ(fit["level"], "hyperelastic");
  const auto& mu = fit["shear_modulus_kPa"];
  EXPECT_NEAR(mu["value"].get<double>(), 42, 4 * mu["standard_error"].get<double>());
  EXPECT_LT(mu["ci95"][0], mu["value"]);
  EXPECT_GT(mu["ci95"][1], mu["value"]);
  EXPECT_GT(mu["rig_uncertainty"], 0.0057 * mu["value"].get<double>());  // from the force alone
  EXPECT_GE(fit["points"], 4);
  EXPECT_EQ(fit["verdict"], "fits") << fit["misfit"].dump();
  EXPECT_GT(fit["misfit"]["p"], 0.01);
  EXPECT_LT(std::abs(fit["misfit"]["c0_pull"].get<double>()), 4);
  EXPECT_GE(fit["misfit"]["pulls"].size(), 14U);  // of each level
  EXPECT_GT(fit["parts_percent"]["repeats"], 0);
  EXPECT_TRUE(fit["contact_offset_kPa"]["ci95"].is_array());
  expect_refused({"model", "fit", "7"}, kFailed, "lcrig runs");
}

TEST_F(ModelFit, SaysOfARunThatWasChangedThatItWas) {
  {
    auto db = Database::open(path, Database::Mode::read_write_create);
    ASSERT_TRUE(db);
    ASSERT_TRUE(
        db->execute("DROP TRIGGER frame_sample_no_update; UPDATE frame_sample SET force_N = "
                    "force_N + 0.001 WHERE seq = 20"));
  }
  ASSERT_EQ(cli.run({"model", "fit", "1", "--json"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.err.str(), HasSubstr("run 1 is not as it was recorded: "));
  const auto fit = json::parse(cli.out.str());
  EXPECT_EQ(fit["intact"], false);
  EXPECT_EQ(fit["simulated"], true);
}

// At 100 kHz, where noise does not hide the creep of 5 %.
class ModelFitOfCreep : public ModelFit {
  std::string meter_text() const override { return "\"frequency_Hz\": 100000,"; }
  std::string specimen_text() const override {
    std::string text = ModelFit::specimen_text();
    const std::string faces = "\"faces\"";
    return text.replace(text.find(faces), faces.size(),
                        "\"creep\": { \"fraction\": 0.05, \"time_s\": 10 },\n  \"faces\"");
  }
};

TEST_F(ModelFitOfCreep, IsNamedAndTheIntervalHolds) {
  const auto fit = run_json({"model", "fit", "1"});
  const auto& mu = fit["shear_modulus_kPa"];
  EXPECT_LT(mu["ci95"][0], 42);
  EXPECT_GT(mu["ci95"][1], 42);
  const auto& c0 = fit["c0_shift_fF"];
  EXPECT_LT(std::abs(c0["value"].get<double>()), 4 * c0["standard_error"].get<double>());
  EXPECT_EQ(fit["verdict"], "misfit");
  ASSERT_FALSE(fit["misfit"]["patterns"].empty());
  EXPECT_EQ(fit["misfit"]["patterns"][0]["kind"], "creep");
  ASSERT_EQ(cli.run({"model", "fit", "1"}), kOk) << cli.err.str();
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr("verdict         misfit; the intervals include it"),
                                   HasSubstr("creep: the specimen yields by")));
}

class ModelFitOfTwoLevels : public ModelFit {
  ParameterValues parameters() const override { return {{"levels", "2"}, {"repeats", "2"}}; }
};

TEST_F(ModelFitOfTwoLevels, IsRefusedInWords) {
  expect_refused({"model", "fit", "1"}, kFailed, "2 different pressures");
}

// The bench accepts bonded specimens as it is shipped: `auto` finds a level within its tolerance.
class ModelFitBonded : public ModelFit {
  std::string specimen_text() const override {
    std::string text = ModelFit::specimen_text();
    const std::string free = "\"free\"";
    return text.replace(text.find(free), free.size(), "\"bonded_laminate\"");
  }
};

TEST_F(ModelFitBonded, ABondedSpecimenCanBeRehearsed) {
  ASSERT_EQ(cli.run({"runs", "show", "last", "--json"}), kOk) << cli.err.str();
  EXPECT_EQ(json::parse(cli.out.str())["model_level"], "fem_finite");
}

}  // namespace
}  // namespace lcrig::cli
