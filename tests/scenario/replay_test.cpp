// SPDX-License-Identifier: Apache-2.0
// A recording is played through the wires of both simulated instruments. The export must then have
// the same digits and each reading once.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/export.hpp"
#include "base/strict_json.hpp"
#include "daemon/rehearse.hpp"
#include "daemon/rig/recording.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/decimal_text.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using CsvRow = std::vector<std::string>;

// The named columns of a CSV file that has no line breaks in cells.
std::vector<CsvRow> columns(const std::string& path, const std::vector<std::string>& names) {
  std::ifstream file(path);
  std::vector<CsvRow> rows;
  std::vector<std::size_t> wanted;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    CsvRow cells(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') {
        quoted = !quoted;
      } else if (c == ',' && !quoted) {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    if (wanted.empty()) {
      for (const auto& name : names) {
        wanted.push_back(
            static_cast<std::size_t>(std::find(cells.begin(), cells.end(), name) - cells.begin()));
      }
      continue;
    }
    rows.emplace_back();
    for (const std::size_t i : wanted) rows.back().push_back(cells.at(i));
  }
  return rows;
}

void expect_played_exactly(const std::string& directory) {
  const TempDir dir;
  RehearseRequest request;
  request.protocol_name = "follow";
  request.protocol_text = library("follow");
  request.bench = "replay:" + directory;
  request.db_path = dir.file("r.db");
  const auto result = rehearse(request);
  ASSERT_TRUE(result) << result.error().what;
  ASSERT_EQ(result->exit_status, ExitStatus::success) << result->reason;
  const auto db = open_read_only(request.db_path);
  ASSERT_TRUE(db);
  const auto corrections = parse_corrections(get_run(*db, result->run).value().correction_json);
  ASSERT_TRUE(corrections);
  EXPECT_FALSE(corrections->open.on) << "the recording does not tell";
  EXPECT_FALSE(corrections->short_circuit.on);
  ExportOptions options;
  options.directory = dir.file("csv");
  ASSERT_TRUE(export_run(*db, result->run, options));

  const Recording recording = load_recording(directory).value();
  const auto readings =
      columns(dir.file("csv/lcr.csv"), {"capacitance_pF", "resistance_ohm", "flags"});
  ASSERT_EQ(readings.size(), recording.readings.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const RecordedReading& r = recording.readings[i];
    const bool overload = r.secondary >= 9.9e19;
    EXPECT_EQ(readings[i][0], decimal_shift(r.primary, 12)) << "row " << i;
    EXPECT_EQ(readings[i][1], overload ? "" : decimal_shift(r.secondary, 0)) << "row " << i;
    EXPECT_EQ(readings[i][2], overload ? "overload_secondary" : "") << "row " << i;
  }
  const auto samples = columns(dir.file("csv/frame.csv"), {"force_N", "travel_mm"});
  ASSERT_EQ(samples.size(), recording.samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i][0], decimal_shift(recording.samples[i].force_N, 0)) << "row " << i;
    EXPECT_EQ(samples[i][1], decimal_shift(recording.samples[i].travel_m, 3)) << "row " << i;
  }
}

TEST(Replay, AMadeUpRecordingComesOutDigitForDigit) {
  const TempDir dir;
  std::ofstream lcr(dir.file("lcr.csv"));
  std::ofstream frame(dir.file("frame.csv"));
  lcr << "t_s,Cp_F,Rp_ohm\n";
  frame << "t_s,travel_mm,force_N\n";
  for (int i = 0; i < 300; ++i) {
    // 30 ms is the shortest step of the real recording; every seventh Rp overflows.
    lcr << i * 0.0305 << ',' << fmt::format("{:.5e}", 1.8e-12 + i * 1.37e-16) << ','
        << (i % 7 == 0 ? "1.00000e+20" : fmt::format("{:.5e}", 9.1e7 - i * 1234.5)) << '\n';
    frame << fmt::format("{:.4f},{:.3f},{:.4f}\n", i * 0.01, 0.065 + i * 0.001, 2.7 + i * 0.0007);
  }
  lcr.close();
  frame.close();
  expect_played_exactly(dir.path().string());
}

TEST(Replay, TheRealRecordingComesOutDigitForDigit) {
  const std::string real = "../shared/data/real-press-9mm";
  if (!std::filesystem::exists(real)) {
    GTEST_SKIP() << real << " is not here: the real recording is not part of the project";
  }
  expect_played_exactly(real);
}

}  // namespace
}  // namespace lcrig
