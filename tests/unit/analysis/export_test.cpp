// SPDX-License-Identifier: Apache-2.0
#include "analysis/export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/pieces.hpp"
#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/hostile_texts.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream out;
  out << file.rdbuf();
  return out.str();
}

class ExportTest : public testing::Test {
 protected:
  void SetUp() override {
    auto db = open_read_write(dir_.file("a.db"));
    ASSERT_TRUE(db) << db.error().what;
    db_ = std::move(*db);
    row_.protocol_name = "static-frame";
    row_.specimen_name = "paper-1";
    row_.started = MonoTime(std::chrono::seconds(1));
    row_.lcr_settings_json = R"({"frequency_Hz": 1000, "trigger": "bus"})";
  }
  void begin() {
    auto run = insert_run(db_, row_);
    ASSERT_TRUE(run) << run.error().what;
    run_ = *run;
  }
  void begin_with_probe() {
    row_.probe_diameter_m = 0.004;
    begin();
  }
  void sql(const std::string& text) {
    auto r = db_.execute(text);
    ASSERT_TRUE(r) << r.error().what;
  }
  // Times in ms after the start, as in the exported file.
  void reading(int seq, int asked, int first, const std::string& tail) {
    const auto ns = [](int ms) { return 1'000'000'000LL + ms * 1'000'000LL; };
    sql(
        fmt::format("INSERT INTO lcr_reading (run_id, seq, asked_mono_ns, first_byte_mono_ns,"
                    " last_byte_mono_ns, step_id, repeat, level, reading_index, fresh, flags,"
                    " function, status, capacitance_F, dissipation)"
                    " VALUES ({}, {}, {}, {}, {}, 'm', 1, {})",
                    run_, seq, ns(asked), ns(first), ns(first + 1), tail));
  }
  void sample(int seq, int device_seq, int ms, double force, double travel, int flags = 0) {
    sql(fmt::format("INSERT INTO frame_sample VALUES ({}, {}, {}, {}, NULL, {}, {}, {})", run_, seq,
                    1'000'000'000LL + ms * 1'000'000LL, device_seq, force, travel, flags));
  }
  void event(int seq, int ms, const std::string& kind, const std::string& detail) {
    sql(fmt::format("INSERT INTO event VALUES ({}, {}, {}, '{}', 's', '{}')", run_, seq,
                    1'000'000'000LL + ms * 1'000'000LL, kind, detail));
  }
  std::string exported(Layout layout) {
    const std::string path = dir_.file("out.csv");
    FILE* file = std::fopen(path.c_str(), "wb");
    auto r = export_layout(db_, run_, layout, ::fileno(file), path);
    std::fclose(file);
    EXPECT_TRUE(r) << r.error().what;
    return read(path);
  }

  TempDir dir_;
  Database db_;
  RunRow row_;
  std::int64_t run_ = 0;
};

TEST_F(ExportTest, ReadingsHaveTheDigitsOfTheInstrumentAndOverloadsAreEmpty) {
  begin();
  reading(1, 0, 60, "1, 1, 1, 0, 'Cp-D', 'OUT ,NG', 1.84249e-12, 0.00413");
  reading(2, 100, 160, "NULL, NULL, 1, 2, 'Cp-D', '', 1.84250e-12, NULL");
  reading(3, 200, 260, "NULL, NULL, 0, 1, 'Cp-D', '', NULL, 0.1");
  event(1, 150, "settings", R"({"frequency_Hz": 2000})");
  EXPECT_EQ(exported(Layout::readings),
            "seq,t_s,t_asked_s,t_first_byte_s,step,repeat,level_in_run,reading,fresh,flags,"
            "function,frequency_Hz,capacitance_pF,dissipation,status,level\r\n"
            "1,0.061,0,0.06,m,1,1,1,true,,Cp-D,1000,1.84249,0.00413,\"OUT ,NG\",1\r\n"
            "2,0.161,0.1,0.16,m,1,,,true,overload_secondary,Cp-D,1000,1.8425,,,\r\n"
            "3,0.261,0.2,0.26,m,1,,,false,overload_primary,Cp-D,2000,,0.1,,\r\n");
}

TEST_F(ExportTest, FrameHasGapFromTheLastContactAndPressureOverTheProbe) {
  begin_with_probe();
  sample(1, 1, 0, 0.5, 0.0010);
  sample(2, 2, 20, 1.0, 0.0013, 9);
  event(1, 10, "contact", R"({"travel_m": 0.0012})");
  EXPECT_EQ(exported(Layout::frame),
            "seq,t_s,t_received_s,device_time_s,force_N,travel_mm,gap_mm,pressure_kPa,flags\r\n"
            "1,0,0,,0.5,1,,39.8,\r\n"
            "2,0.02,0.02,,1,1.3,-0.1,79.6,moving after_gap\r\n");
}

// Longer than one piece and one batch, so that threads share the work.
TEST_F(ExportTest, LongRunKeepsEveryRowInOrder) {
  begin();
  const std::int64_t rows = 2 * kPieceRows + 3;
  sql(
      fmt::format("INSERT INTO frame_sample WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL"
                  " SELECT i + 1 FROM n WHERE i < {1}) SELECT {0}, i, 1000000000 + i * 1000000, i,"
                  " NULL, i * 0.5, 0.001, 0 FROM n",
                  run_, rows));
  std::string expected =
      "seq,t_s,t_received_s,device_time_s,force_N,travel_mm,gap_mm,pressure_kPa,flags\r\n";
  for (std::int64_t i = 1; i <= rows; ++i) {
    expected += fmt::format("{0},{1},{1},,{2},1,,,\r\n", i, static_cast<double>(i) / 1000,
                            static_cast<double>(i) * 0.5);
  }
  EXPECT_TRUE(exported(Layout::frame) == expected);  // too long to be shown
  reading(1, 100, 100, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  reading(2, 131'074, 131'074, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  const std::string aligned = exported(Layout::aligned);
  EXPECT_THAT(aligned, HasSubstr("\r\n1,0.1,m,1,,,,1,0.1,50,1,"));
  EXPECT_THAT(aligned, HasSubstr("\r\n2,131.074,m,1,,,,1,0.1,65537,1,"));
}

TEST(Pieces, AFailureInAThreadIsToldAndEndsTheWork) {
  TempDir dir;
  auto db = open_read_write(dir.file("a.db"));
  ASSERT_TRUE(db) << db.error().what;
  int used = 0;
  const auto r = in_pieces(
      *db, 100, 10,
      [](const Database&, Piece p) -> Result<std::string> {
        if (p.first_seq == 31) return fail(Errc::io, "the disk");
        return std::to_string(p.first_seq);
      },
      [&used](const std::string& text) -> Result<> {
        EXPECT_EQ(text, std::to_string(10 * used + 1));
        ++used;
        return {};
      });
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().what, "the disk");
  EXPECT_EQ(used, 3);
}

TEST_F(ExportTest, AlignedInterpolatesToTheMiddleOfTheWindow) {
  begin_with_probe();
  sample(1, 1, 0, 0.0, 0.001);
  sample(2, 2, 100, 1.0, 0.002);
  sample(3, 4, 200, 2.001, 0.00301);  // one is missing before it
  sample(4, 5, 300, 3.001, 0.00401);
  reading(1, 20, 80, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  reading(2, 110, 130, "NULL, NULL, 1, 0, 'Cp-D', '', 2e-12, 0.1");  // in the gap
  reading(3, 140, 160, "NULL, NULL, 0, 0, 'Cp-D', '', 2e-12, 0.1");  // not fresh
  reading(4, 250, 300, "NULL, NULL, 1, 0, 'Cp-D', '', 3e-12, 0.1");
  reading(5, 310, 330, "NULL, NULL, 1, 0, 'Cp-D', '', 3e-12, 0.1");  // after the last
  EXPECT_EQ(exported(Layout::aligned),
            "seq,t_s,step,repeat,level_in_run,reading,flags,capacitance_pF,dissipation,force_N,"
            "travel_mm,gap_mm,pressure_kPa,alignment_uncertainty_s,alignment_uncertainty_N,level"
            "\r\n"
            "1,0.05,m,1,,,,1,0.1,0.5,1.5,,39.789,0.0337,0.337,\r\n"
            "2,0.12,m,1,,,,2,0.1,,,,,,,\r\n"
            "4,0.275,m,1,,,,3,0.1,2.751,3.76,,218.918,0.0323,0.323,\r\n"
            "5,0.32,m,1,,,,3,0.1,,,,,,,\r\n");
}

TEST_F(ExportTest, DeadWeightsHoldTheirForceUntilTheNextSample) {
  row_.frame_capabilities_json = R"({"weights": true})";
  begin();
  sample(1, 1, 0, 0.5, 0.0);
  sample(2, 2, 1000, 0.9, 0.0);
  reading(1, 700, 800, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  reading(2, 1700, 1800, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  const std::string csv = exported(Layout::aligned);
  EXPECT_THAT(csv, HasSubstr("\r\n1,0.75,m,1,,,,1,0.1,0.5,"));
  EXPECT_THAT(csv, HasSubstr("\r\n2,1.75,m,1,,,,1,0.1,0.9,"));
}

TEST_F(ExportTest, LevelsHoldTheMeasureReadingsWithTheirTarget) {
  begin_with_probe();
  sql(fmt::format("INSERT INTO level VALUES ({}, 1, 1, 'm', 2, 3, NULL, 10000, 30, 0)", run_));
  sample(1, 1, 0, 0.12, 0.001);
  sample(2, 2, 100, 0.12, 0.001);
  reading(1, 0, 10, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  reading(2, 20, 80, "1, 1, 1, 0, 'Cp-D', '', 3.6457e-12, 0.1");
  EXPECT_EQ(exported(Layout::levels),
            "seq,t_s,step,repeat,level_in_run,level_in_repeat,reading,target_force_N,"
            "target_pressure_kPa,force_N,pressure_kPa,capacitance_pF,dissipation,flags,level,index"
            "\r\n"
            "2,0.05,m,2,1,3,1,,10,0.12,9.55,3.6457,0.1,,1,3\r\n");
}

// A sweep adds the noise of a double to what somebody typed.
TEST_F(ExportTest, TargetsHaveNoMoreDigitsThanAPersonTypes) {
  begin_with_probe();
  sql(
      fmt::format("INSERT INTO level VALUES ({}, 1, 1, 'm', 1, 1, 0.12566370614359174,"
                  " 10000.000000000002, 30, 0)",
                  run_));
  sample(1, 1, 0, 0.12, 0.001);
  reading(1, 20, 80, "1, 1, 1, 0, 'Cp-D', '', 3.6457e-12, 0.1");
  EXPECT_THAT(exported(Layout::levels), HasSubstr(",m,1,1,1,1,0.125663706,10,"));
}

// Readings with steps of 0.1 mN, one of which ends with zeros; a meter reading between two of them.
TEST_F(ExportTest, ComputedValuesEndOneDigitBehindTheReadingsTheyComeFrom) {
  begin_with_probe();
  sample(1, 1, 0, 0.1, 0.0012345);
  sample(2, 2, 30, 0.1771, 0.0012347);
  event(1, 0, "contact", R"({"travel_m": 0.0012123456789})");
  reading(1, 0, 20, "1, 1, 1, 0, 'Cp-D', '', 1.84249e-12, 0.1");
  EXPECT_THAT(exported(Layout::aligned),
              HasSubstr("1.84249,0.1,0.1257,1.23457,-0.02222,10.0029,0.0104,0.0267,1\r\n"));
  EXPECT_THAT(exported(Layout::frame), HasSubstr(",0.1771,1.2347,-0.02235,14.0932,\r\n"));
}

// The force of a dead weight is the weight that was asked for: a double with all of its digits.
TEST_F(ExportTest, ComputedValuesHaveNoEndlessDigitsAndStoredOnesAll) {
  row_.frame_capabilities_json = R"({"weights": true})";
  begin_with_probe();
  sample(1, 1, 0, 0.9086452598075095, 0.0);
  reading(1, 700, 800, "NULL, NULL, 1, 0, 'Cp-D', '', 1e-12, 0.1");
  EXPECT_THAT(exported(Layout::aligned), HasSubstr(",0.90864526,0,,72.30769231,"));
  EXPECT_THAT(exported(Layout::frame), HasSubstr(",0.9086452598075095,0,,72.30769231,"));
}

TEST_F(ExportTest, EventsAreQuotedAndHarmless) {
  begin();
  event(1, 1500, "mark", "=cmd, \"x\"");
  EXPECT_EQ(exported(Layout::events),
            "seq,t_s,kind,step,detail\r\n1,1.5,mark,s,\"'=cmd, \"\"x\"\"\"\r\n");
}

TEST_F(ExportTest, AnswersAreTypedAndHarmless) {
  begin();
  event(
      1, 1500, "answer",
      R"({"question":"Thickness","type":"number","number":125.5,"unit":"um","source":"person","by":"ada","repeat":2})");
  event(
      2, 2500, "answer",
      R"({"question":"Seen","type":"line","text":"=1+1","source":"default","repeat":0,"from_run":7})");
  event(3, 3500, "answer",
        R"({"question":"Clean","type":"confirmation","source":"person","by":"ada","repeat":0})");
  EXPECT_EQ(exported(Layout::answers),
            "seq,t_s,step,repeat,question,type,number,unit,text,source,answered_by,from_run\r\n"
            "1,1.5,s,2,Thickness,number,125.5,um,,person,ada,\r\n"
            "2,2.5,s,0,Seen,line,,,'=1+1,default,,7\r\n"
            "3,3.5,s,0,Clean,confirmation,,,,person,ada,\r\n");
}

// Counts the records of a CSV text. Quotes are respected; everything else is part of a cell.
std::size_t count_records(const std::string& csv) {
  std::size_t records = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    if (csv[i] == '"') quoted = !quoted;
    if (!quoted && csv[i] == '\n') ++records;
  }
  return records;
}

TEST_F(ExportTest, HostileTextsAreOneCellEachAndThePackageHoldsThemAsTheyWere) {
  const auto& texts = support::hostile_texts();
  row_.operator_name = row_.specimen_name = texts.front().text;
  row_.note = support::every_hostile_text(1'000'000);
  begin();
  for (std::size_t i = 0; i < texts.size(); ++i) {
    auto s = db_.prepare("INSERT INTO event VALUES (?, ?, 1000000000, ?, ?, ?)").value();
    s.bind(0, run_);
    s.bind(1, static_cast<std::int64_t>(i + 1));
    for (int column = 2; column <= 4; ++column) {
      s.bind(column, std::string_view(texts[i].text).substr(0, 50'000));
    }
    ASSERT_TRUE(s.run());
  }
  std::string csv = exported(Layout::events);
  EXPECT_EQ(count_records(csv), texts.size() + 1);
  std::erase(csv, '\r');
  EXPECT_EQ(csv, printable_lines(csv)) << "something steers a terminal";
  ASSERT_TRUE(export_run(db_, run_, {dir_.file("out"), false, {}}));
  const std::string package = read(dir_.file("out/datapackage.json"));
  support::expect_json(package, "datapackage.json");
  EXPECT_EQ(nlohmann::json::parse(package)["lcrig"]["operator"], texts.front().text);
}

TEST_F(ExportTest, ASimulatedRunSaysSoInEveryRow) {
  row_.simulated = true;
  begin();
  event(1, 0, "mark", "x");
  EXPECT_EQ(exported(Layout::events),
            "seq,t_s,kind,step,detail,simulated\r\n1,0,mark,s,x,true\r\n");
}

TEST_F(ExportTest, ThePackageDescribesEveryColumnOfEveryFile) {
  row_.simulated = true;
  row_.started_unix_ns = 1'767'225'600'250'000'000;
  begin();
  reading(1, 0, 60, "1, 1, 1, 0, 'Cp-Rp', '', 1e-12, NULL");
  auto files = export_run(db_, run_, {dir_.file("out"), false, {}});
  ASSERT_TRUE(files) << files.error().what;
  EXPECT_EQ(files->files.size(), 7U);
  const auto package = nlohmann::json::parse(read(dir_.file("out/datapackage.json")));
  EXPECT_EQ(package["profile"], "tabular-data-package");
  EXPECT_EQ(package["lcrig"]["simulated"], true);
  EXPECT_THAT(package["title"], StartsWith("SIMULATED"));
  EXPECT_EQ(package["lcrig"]["started"], "2026-01-01T00:00:00.250+00:00");
  EXPECT_EQ(package["lcrig"]["ended"], nullptr);
  EXPECT_FALSE(package.contains("licenses")) << "nobody stated one";
  ASSERT_EQ(package["resources"].size(), 6U);
  for (const auto& resource : package["resources"]) {
    std::string header;
    for (const auto& field : resource["schema"]["fields"]) {
      header += (header.empty() ? "" : ",") + field["name"].get<std::string>();
      EXPECT_FALSE(field["description"].get<std::string>().empty());
    }
    const auto csv = read(dir_.file("out/" + resource["path"].get<std::string>()));
    EXPECT_EQ(csv.substr(0, csv.find('\r')), header);
  }
}

TEST_F(ExportTest, OnlyAnEarlierExportOfTheSameRunIsOverwritten) {
  begin();
  const std::string out = dir_.file("out");
  ASSERT_TRUE(export_run(db_, run_, {out, false, {}}));
  EXPECT_TRUE(export_run(db_, run_, {out, false, {}}));
  row_.started_unix_ns = 77;
  begin();
  auto refused = export_run(db_, run_, {out, false, {}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::invalid_request);
  EXPECT_THAT(refused.error().what, HasSubstr("--force"));
  EXPECT_TRUE(export_run(db_, run_, {out, true, {}}));
  std::filesystem::create_directory(dir_.file("mine"));
  std::ofstream(dir_.file("mine/lcr.csv")) << "precious";
  EXPECT_FALSE(export_run(db_, run_, {dir_.file("mine"), false, {}}));
  EXPECT_EQ(read(dir_.file("mine/lcr.csv")), "precious");
}

TEST_F(ExportTest, TheLicenceIsTheOneThatWasStated) {
  begin();
  ExportOptions options{dir_.file("out"), false, "CC-BY-4.0"};
  const auto stated = [&] {
    EXPECT_TRUE(export_run(db_, run_, options));
    return nlohmann::json::parse(read(dir_.file("out/datapackage.json")))["licenses"].dump();
  };
  EXPECT_EQ(stated(), R"([{"name":"CC-BY-4.0"}])");
  options.license = "https://example.org/terms?v=1";
  EXPECT_EQ(stated(), R"([{"path":"https://example.org/terms?v=1"}])");
  for (const char* bad : {"all rights reserved", "file:///etc/passwd", "a\x1b[31m", "\xc3\xa4"}) {
    options.license = bad;
    auto refused = export_run(db_, run_, options);
    ASSERT_FALSE(refused) << bad;
    EXPECT_THAT(refused.error().what, HasSubstr("CC-BY-4.0"));
  }
}

TEST_F(ExportTest, AnUnknownRunIsRefused) {
  auto r = export_run(db_, 9, {dir_.file("out"), false, {}});
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().what, HasSubstr("no run 9"));
  EXPECT_FALSE(std::filesystem::exists(dir_.file("out")));
}

}  // namespace
}  // namespace lcrig
