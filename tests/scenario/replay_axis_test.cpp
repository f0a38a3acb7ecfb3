// SPDX-License-Identifier: Apache-2.0
// A replayed recording has one time axis: what was recorded together comes out together, whatever
// the zero of the files and the meaning of their times.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "analysis/analysis.hpp"
#include "analysis/run_data.hpp"
#include "daemon/rehearse.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/made_recording.hpp"
#include "tests/support/protocol_text.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

using support::MadeFile;
using support::MadeRecording;
using ::testing::Contains;
using ::testing::HasSubstr;

class ReplayAxis : public ::testing::Test {
 protected:
  RunData played(const MadeFile& lcr, const MadeFile& frame) {
    const std::string folder = dir_.file("recording");
    std::filesystem::create_directories(folder);
    support::write_text(folder + "/lcr.csv", lcr.text());
    support::write_text(folder + "/frame.csv", frame.text());
    RehearseRequest request;
    request.protocol_name = "follow";
    request.protocol_text = library("follow");
    request.parameters = {{"duration_s", "60"}};
    request.bench = "replay:" + folder;
    request.db_path = dir_.file(fmt::format("{}.db", ++runs_));
    const auto result = rehearse(request);
    if (!result) throw std::runtime_error(result.error().what);
    EXPECT_EQ(result->exit_status, ExitStatus::success) << result->reason;
    return load_run_data(open_read_only(request.db_path).value(), result->run).value();
  }

 private:
  TempDir dir_;
  int runs_ = 0;
};

MadeRecording steep() {
  MadeRecording out;
  out.noise_F = 1e-17;
  return out;
}

// The force that the run gives each reading is the one under which it was measured, up to half a
// poll (10 ms) of the rate of force.
void expect_pairs(const MadeRecording& made, const RunData& data) {
  const double slack_N = made.peak_N / made.branch_s * 0.012;
  int loaded = 0;
  double sum_N = 0;
  for (const RunReading& r : data.readings) {
    if (!r.has_force()) continue;
    const double measured_N = (r.capacitance_F - made.zero_F) / made.slope_F_per_N;
    if (measured_N < 1 || measured_N > made.peak_N - 1) continue;
    ++loaded;
    sum_N += std::abs(r.force_N - measured_N);
    EXPECT_NEAR(r.force_N, measured_N, slack_N) << r.t_s << " s";
  }
  EXPECT_GT(loaded, 3 * made.loadings);
  EXPECT_LT(sum_N / loaded, slack_N * 0.7);
}

TEST_F(ReplayAxis, ZeroMayBeAnything) {
  const MadeRecording made = steep();
  std::vector<double> first;
  for (const double zero_s : {0.0, -123.5, 1.79e9}) {
    SCOPED_TRACE(zero_s);
    MadeFile lcr = made.lcr(), frame = made.frame();
    lcr.shift(zero_s);
    frame.shift(zero_s);
    const RunData data = played(lcr, frame);
    EXPECT_EQ(data.readings.size(), lcr.rows.size());
    expect_pairs(made, data);
    std::vector<double> forces;
    for (const RunReading& r : data.readings) forces.push_back(r.force_N);
    if (first.empty()) first = forces;
    EXPECT_EQ(forces, first) << "to the last digit";
  }
}

TEST_F(ReplayAxis, HasNoHysteresisWhereNoneWasRecorded) {
  for (const double window_s : {0.065, 0.120, 0.2}) {
    for (const bool of_middle : {false, true}) {
      if (!of_middle && window_s != 0.065) continue;  // an arrival means the window of the protocol
      SCOPED_TRACE(fmt::format("window {} s, {}", window_s, of_middle ? "middle" : "arrival"));
      MadeRecording made = steep();
      made.window_s = window_s;
      const RunData data = played(made.lcr(of_middle), made.frame());
      expect_pairs(made, data);
      const auto analysis = analyse(data).value();
      EXPECT_FALSE(analysis.hysteresis.resolved);
      ASSERT_TRUE(analysis.hysteresis.largest_gap);
      EXPECT_LT(analysis.hysteresis.largest_gap.value(), 1.5);
      EXPECT_THAT(analysis.notes,
                  Contains(HasSubstr(of_middle ? "the middle of its window" : "its arrival")));
    }
  }
}

// The same file with the other meaning is another recording. The test would not see a hysteresis
// that no shift of half a window makes.
TEST_F(ReplayAxis, AnotherMeaningOfTheTimesIsSeen) {
  const MadeRecording made = steep();
  MadeFile lcr = made.lcr(true);
  lcr.header = made.lcr().header;
  const auto analysis = analyse(played(lcr, made.frame())).value();
  ASSERT_TRUE(analysis.hysteresis.largest_gap);
  // Both branches move apart by half a window, less the poll of 10 ms that finds a reading late.
  const double apart_s = made.window_s / 2 - 0.01;
  EXPECT_GT(analysis.hysteresis.largest_gap.value(), 2 * apart_s / made.branch_s * 100);
}

TEST_F(ReplayAxis, AShiftOfOneFileShiftsItsValues) {
  const MadeRecording made = steep();
  for (const double shift_s : {1.5, 15.0, -15.0}) {
    SCOPED_TRACE(shift_s);
    const MadeFile lcr = made.lcr();
    MadeFile frame = made.frame();
    frame.shift(shift_s);
    const RunData data = played(lcr, frame);
    // Half a second of one file without the other is played, and the rest of it is not.
    const auto first = std::ranges::find_if(
        lcr.rows, [shift_s](const MadeFile::Row& row) { return row.t_s >= shift_s - 0.5; });
    const auto skipped = first - lcr.rows.begin();
    int compared = 0;
    for (std::size_t i = 0; i < data.readings.size(); ++i) {
      const RunReading& r = data.readings[i];
      if (!r.has_force()) continue;
      const double middle_s = first[static_cast<std::ptrdiff_t>(i)].t_s - made.window_s / 2;
      const double truth_N = made.force_N(middle_s - shift_s);
      EXPECT_NEAR(r.force_N, truth_N, made.peak_N / made.branch_s * 0.012 + 0.01) << middle_s;
      ++compared;
    }
    EXPECT_GT(compared, 200);
    const auto analysis = analyse(data).value();
    if (std::abs(shift_s) > 2) {
      EXPECT_THAT(analysis.notes, Contains(HasSubstr("not played")));
    }
    EXPECT_EQ(skipped > 0, shift_s > 1);
  }
}

}  // namespace
}  // namespace lcrig
