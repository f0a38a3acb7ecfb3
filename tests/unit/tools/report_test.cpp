// SPDX-License-Identifier: Apache-2.0
// `lcrig report` on rehearsed runs. A page must have every section and the numbers of the analysis.
// It must have nothing from outside, and nothing that a text in the database could smuggle in.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/report/report.hpp"
#include "storage/corrections.hpp"
#include "storage/database.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/xml.hpp"

namespace lcrig::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kHostile = "<script>alert(\"x\")</script>'&\x1b[31m\nDROP";

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream out;
  out << file.rdbuf();
  return out.str();
}

std::string shipped(const std::string& path) {
  return read(path);  // tests run in the source tree
}

std::string specimen_text(const std::string& name) {
  auto specimen = nlohmann::json::parse(shipped("model/library/paper-1.json"), nullptr, true, true);
  specimen["name"] = name;
  return specimen.dump();
}

RehearseRequest request(const std::string& db, const std::string& protocol) {
  RehearseRequest r;
  r.protocol_name = protocol;
  r.protocol_text = shipped("protocols/library/" + protocol + ".json");
  r.specimen_name = "paper-1";
  r.specimen_text = specimen_text("paper-1");
  r.db_path = db;
  r.seed = 7;
  return r;
}

RehearseRequest short_static(const std::string& db) {
  auto r = request(db, "static-frame");
  r.parameters = {{"levels", "8"}, {"repeats", "2"}, {"readings", "10"}, {"within_s", "1.5"}};
  return r;
}

// Run 1: static. Run 2: dynamic. Run 3: static, with texts that cannot be trusted.
class Report : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new TempDir();
    db = folder->file("runs.db");
    must(short_static(db));
    auto dynamic = request(db, "dynamic-cycles");
    dynamic.parameters = {{"cycles", "3"}, {"gap_mm", "0.1"}};
    must(dynamic);
    auto hostile = short_static(db);
    hostile.operator_name = hostile.note = kHostile;
    hostile.specimen_name = kHostile;
    hostile.specimen_text = specimen_text(kHostile);
    hostile.seed = 8;
    must(hostile);
  }
  static void TearDownTestSuite() { delete folder; }
  static void must(const RehearseRequest& r) {
    const auto result = rehearse(r);
    ASSERT_TRUE(result) << result.error().what;
    ASSERT_EQ(result->exit_status, ExitStatus::success) << result->reason;
  }
  std::string page(const std::vector<std::string>& runs) {
    std::vector<std::string> args{"--db", db, "report"};
    args.insert(args.end(), runs.begin(), runs.end());
    args.insert(args.end(), {"-o", file});
    EXPECT_EQ(cli.run(args), 0) << cli.err.str();
    return read(file);
  }
  static RunAnalysis analysis(std::int64_t run) {
    auto opened = open_read_only(db);
    EXPECT_TRUE(opened);
    auto out = analyse(*opened, run);
    EXPECT_TRUE(out) << out.error().what;
    return *out;
  }
  static inline TempDir* folder = nullptr;
  static inline std::string db;
  support::Cli cli;
  std::string file = cli.dir.file("report.html");
};

void expect_harmless(const std::string& html) {
  EXPECT_EQ(XmlCheck::fault(html, {"meta"}), "");
  for (const char* outside : {"http:", "https:", "//www", "src=", "@import", "url(", "<script",
                              "<link", "<iframe", "onload", "\x1b"}) {
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  }
}

TEST_F(Report, OfAStaticRunHasEverySection) {
  const std::string html = page({"1"});
  for (const char* id : {"results", "pressure", "time", "cycles", "loops", "model", "uncertainty",
                         "metrics", "events", "provenance"}) {
    EXPECT_THAT(html, HasSubstr("<section id='" + std::string(id) + "'>"));
  }
  EXPECT_THAT(html, AllOf(HasSubstr("SIMULATED"), HasSubstr("verified:"), HasSubstr("paper-1"),
                          HasSubstr("Residuals of the fits"), HasSubstr("seed 7")));
  expect_harmless(html);
}

TEST_F(Report, TellsTheMetersCorrectionsInOneLine) {
  EXPECT_THAT(page({"1"}), HasSubstr("open: on, not made through lcrig; short: on, not made"));
  const std::string copy = cli.dir.file("copy.db");
  std::filesystem::copy_file(db, copy);
  StoredCorrection made;
  made.meter = "LCR-6100 SIM000001";
  made.operator_name = kHostile;
  made.made_unix_ns = 1'000'000'000;
  ASSERT_TRUE(add_correction(open_read_write(copy).value(), made));
  must(short_static(copy));
  ASSERT_EQ(cli.run({"--db", copy, "report", "last", "-o", file}), 0) << cli.err.str();
  const std::string html = read(file);
  EXPECT_THAT(html, HasSubstr("open: on, made 1970-01-01 00:00 UTC by &lt;script&gt;"));
  expect_harmless(html);
  ASSERT_EQ(cli.run({"--db", copy, "runs", "show", "last", "--json"}), 0) << cli.err.str();
  const auto shown = nlohmann::json::parse(cli.out.str());
  EXPECT_EQ(shown["correction"]["open"]["made_unix_ns"], 1'000'000'000);
  ASSERT_EQ(cli.run({"--db", copy, "export", "last", "-o", cli.dir.file("csv")}), 0);
  const auto package = nlohmann::json::parse(read(cli.dir.file("csv/datapackage.json")));
  EXPECT_EQ(package["lcrig"]["correction"], shown["correction"]);
}

TEST_F(Report, ItsNumbersAreThoseOfTheAnalysis) {
  for (const std::int64_t run : {1, 2}) {
    const std::string html = page({std::to_string(run)});
    const RunAnalysis a = analysis(run);
    int compared = 0;
    for (const Metric* m : a.metrics()) {
      if (!*m) continue;
      EXPECT_THAT(html, HasSubstr(fmt::format("<data value='{}'>", m->value()))) << m->name;
      ++compared;
    }
    EXPECT_GE(compared, 8);
    for (const auto& b : a.uncertainties) {
      EXPECT_THAT(html, HasSubstr(fmt::format("<data value='{}'>", b.expanded))) << b.quantity;
    }
  }
}

std::string results_of(const std::string& html) {
  const auto from = html.find("<section id='results'>");
  return html.substr(from, html.find("</section>", from) - from);
}

// A reader quotes the first number of a page. Its +- is the expanded uncertainty, never the scatter
// alone without a word.
TEST_F(Report, HeadsThePageWithWhatMayBeQuoted) {
  for (const std::int64_t run : {1, 2}) {
    const std::string results = results_of(page({std::to_string(run)}));
    const RunAnalysis a = analysis(run);
    int with = 0, without = 0;
    for (const Metric* m : a.metrics()) {
      const auto value = fmt::format("<data value='{}'>", *m ? m->value() : 0);
      if (!*m || results.find(value) == results.npos) continue;
      const auto after = [&](double size, const char* words) {
        const auto at = results.find(value);
        const std::string cell = results.substr(at, results.find("</td>", at) - at);
        EXPECT_THAT(cell,
                    AllOf(HasSubstr(fmt::format(" ± <data value='{}'>", size)), HasSubstr(words)))
            << m->name;
      };
      if (const Uncertainty* u = a.uncertainty_of(*m)) {
        ++with;
        after(u->expanded, "(95 %, k = ");
      } else if (m->estimate->standard_error.value_or(0) > 0) {
        ++without;
        after(*m->estimate->standard_error, "(standard error)");
      }
    }
    EXPECT_GE(with, 4);
    EXPECT_GE(without, 1);
    EXPECT_GT(a.uncertainty_of(a.c0)->expanded, 10 * *a.c0.estimate->standard_error)
        << "at 1 kHz the meter's own error dominates";
  }
}

TEST_F(Report, QuotesOfAHysteresisThatWasNotFoundHowLargeItMayBe) {
  const std::string results = results_of(page({"2"}));
  const RunAnalysis a = analysis(2);
  const Metric& m = a.hysteresis.largest_gap;
  ASSERT_TRUE(m && !a.hysteresis.resolved) << "the run does not show the case";
  EXPECT_THAT(results, HasSubstr(fmt::format("not resolved, at most <data value='{}'>",
                                             m.value() + a.uncertainty_of(m)->expanded)));
  EXPECT_THAT(results, Not(HasSubstr(fmt::format("<data value='{}'>", m.value()))));
}

TEST_F(Report, ShowsTheAnalysisThatWasAskedFor) {
  const std::string plain = page({"1"});
  const std::string html =
      page({"1", "--range", "10:50", "--confidence", "0.99", "--force-class", "3",
            "--temperature-C", "30", "--stray-limit-fF", "50", "--regions"});
  AnalysisOptions wanted;
  wanted.ranges = {{10, 50}};
  wanted.confidence = 0.99;
  wanted.search_regions = true;
  wanted.rig.force_class_percent = 3;
  wanted.rig.stray_limit_fF = 50;
  wanted.rig.meter.temperature_C = 30;
  const RunAnalysis a = analyse(open_read_only(db).value(), 1, wanted).value();
  for (const Uncertainty& u : a.uncertainties) {
    const auto expanded = fmt::format("<data value='{}'>", u.expanded);
    EXPECT_THAT(html, HasSubstr(expanded)) << u.quantity;
    EXPECT_THAT(plain, Not(HasSubstr(expanded))) << u.quantity;
  }
  EXPECT_THAT(results_of(html), AllOf(HasSubstr("10–50 kPa"), HasSubstr("(99 %, k = ")));
  EXPECT_THAT(html, AllOf(HasSubstr("Two regions"), HasSubstr("limits of 3 % of reading")));
  EXPECT_EQ(cli.run({"--db", db, "report", "1", "-o", file, "--force-class", "7"}), kUsage);
}

// 80 degrees Celsius are beyond the meter's tables: its error is not known.
TEST_F(Report, BesideAGapPrintsALowerLimitAndNamesTheGap) {
  const std::string results = results_of(page({"1", "--temperature-C", "80"}));
  EXPECT_THAT(results, AllOf(HasSubstr("± at least"), HasSubstr("not included: meter")));
  EXPECT_THAT(results_of(page({"1"})), Not(HasSubstr("not included: meter")));
}

constexpr const char* kLoading = "loading branch, from ";
constexpr const char* kOfTheRig = "what this rig would show";

// Without its branch and time, a slope has no definite meaning.
TEST_F(Report, SaysWhichSlopeItIsAndWhatItsIntervalIsFor) {
  const std::string html = page({"1"});
  const std::string results =
      html.substr(html.find("<section id='results'>"),
                  html.find("<section id='pressure'>") - html.find("<section id='results'>"));
  EXPECT_THAT(results, AllOf(HasSubstr(analysis(1).ranges[0].sensitivity.estimand),
                             HasSubstr(kOfTheRig), HasSubstr("the specimen's own")));
  const RunAnalysis a = analysis(1);
  for (const Metric* m : a.chosen()) {
    if (*m) {
      EXPECT_THAT(results, HasSubstr(m->estimand)) << m->name;
    }
  }
  const std::string uncertainty = html.substr(html.find("<section id='uncertainty'>"));
  EXPECT_THAT(uncertainty,
              AllOf(HasSubstr(a.delta_C.estimand), HasSubstr(a.dynamic_range.estimand)));
  const std::string pressure =
      html.substr(html.find("<section id='pressure'>"),
                  html.find("<section id='time'>") - html.find("<section id='pressure'>"));
  EXPECT_THAT(pressure, AllOf(HasSubstr(kLoading), HasSubstr(kOfTheRig)));
  EXPECT_THAT(html.substr(html.find("<section id='metrics'>")),
              AllOf(HasSubstr(kLoading), HasSubstr(kOfTheRig)));
  EXPECT_THAT(page({"2"}), HasSubstr("loading branch, while the load grows"));
}

TEST_F(Report, OfSeveralRunsSaysWhichSlopesItCompares) {
  const std::string html = page({"1", "2"});
  const std::string results = html.substr(0, html.find("<section id='increase'>"));
  EXPECT_THAT(results, AllOf(HasSubstr(kLoading), HasSubstr(kOfTheRig),
                             HasSubstr("loading branch, while the load grows")));
  for (const std::int64_t run : {1, 2}) {
    const RunAnalysis a = analysis(run);
    for (const Metric* m : a.chosen()) {
      if (*m) {
        EXPECT_THAT(results, HasSubstr(m->estimand)) << m->name;
      }
    }
  }
}

TEST_F(Report, OfABatchSaysWhichSlopesItsMeansAreOf) {
  const std::string table = cli.dir.file("day.csv");
  std::ofstream(table) << "specimen,protocol,repeats,levels,readings,within_s\n"
                          "paper-1,static-frame,2,8,10,1.5\n";
  const std::string runs = cli.dir.file("day.db");
  cli.add_data("protocols/static-frame.json", shipped("protocols/library/static-frame.json"));
  cli.bench_rig = &bench_rig;
  cli.day = &rehearse_batch;
  ASSERT_EQ(cli.run({"rehearse", "--batch", table, "--db", runs}), 0) << cli.err.str();
  ASSERT_EQ(cli.run({"--db", runs, "report", "--batch", "day", "-o", file}), 0) << cli.err.str();
  constexpr const char* kPeak = "at the peak of 1.26 N, from ";
  constexpr const char* kRamps = "loading branch, while the load grows, from 0.0628 N";
  constexpr const char* kTop = "loading branch, from 1";
  EXPECT_THAT(read(file), AllOf(HasSubstr(kLoading), HasSubstr(kOfTheRig), HasSubstr(kPeak),
                                HasSubstr(kRamps), HasSubstr(kTop)));
  expect_harmless(read(file));
  ASSERT_EQ(cli.run({"--db", runs, "report", "--batch", "day", "-o", file, "--json"}), 0);
  EXPECT_THAT(cli.out.str(), AllOf(HasSubstr(kLoading), HasSubstr(kPeak), HasSubstr(kRamps)));
}

TEST_F(Report, OfADynamicRunShowsCyclesAndStaysSmall) {
  const std::string html = page({"2"});
  EXPECT_THAT(html, AllOf(HasSubstr("maximum of the cycle"), HasSubstr("ΔC/C0"),
                          HasSubstr("Gap between the branches")));
  EXPECT_LT(html.size(), 1'000'000U);
  expect_harmless(html);
}

TEST_F(Report, HostileTextsAreShownAndDoNothing) {
  const std::string html = page({"3"});
  expect_harmless(html);
  EXPECT_THAT(html, AllOf(HasSubstr("&lt;script&gt;alert(&quot;x&quot;)"), HasSubstr("␛[31m")));
  expect_harmless(page({"1", "3"}));
}

TEST_F(Report, OfSeveralRunsComparesThem) {
  const std::string html = page({"1", "3", "2"});
  EXPECT_THAT(html, AllOf(HasSubstr("Comparison of runs 1, 3, 2"), HasSubstr("increase"),
                          HasSubstr("id='increase'"), HasSubstr("SIMULATED")));
  expect_harmless(html);
}

TEST_F(Report, TableHasOneRowARun) {
  const std::string csv = cli.dir.file("results.csv");
  ASSERT_EQ(cli.run({"--db", db, "report", "1", "2", "-o", file, "--csv", csv}), 0)
      << cli.err.str();
  const std::string text = read(csv);
  EXPECT_EQ(std::ranges::count(text, '\n'), 3);
  EXPECT_THAT(text, AllOf(HasSubstr("sensitivity_0_to_30_kPa_fF_per_kPa"), HasSubstr("paper-1")));
  EXPECT_THAT(text, AllOf(HasSubstr("sensitivity_0_to_30_kPa_fF_per_kPa_estimand"),
                          HasSubstr('"' + analysis(1).ranges[0].sensitivity.estimand + '"')));
  for (const std::int64_t run : {1, 2}) {
    const RunAnalysis a = analysis(run);
    for (const Metric* m : a.chosen()) {
      EXPECT_THAT(text, HasSubstr(m->name + "_estimand"));
      if (*m) {
        EXPECT_THAT(text, HasSubstr('"' + m->estimand + '"')) << m->name;
      }
    }
  }
  // Up to the third digit of its standard error of some 6 fF.
  const Estimate c0 = *analysis(1).c0.estimate;
  ASSERT_GE(*c0.standard_error, 0.001);
  ASSERT_LT(*c0.standard_error, 0.01);
  EXPECT_THAT(text, HasSubstr(fmt::format(",{:.5f},{:.5f},", c0.value, *c0.standard_error)));
}

TEST_F(Report, IsWrittenOverNothingButAnEarlierOne) {
  const std::string copy = cli.dir.file("copy.db"), mine = cli.dir.file("mine.html");
  std::filesystem::copy_file(db, copy);
  const std::string database = read(copy);
  const std::string link = cli.dir.file("link.html");
  std::filesystem::create_symlink(copy, link);
  std::ofstream(mine) << "<!DOCTYPE html>\n<title>mine</title>";
  const std::string csv = cli.dir.file("results.csv");
  for (const std::vector<std::string>& output : {std::vector<std::string>{"-o", copy},
                                                 {"-o", link},
                                                 {"-o", mine},
                                                 {"-o", file, "--csv", copy},
                                                 {"-o", file, "--csv", mine}}) {
    std::vector<std::string> words{"--db", copy, "report", "1"};
    words.insert(words.end(), output.begin(), output.end());
    EXPECT_EQ(cli.run(words), cli::kFailed) << output.back();
    EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("cannot write " + output.back()),
                                     HasSubstr("which would be lost"), HasSubstr("next: give")));
  }
  EXPECT_EQ(read(copy), database);
  EXPECT_EQ(read(mine), "<!DOCTYPE html>\n<title>mine</title>");
  EXPECT_FALSE(std::filesystem::exists(file)) << "neither of the two is written";
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(cli.run({"--db", copy, "report", "1", "-o", file, "--csv", csv}), 0) << cli.err.str();
  }
  EXPECT_EQ(cli.run({"--db", copy, "report", "1", "-o", file, "--csv", file}), cli::kUsage);
  EXPECT_THAT(cli.err.str(), HasSubstr("the page and --csv are one file"));
}

// Run 1 of another database is another run.
TEST_F(Report, UnderTheDefaultNameReplacesThatOfTheSameRunsOnly) {
  const auto home = std::filesystem::current_path();
  std::filesystem::current_path(cli.dir.path());
  for (int i = 0; i < 2; ++i) EXPECT_EQ(cli.run({"--db", db, "report", "1"}), 0) << cli.err.str();
  std::filesystem::rename("report-1.html", "report-2.html");
  EXPECT_EQ(cli.run({"--db", db, "report", "2"}), cli::kFailed);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr("report-2.html is about another run"),
                                   HasSubstr("-o report-2-new.html")));
  EXPECT_EQ(cli.run({"--db", db, "report", "2", "-o", "report-2.html"}), 0) << cli.err.str();
  std::filesystem::current_path(home);
}

TEST_F(Report, MixedRunsAreMarked) {
  auto opened = open_read_only(db);
  ASSERT_TRUE(opened);
  std::vector<ReportRun> runs;
  for (const std::int64_t run : {1, 3}) {
    auto loaded = load_report_run(*opened, run);
    ASSERT_TRUE(loaded) << loaded.error().what;
    runs.push_back(std::move(*loaded));
  }
  EXPECT_THAT(report_html(runs), Not(HasSubstr("MIXED")));
  runs[1].data.row.simulated = false;
  EXPECT_THAT(report_html(runs), HasSubstr("MIXED: SIMULATED AND MEASURED RUNS"));
  runs[0].data.row.simulated = false;
  EXPECT_THAT(report_html(runs), Not(HasSubstr("SIMULATED")));
}

TEST_F(Report, ABrokenChainIsSaidFirst) {
  auto opened = open_read_only(db);
  ASSERT_TRUE(opened);
  auto run = load_report_run(*opened, 1);
  ASSERT_TRUE(run);
  run->chain.intact = false;
  run->chain.finding = "reading 3 was changed";
  const std::string html = report_html(std::span(&*run, 1));
  EXPECT_LT(html.find("reading 3 was changed"), html.find("id='results'"));
}

// A reader of the numbers should not have to think of `verify`.
TEST_F(Report, ARunThatWasChangedIsCalledSoByWhateverShowsItsNumbers) {
  ASSERT_EQ(cli.run({"--db", db, "analyze", "1"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), Not(HasSubstr("not as it was recorded")));
  const std::string changed = cli.dir.file("changed.db");
  std::filesystem::copy_file(db, changed);
  auto opened = Database::open(changed, Database::Mode::read_write_create);
  ASSERT_TRUE(opened);
  ASSERT_TRUE(
      opened->execute("DROP TRIGGER frame_sample_no_delete;"
                      "DELETE FROM frame_sample WHERE run_id = 1 AND seq = 20"));
  ASSERT_EQ(cli.run({"--db", changed, "analyze", "1"}), 0) << cli.err.str();
  EXPECT_THAT(cli.out.str(), HasSubstr("note: not as it was recorded: frame_sample 20 is missing"));
  ASSERT_EQ(cli.run({"--db", changed, "analyze", "1", "--json"}), 0) << cli.err.str();
  EXPECT_THAT(nlohmann::json::parse(cli.out.str())["notes"][0].get<std::string>(),
              HasSubstr("frame_sample 20 is missing"));
  ASSERT_EQ(cli.run({"--db", changed, "report", "1", "-o", file}), 0) << cli.err.str();
  EXPECT_THAT(read(file), HasSubstr("BROKEN: frame_sample 20 is missing"));
}

TEST_F(Report, UnknownRunsAndUnwritableFilesAreRefused) {
  EXPECT_EQ(cli.run({"--db", db, "report", "99", "-o", file}), 1);
  EXPECT_THAT(cli.err.str(), HasSubstr("99"));
  EXPECT_EQ(cli.run({"--db", db, "report", "first", "-o", file}), 1);
  const std::string nowhere = cli.dir.file("no/such/folder/r.html");
  EXPECT_EQ(cli.run({"--db", db, "report", "1", "-o", nowhere}), 1);
  EXPECT_THAT(cli.err.str(), AllOf(HasSubstr(nowhere), HasSubstr("No such file")));
  EXPECT_EQ(cli.run({"--db", db, "report", "1", "-o", cli.dir.path().string()}), 1);
  EXPECT_THAT(cli.err.str(), HasSubstr("directory"));
}

TEST_F(Report, TheSameRunGivesTheSamePage) {
  const std::string first = page({"1"});
  EXPECT_EQ(first, page({"1"}));
}

}  // namespace
}  // namespace lcrig::cli
