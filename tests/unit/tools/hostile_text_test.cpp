// SPDX-License-Identifier: Apache-2.0
// Names and notes that cannot be trusted, through every command that shows them. The rows are
// written without the checks for new rows, because a database may be older than those.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "analysis/analysis_text.hpp"
#include "analysis/report/report.hpp"
#include "daemon/session.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "storage/specimens.hpp"
#include "tests/support/cli_fixture.hpp"
#include "tests/support/hostile_texts.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/xml.hpp"
#include "tools/lcrig/live_line.hpp"

namespace lcrig::cli {
namespace {

using nlohmann::json;
using support::every_hostile_text;
using support::expect_harmless_on_a_terminal;
using support::expect_json;
using support::hostile_texts;
using testing::HasSubstr;
using testing::Not;

class Hostile : public testing::Test {
 protected:
  void SetUp() override { cli.variables["LCRIG_DB"] = path; }
  Database database() { return open_read_write(path).value(); }
  // Adds a closed run in which every free text is `note`; a megabyte is kept only in the note.
  void add_run(const Database& db, const std::string& note) {
    const std::string text = note.substr(0, 20'000);
    RunRow row;
    row.protocol_name = row.specimen_name = row.operator_name = text;
    row.note = note;
    row.lcr_identity = row.frame_identity = row.bench_name = text;
    row.protocol_text = row.specimen_text = "{}";
    const auto run = insert_run(db, row).value();
    RunEnd end;
    end.status = ExitStatus::abort;
    end.reason = text;
    ASSERT_TRUE(insert_run_end(db, run, end));
  }
  void expect_harmless(const std::vector<std::string>& args, std::size_t lines) {
    cli.run(args);
    expect_harmless_on_a_terminal(cli.out.str(), lines, testing::PrintToString(args));
    expect_harmless_on_a_terminal(cli.err.str(), 5, testing::PrintToString(args));
    auto with_json = args;
    with_json.emplace_back("--json");
    EXPECT_EQ(cli.run(with_json), kOk) << cli.err.str();
    expect_json(cli.out.str(), testing::PrintToString(with_json));
    EXPECT_EQ(cli.out.str(), printable_lines(cli.out.str())) << testing::PrintToString(with_json);
  }

  support::Cli cli;
  std::string path = cli.dir.file("runs.db");
};

TEST_F(Hostile, TextsOfARunDoNotReachTheTerminal) {
  const auto db = database();
  for (const auto& t : hostile_texts()) add_run(db, t.text);
  const auto runs = hostile_texts().size();
  expect_harmless({"runs"}, runs + 1);
  for (std::size_t run = 1; run <= runs; ++run) {
    expect_harmless({"runs", "show", std::to_string(run)}, 40);
  }
}

TEST_F(Hostile, NamesOfSpecimensDoNotReachTheTerminal) {
  const auto db = database();
  std::size_t stored = 0;
  for (const auto& t : hostile_texts()) {
    ASSERT_TRUE(lcrig::add_specimen(db, t.text, "{}", 0)) << t.name;
    ++stored;
  }
  expect_harmless({"specimen", "list"}, stored + 10);
}

TEST_F(Hostile, AFileIsShownByteByByteToAProgramAndHarmlesslyToAPerson) {
  const std::string text = "{ \"name\": \"\u009b2J\" } // \x1b[2J\xff";
  for (const bool terminal : {false, true}) {
    std::ostringstream out, err;
    Console console(out, err);
    console.out_tty = terminal;
    console.print_file(text);
    EXPECT_EQ(out.str() == text + "\n", !terminal);
    if (terminal) expect_harmless_on_a_terminal(out.str(), 1, "a file");
  }
}

TEST_F(Hostile, ArgumentsAreShownHarmlesslyWhenTheyAreRefused) {
  for (const auto& [name, text] : hostile_texts()) {
    if (text.size() > 100'000) continue;  // the kernel allows no longer ones
    for (const auto& args : {std::vector<std::string>{"runs", "show", text},
                             {"specimen", "show", text},
                             {"protocol", "show", text},
                             {"rehearse", text, "--specimen", text},
                             {text}}) {
      EXPECT_NE(cli.run(args), kOk) << name;
      expect_harmless_on_a_terminal(cli.out.str(), 40, name);
      expect_harmless_on_a_terminal(cli.err.str(), 5, name);
    }
  }
}

TEST_F(Hostile, ANoteIsLimited) {
  const auto db = database();
  add_run(db, "fine");
  EXPECT_EQ(cli.run({"runs", "note", "1", std::string(kNoteMax, 'x')}), kOk) << cli.err.str();
  EXPECT_EQ(cli.run({"runs", "note", "1", std::string(kNoteMax + 1, 'x')}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("note: 65537 bytes, expected at most 65536"));
  EXPECT_EQ(cli.run({"runs", "note", "1", "\xff"}), kFailed);
  EXPECT_THAT(cli.err.str(), HasSubstr("note: is not UTF-8"));
}

TEST(HostileRequest, IsRefusedBeforeAnythingRuns) {
  const auto refusal = [](auto change) {
    RunRequest request;
    request.protocol_name = "p";
    request.specimen_name = "s";
    change(request);
    return prepare_run(std::move(request)).error().what;
  };
  EXPECT_THAT(refusal([](auto& r) { r.operator_name = std::string(1'000'000, 'x'); }),
              HasSubstr("operator: 1000000 bytes, expected at most 200"));
  EXPECT_THAT(refusal([](auto& r) { r.note = std::string(1'000'000, 'x'); }),
              HasSubstr("note: 1000000 bytes"));
  EXPECT_THAT(refusal([](auto& r) { r.specimen_name = std::string(201, 'x'); }),
              HasSubstr("specimen: 201 bytes"));
  EXPECT_THAT(refusal([](auto& r) { r.operator_name = "\xff"; }), HasSubstr("operator: is not"));
}

TEST(HostileStatus, IsOneHarmlessLine) {
  for (const auto& [name, text] : hostile_texts()) {
    RunStatus s;
    s.step_id = s.prompt = text;
    expect_harmless_on_a_terminal(format_live_line(s, 80), 0, name);
    expect_harmless_on_a_terminal(format_plain_line(s), 0, name);
  }
}

// One run whose texts are all of these, through analysis and report.
TEST(HostileReport, IsWellFormedAndHoldsNothingForeign) {
  SyntheticRun run;
  run.row.specimen_name = run.row.protocol_name = run.row.operator_name = every_hostile_text();
  run.row.note = every_hostile_text(1'000'000);
  run.row.lcr_identity = run.row.frame_identity = every_hostile_text();
  run.row.protocol_text = run.row.specimen_text = run.row.bench_text = every_hostile_text();
  run.row.bench_name = run.row.software_version = every_hostile_text();
  run.begin();
  for (const auto& t : hostile_texts()) {
    run.event(t.text.substr(0, 1'000), t.text.substr(0, 20'000), "step");
  }
  SyntheticRun::Static play;
  play.repeats = 2;
  play.readings = 3;
  run.play(play);
  run.end(ExitStatus::abort);
  const std::int64_t id = run.run();
  ASSERT_TRUE(add_run_note(run.db(), id, "Ada", "<script>\x1b[31m", 0));
  auto loaded = load_report_run(run.db(), id);
  ASSERT_TRUE(loaded) << loaded.error().what;
  expect_harmless_on_a_terminal(to_text(loaded->analysis), 140, "lcrig analyze");
  const std::vector<ReportRun> one(1, *loaded), two(2, *loaded);
  for (const std::string& html : {report_html(one), report_html(two)}) {
    EXPECT_EQ(XmlCheck::fault(html, {"meta"}), "");
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("<img"), std::string::npos);
    EXPECT_EQ(html.find('\x1b'), std::string::npos);
    EXPECT_TRUE(is_utf8(html));
  }
}

}  // namespace
}  // namespace lcrig::cli
