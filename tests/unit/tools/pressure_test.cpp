// SPDX-License-Identifier: Apache-2.0
// Specimens and probes drawn at random. The sensitivities of `model curve`, `budget` and of
// `analyze` after a `rehearse` must be one number once they are expressed on the same area, and
// each command must say in its first line which pressure it means where the areas differ. The truth
// is a plate capacitor on a linear spring, written down here; nothing of the product converts it.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "tests/support/cli_fixture.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kTop_kPa = 30, kPermittivity = 2.75, kThickness_um = 30;

struct Drawn {
  double probe_mm = 4, disc_mm = 4;
  bool plate = false, on_disc = false;

  double ratio() const { return probe_mm * probe_mm / (disc_mm * disc_mm); }
  // Limits of a turned tip, and of a cut disc: ISO 2768-1, class f.
  bool differs() const { return std::abs(probe_mm - disc_mm) > 0.02 + (disc_mm <= 6 ? 0.05 : 0.1); }
  bool is_part() const { return differs() && probe_mm < disc_mm && !plate; }
  // So that the largest strain is 0.4 %, and the curve straight.
  double youngs_kPa() const { return kTop_kPa * std::max(1.0, on_disc ? 1 : ratio()) / 0.004; }
  // C0/E of plates on a spring: C0 = eps0 eps A/t, dC/C0 = P/E.
  double slope_on_disc_fF_kPa() const {
    const double area_m2 = std::numbers::pi / 4 * disc_mm * disc_mm * 1e-6;
    const double c0_fF = 8.8541878128e-12 * kPermittivity * area_m2 / (kThickness_um * 1e-6) * 1e15;
    return c0_fF / youngs_kPa();
  }
  double slope_over_probe_fF_kPa() const { return slope_on_disc_fF_kPa() * ratio(); }
  double stated_fF_kPa() const {
    return on_disc ? slope_on_disc_fF_kPa() : slope_over_probe_fF_kPa();
  }
};

std::ostream& operator<<(std::ostream& out, const Drawn& d) {
  return out << "probe " << d.probe_mm << " mm, disc " << d.disc_mm << " mm"
             << (d.plate ? ", plate" : "") << (d.on_disc ? ", pressures on the disc" : "");
}

Drawn drawn(unsigned seed) {
  std::mt19937 random(seed);
  const auto tenths = [&random](int from, int to) {
    return std::uniform_int_distribution<int>(from, to)(random) / 10.0;
  };
  Drawn d;
  d.disc_mm = tenths(30, 80);
  d.probe_mm = random() % 4 == 0 ? d.disc_mm : tenths(30, 80);
  d.plate = random() % 2 == 0;
  d.on_disc = random() % 3 == 0;
  return d;
}

class Pressures : public ::testing::Test {
 protected:
  void SetUp() override {
    cli.bench_rig = &bench_rig;
    cli.rehearsal = &rehearse;
    cli.day = &rehearse_batch;
  }
  std::string write(const char* name, const std::string& text) {
    const auto path = cli.dir.file(name);
    std::ofstream(path) << text;
    return path;
  }
  void bring(const Drawn& d) {
    specimen_ = write(
        "specimen.json",
        json{{"format", "specimen/1"},
             {"name", "drawn"},
             {"disc_diameter_mm", d.disc_mm},
             {"faces", "free"},
             {"top", d.plate ? "plate" : "pressure"},
             {"materials",
              {{"m",
                {{"relative_permittivity", kPermittivity},
                 {"youngs_modulus_kPa", d.youngs_kPa()},
                 {"poisson_ratio", 0.3}}}}},
             {"capacitors", {{{"layers", {{{"material", "m"}, {"thickness_um", kThickness_um}}}}}}}}
            .dump());
    bench_ = write(
        "bench.json",
        json{{"format", "bench/1"},
             {"name", "drawn"},
             {"error_tolerance", 1e-3},
             {"fixture", {{"probe_diameter_mm", d.probe_mm}}},
             {"frame", {{"contact_travel_mm", 3.2}, {"force_noise_mN", 0.1}}},
             {"meter", {{"noise_fast_fF", 0.1}, {"noise_medium_fF", 0.1}, {"noise_slow_fF", 0.1}}}}
            .dump());
    std::ifstream file("protocols/library/static-frame.json");
    std::stringstream text;
    text << file.rdbuf();
    std::string protocol = text.str();
    if (d.on_disc) protocol.insert(protocol.find(R"("limits")"), R"("pressure_on": "disc", )");
    protocol_ = write("protocol.json", protocol);
  }
  std::vector<std::string> of_run(const char* verb) const {
    std::vector<std::string> out{verb};
    if (verb == std::string("plan")) out = {"protocol", "plan"};
    out.push_back(protocol_);  // before -p, which takes words as long as there are any
    for (const char* word : {"levels=4", "from_kPa=7.5", "to_kPa=30", "readings=4", "within_s=1",
                             "settle_s=0", "repeats=2", "rate_N_s=1", "force_limit_N=6"}) {
      out.insert(out.end(), {"-p", word});
    }
    out.insert(out.end(), {"--specimen", specimen_, "--bench", bench_});
    return out;
  }
  std::vector<std::string> curve(std::optional<double> probe_mm) const {
    std::vector<std::string> out{"model",   "curve",          "--specimen",
                                 specimen_, "--pressure-kPa", "0,1"};
    if (probe_mm) out.insert(out.end(), {"--probe-diameter-mm", std::to_string(*probe_mm)});
    return out;
  }
  json answer(std::vector<std::string> args) {
    args.emplace_back("--json");
    EXPECT_EQ(cli.run(args), kOk) << ::testing::PrintToString(args) << cli.err.str();
    return json::parse(cli.out.str(), nullptr, false);
  }
  std::string first_line(const std::vector<std::string>& args) {
    EXPECT_EQ(cli.run(args), kOk) << ::testing::PrintToString(args) << cli.err.str();
    const auto said = cli.out.str();
    return said.substr(0, said.find('\n'));
  }
  void expect_near(double value, double truth, const char* what) {
    EXPECT_NEAR(value / truth, 1, 0.02) << what;
  }
  // The words that a first line must have where the areas differ.
  void expect_said(const Drawn& d, const std::string& line) {
    if (!d.differs()) {
      EXPECT_THAT(line, Not(HasSubstr("pressure is force"))) << line;
      return;
    }
    EXPECT_THAT(line, StartsWith("pressure is force over the "));
    EXPECT_THAT(line, AllOf(HasSubstr("probe of"), HasSubstr("disc of"), HasSubstr("kPa")));
  }
  // `rehearse --batch` and `compare`, of the same specimen.
  void expect_batch_and_comparison_said(const Drawn& d, const std::string& db) {
    const auto table = write("batch.csv",
                             "specimen,protocol,levels,from_kPa,to_kPa,readings,"
                             "within_s,settle_s,repeats,rate_N_s,force_limit_N\n" +
                                 specimen_ + "," + protocol_ + ",4,7.5,30,4,1,0,2,1,6\n");
    expect_said(d, first_line({"rehearse", "--batch", table, "--bench", bench_, "--db",
                               cli.dir.file("day.db")}));
    cli.run({"compare", "1", "last", "--db", db, "--range", "0:31"});
    const auto said = cli.out.str();
    EXPECT_EQ(said.starts_with("run 1: pressure is force over the "), d.differs()) << said;
  }
  support::Cli cli;
  std::string specimen_, bench_, protocol_;
};

class DrawnPressures : public Pressures, public ::testing::WithParamInterface<unsigned> {};

TEST_P(DrawnPressures, AreOneNumberOnOneAreaAndSayWhichTheyMean) {
  const Drawn d = drawn(GetParam());
  SCOPED_TRACE(::testing::PrintToString(d));
  bring(d);
  EXPECT_THAT(first_line(curve({})), HasSubstr("force over the disc"));
  expect_near(answer(curve({}))["points"][1]["delta_C_fF"], d.slope_on_disc_fF_kPa(), "disc");
  if (d.is_part()) {
    for (const char* verb : {"rehearse", "budget", "plan"}) {
      EXPECT_NE(cli.run(of_run(verb)), kOk) << verb;
      EXPECT_THAT(cli.err.str(), HasSubstr("presses only a part of the disc")) << verb;
      EXPECT_THAT(cli.err.str(), HasSubstr("next: change one of the two: ")) << verb;
    }
    EXPECT_NE(cli.run(curve(d.probe_mm)), kOk);
    EXPECT_THAT(cli.err.str(), HasSubstr("presses only a part of the disc"));
    return;
  }
  EXPECT_THAT(first_line(curve(d.probe_mm)), HasSubstr("force over the probe"));
  expect_near(answer(curve(d.probe_mm))["points"][1]["delta_C_fF"], d.slope_over_probe_fF_kPa(),
              "probe");
  expect_said(d, first_line(of_run("plan")));
  const json plan = answer(of_run("plan"))["pressure"];
  EXPECT_NEAR(plan["peak_kPa"].get<double>(), kTop_kPa, 1e-6);
  EXPECT_NEAR(plan["peak_on_disc_kPa"].get<double>(), kTop_kPa * (d.on_disc ? 1 : d.ratio()), 1e-6);
  expect_said(d, first_line(of_run("budget")));
  const json budget = answer(of_run("budget"))["rows"][0]["results"][0];
  expect_near(budget["value"], d.stated_fF_kPa(), "budget");
  expect_near(budget["value_on_disc"], d.slope_on_disc_fF_kPa(), "budget, on the disc");
  auto rehearsal = of_run("rehearse");
  const auto db = cli.dir.file("runs.db");
  rehearsal.insert(rehearsal.end(), {"--db", db});
  expect_said(d, first_line(rehearsal));
  expect_said(d, first_line({"analyze", "last", "--db", db, "--range", "0:31"}));
  expect_batch_and_comparison_said(d, db);
  const json run = answer({"analyze", "last", "--db", db, "--range", "0:31"});
  expect_near(run["ranges"][0]["sensitivity_fF_per_kPa"], d.stated_fF_kPa(), "analyze");
  expect_near(run["ranges"][0]["on_disc"]["sensitivity_fF_per_kPa"], d.slope_on_disc_fF_kPa(),
              "analyze, on the disc");
  EXPECT_EQ(run["pressure"]["on"], d.on_disc ? "disc" : "probe");
  // The largest force, by the area that the protocol states.
  const double over_mm = d.on_disc ? d.disc_mm : d.probe_mm;
  const double top_N = kTop_kPa * 1e3 * std::numbers::pi / 4 * over_mm * over_mm * 1e-6;
  EXPECT_NEAR(run["levels"].back()["pressure_kPa"].get<double>(), kTop_kPa, 0.5);
  EXPECT_NEAR(answer(of_run("plan"))["peak_force_N"].get<double>(), top_N, 1e-6 * top_N);
}
INSTANTIATE_TEST_SUITE_P(Seeds, DrawnPressures, ::testing::Range(1U, 13U));

TEST_F(Pressures, OfTheOtherModelCommandsSayWhatTheyAreOver) {
  EXPECT_THAT(first_line({"model", "ladder", "--specimen", "paper-1", "--pressure-kPa", "10"}),
              HasSubstr("pressure is force over the disc of 4 mm"));
  EXPECT_THAT(first_line({"model", "design", "--capacitors", "2"}),
              HasSubstr("pressure is force over the disc of 4 mm"));
  EXPECT_THAT(first_line({"model", "compare"}), HasSubstr("pressure is force over"));
  const auto slope = [&](const std::vector<std::string>& more) {
    std::vector<std::string> args{"model", "design", "--capacitors", "2", "--faces", "free"};
    args.insert(args.end(), more.begin(), more.end());
    return answer(args)["pressure"]["on_disc_per_kPa"].get<double>();
  };
  EXPECT_NEAR(slope({}), 1, 1e-12);
  EXPECT_NEAR(slope({"--probe-diameter-mm", "8"}), 4, 1e-12);
}

TEST_F(Pressures, OnTheDiscNeedASpecimen) {
  Drawn d;
  d.on_disc = true;
  bring(d);
  EXPECT_EQ(cli.run({"protocol", "plan", protocol_, "--bench", bench_}), kProtocol);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("pressure_on"), HasSubstr("--specimen")));
}

}  // namespace
}  // namespace lcrig::cli
