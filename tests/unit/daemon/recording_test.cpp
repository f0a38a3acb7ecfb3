// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/rehearse.hpp"
#include "protocols/plan/check.hpp"

namespace lcrig {
namespace {

using ::testing::HasSubstr;

class RecordingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ =
        std::filesystem::temp_directory_path() / ("lcrig-recording-" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
    write("frame.csv", "t_s,press,travel_mm,force_N\n0.0,1,2.5,0.125\n0.1,1,3.0,0.25\n");
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  void write(const char* name, const char* text) const { std::ofstream(directory_ / name) << text; }
  std::filesystem::path directory_;
};

TEST_F(RecordingTest, ColumnsAreFoundByName) {
  write("lcr.csv", "t_s,Rp_ohm,Cp_F\r\n0.05,1.00000e+20,1.84249e-12\r\n");
  const auto r = load_recording(directory_);
  ASSERT_TRUE(r) << r.error().what;
  EXPECT_EQ(r->readings[0].primary, 1.84249e-12);
  EXPECT_EQ(r->readings[0].secondary, 1e20);
  EXPECT_DOUBLE_EQ(r->samples[1].travel_m, 3e-3);
  EXPECT_EQ(r->duration_s(), 0.1);
}

TEST_F(RecordingTest, AWrongCellIsNamedWithItsLine) {
  write("lcr.csv", "t_s,Rp_ohm,Cp_F\n0,1,2\n1,x,2\n");
  const auto r = load_recording(directory_);
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().what, HasSubstr("lcr.csv:3"));
  EXPECT_THAT(r.error().what, HasSubstr("Rp_ohm"));
}

TEST_F(RecordingTest, TimeThatRunsBackwardsIsRefused) {
  write("lcr.csv", "t_s,Rp_ohm,Cp_F\n1,1,2\n0,1,2\n");
  EXPECT_FALSE(load_recording(directory_));
}

TEST_F(RecordingTest, AMissingFileSaysWhatIsNeeded) {
  const auto r = load_recording(directory_);
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().what, HasSubstr("frame.csv"));
}

TEST_F(RecordingTest, APlanIsMadeForWhatARecordingCanDo) {
  BenchRequest request;
  request.bench = "replay:" + directory_.string();
  const auto incomplete = bench_rig(request);
  ASSERT_FALSE(incomplete);
  EXPECT_THAT(incomplete.error().what, HasSubstr("lcr.csv"));
  write("lcr.csv", "t_s,Rp_ohm,Cp_F\n0,1,2\n1,1,2\n");
  const auto rig = bench_rig(request);
  ASSERT_TRUE(rig) << rig.error().what;
  EXPECT_FALSE(rig->frame.motion);
  EXPECT_FALSE(rig->noise) << "only a bench file states it";
}

}  // namespace
}  // namespace lcrig
