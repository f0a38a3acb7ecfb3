// SPDX-License-Identifier: Apache-2.0
#include "analysis/device_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tests/support/temp_dir.hpp"

namespace lcrig {
namespace {

constexpr double kPeriod_s = 0.02;
constexpr int kBatch = 5;

// Samples as a frame takes and sends them: in batches of five that travel for 1 to 9 ms.
class DeviceClocks : public testing::Test {
 protected:
  void SetUp() override {
    db_ = open_read_write(dir_.file("c.db")).value();
    static_cast<void>(db_.execute("PRAGMA synchronous = OFF"));
    run_ = insert_run(db_, RunRow()).value();
    static_cast<void>(db_.execute("BEGIN"));
    insert_ = db_.prepare("INSERT INTO frame_sample VALUES (?, ?, ?, ?, ?, 0, 0, 0)").value();
  }
  // `device_s` tells what the device's clock shows at an instant of the run's clock.
  template <class DeviceTime>
  void record(double duration_s, DeviceTime device_s) {
    std::uniform_real_distribution<double> way(0.001, 0.009);
    const auto count = static_cast<std::int64_t>(duration_s / kPeriod_s / kBatch) * kBatch;
    double arrival_s = 0;
    for (std::int64_t i = 0; i < count; ++i) {
      const double taken_s = 100 + static_cast<double>(i) * kPeriod_s;
      const double sent_s = 100 + static_cast<double>(i / kBatch * kBatch + kBatch - 1) * kPeriod_s;
      if (i % kBatch == 0) arrival_s = sent_s + way(random_);
      const std::optional<double> shown = device_s(taken_s);
      insert_.bind(0, run_);
      insert_.bind(1, i + 1);
      insert_.bind(2, std::int64_t{std::llround(arrival_s * 1e9)});
      insert_.bind(3, i);
      if (shown) {
        insert_.bind(4, *shown);
      } else {
        insert_.bind_null(4);
      }
      EXPECT_TRUE(insert_.run());
      taken_.push_back({taken_s, arrival_s, shown});
    }
    clock_ = DeviceClock::fit(db_, run_).value();
  }
  struct Taken {
    double taken_s, arrival_s;
    std::optional<double> shown_s;
  };
  DeviceClock::Time time_of(const Taken& t) const {
    return clock_.at(std::llround(t.arrival_s * 1e9), t.shown_s);
  }
  double error_s(const Taken& t) const {
    return static_cast<double>(time_of(t).t_ns) * 1e-9 - t.taken_s;
  }
  // Largest error of the samples whose time is not that of arrival, and the number of the others.
  double worst_s() const {
    double worst = 0;
    for (const Taken& t : taken_) worst = std::max(worst, std::abs(error_s(t)));
    return worst;
  }
  std::size_t of_arrival() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(taken_, [this](const Taken& t) { return time_of(t).of_arrival; }));
  }

  TempDir dir_;
  Database db_;
  Statement insert_;
  std::int64_t run_ = 0;
  std::mt19937_64 random_{7};
  std::vector<Taken> taken_;
  DeviceClock clock_;
};

TEST_F(DeviceClocks, SamplesOfABatchGetTheTimesAtWhichTheyWereTaken) {
  record(3000, [](double t) { return 5e5 + t * (1 - 80e-6); });
  EXPECT_EQ(of_arrival(), 0U);
  // The shortest delay of 1 ms cannot be distinguished from an offset. With times of arrival the
  // error would be 89 ms.
  EXPECT_LT(worst_s(), 0.0015);
  ASSERT_GE(clock_.pieces().size(), 4U);
  for (const auto& p : clock_.pieces()) {
    EXPECT_NEAR(p.rate * 1e6, 80, 3);
    EXPECT_LT(p.residual_s, 0.001);
    EXPECT_GT(p.residual_s, 0);
  }
}

TEST_F(DeviceClocks, ACrystalThatDriftsIsFollowed) {
  record(4000, [](double t) { return t * (1 + 20e-6) + 0.5e-8 * t * t; });  // 40 ppm on the way
  EXPECT_LT(worst_s(), 0.002);
}

TEST_F(DeviceClocks, WithoutAClockTimesAreThoseOfArrival) {
  record(60, [](double) { return std::optional<double>(); });
  EXPECT_EQ(of_arrival(), taken_.size());
  EXPECT_GT(worst_s(), 0.08);
}

TEST_F(DeviceClocks, AfterAJumpTheOffsetIsFittedAnew) {
  record(120, [](double t) { return t < 150 ? t : t + 3600; });
  for (const Taken& t : taken_) {
    if (std::abs(t.taken_s - 150) < 6) continue;  // the stretch with the jump
    EXPECT_LT(std::abs(error_s(t)), 0.002) << t.taken_s;
  }
  EXPECT_LT(worst_s(), 0.1) << "none is further off than by its arrival";
}

TEST_F(DeviceClocks, AClockThatStandsOrRunsWrongIsNotBelieved) {
  record(60, [](double t) { return std::min(t, 125.0); });
  EXPECT_LT(worst_s(), 0.6) << "where it begins to stand";
  for (const Taken& t : taken_) {
    if (t.taken_s <= 132) continue;
    EXPECT_TRUE(time_of(t).of_arrival) << t.taken_s;
  }
}

TEST_F(DeviceClocks, AWrongRateIsNotBelieved) {
  record(60, [](double t) { return 1.3 * t; });
  EXPECT_EQ(of_arrival(), taken_.size());
}

}  // namespace
}  // namespace lcrig
