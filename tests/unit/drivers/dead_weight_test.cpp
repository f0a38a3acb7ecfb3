// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/dead_weight/driver.hpp"
#include "drivers/dead_weight/sim.hpp"
#include "tests/support/frame_bench.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

struct WeightBench {
  explicit WeightBench(DeadWeightSettings settings = DeadWeightSettings()) {
    person.set_act([this](const std::string& prompt) {
      prompts.push_back(prompt);
      loads.push_back(frame->pending_force());
    });
    frame = std::make_unique<DeadWeightFrame>(person, clock, io.get_executor(), settings);
    frame->set_listener(&listener);
  }
  ~WeightBench() {
    frame->close();
    clock.run_for(io, 1s);
  }
  template <class T>
  T run(Task<T> task) {
    return run_task(io, clock, std::move(task));
  }
  void armed() {
    FrameLimits limits;
    limits.force_min = -0.1_N;
    limits.force_max = 2.0_N;
    if (!run(frame->identify()) || !run(frame->arm(limits))) throw std::runtime_error("no arm");
  }

  VirtualClock clock;
  asio::io_context io;
  SimOperator person{clock, 20s};
  MemoryListener listener;
  std::vector<std::string> prompts;
  std::vector<Force> loads;
  std::unique_ptr<DeadWeightFrame> frame;
};

PressureArea under_probe(std::optional<double> disc_m = {}) {
  PressureArea out;
  out.probe_diameter_m = 4e-3;
  out.disc_diameter_m = disc_m;
  return out;
}

DeadWeightSettings with_rod() {
  DeadWeightSettings s;
  s.rod = Mass::from_si(0.020);
  return s;
}

TEST(DeadWeight, AsksForTheStepAndNamesTotalForceAndPressure) {
  WeightBench b(with_rod());
  b.armed();
  b.frame->show_pressure(under_probe(4e-3));
  const auto placed = b.run(b.frame->place_mass(Mass::from_si(0.1)));
  ASSERT_TRUE(placed) << placed.error().what;
  EXPECT_EQ(placed->reason, MotionEnd::target);
  EXPECT_DOUBLE_EQ(placed->force_N.value(), 0.12 * 9.80665);
  ASSERT_TRUE(b.run(b.frame->place_mass(Mass::from_si(0.15))));
  ASSERT_TRUE(b.run(b.frame->place_mass(Mass::from_si(0.05))));
  ASSERT_TRUE(b.run(b.frame->place_mass(Mass())));
  EXPECT_EQ(
      b.prompts,
      (std::vector<std::string>{
          "Place 100 g on the rod (total 120 g = 1.177 N = 93.65 kPa over the probe)",
          "Place 50 g on the rod (total 170 g = 1.667 N = 132.7 kPa over the probe)",
          "Take 100 g off the rod (total 70 g = 0.6865 N = 54.63 kPa over the probe)",
          "Remove all weights from the rod (total 20 g = 0.1961 N = 15.61 kPa over the probe)"}));
  EXPECT_DOUBLE_EQ(b.loads[1].si(), 0.17 * 9.80665);
}

TEST(DeadWeight, SaysWhatAnotherDiscThanTheProbeGets) {
  WeightBench b(with_rod());
  b.armed();
  for (const double disc_m : {2e-3, 8e-3}) {
    b.frame->show_pressure(under_probe(disc_m));
    ASSERT_TRUE(b.run(b.frame->place_mass(Mass::from_si(disc_m))));
  }
  EXPECT_EQ(
      b.prompts,
      (std::vector<std::string>{
          "Place 2 g on the rod (total 22 g = 0.2157 N = 17.17 kPa over the probe = 68.67 kPa "
          "on the disc of 2 mm)",
          "Place 6 g on the rod (total 28 g = 0.2746 N = 21.85 kPa over the probe, which "
          "presses only a part of the disc of 8 mm)"}));
}

TEST(DeadWeight, LocalGravityCounts) {
  DeadWeightSettings s;
  s.g_m_s2 = 9.78;
  WeightBench b(s);
  b.armed();
  EXPECT_DOUBLE_EQ(b.run(b.frame->place_mass(Mass::from_si(0.1)))->force_N.value(), 0.978);
}

TEST(DeadWeight, SamplesComeAtEveryChangeAndAtTheRate) {
  WeightBench b;
  b.armed();
  b.clock.run_for(b.io, 10s);
  EXPECT_NEAR(static_cast<double>(b.listener.samples.size()), 10, 1);
  ASSERT_TRUE(b.run(b.frame->place_mass(Mass::from_si(0.1))));
  EXPECT_EQ(b.listener.samples.back().force_N, 0.1 * 9.80665);
  EXPECT_EQ(b.listener.samples.back().received, b.clock.now());
  for (std::size_t i = 0; i < b.listener.samples.size(); ++i) {
    ASSERT_EQ(b.listener.samples[i].device_seq, static_cast<std::int64_t>(i) + 1);
  }
  ASSERT_TRUE(b.run(b.frame->set_sample_rate(0)));
  const auto before = b.listener.samples.size();
  b.clock.run_for(b.io, 10s);
  EXPECT_LE(b.listener.samples.size(), before + 1);
  EXPECT_FALSE(b.run(b.frame->set_sample_rate(1000)));
}

TEST(DeadWeight, StopEndsAPromptAtOnceAndChangesNothing) {
  WeightBench b;
  b.armed();
  support::Outcome<Result<MotionOutcome>> out;
  support::spawn(b.io, b.frame->place_mass(Mass::from_si(0.1)), out);
  b.clock.run_for(b.io, 5s);
  EXPECT_FALSE(out.done);
  EXPECT_FALSE(b.run(b.frame->place_mass(Mass::from_si(0.2)))) << "one prompt at a time";
  const MonoTime begin = b.clock.now();
  ASSERT_TRUE(b.run(b.frame->stop()));
  b.clock.run(b.io, [&] { return out.done; });
  EXPECT_EQ(b.clock.now(), begin);
  EXPECT_EQ((*out.value)->reason, MotionEnd::stopped);
  EXPECT_TRUE(b.prompts.empty());
  EXPECT_EQ(b.frame->force(), Force());
  EXPECT_TRUE(b.run(b.frame->place_mass(Mass::from_si(0.1)))) << "an old stop ends no new prompt";
}

TEST(DeadWeight, RefusesWhatItCannotOrMustNotDo) {
  WeightBench b;
  ASSERT_TRUE(b.run(b.frame->identify()));
  EXPECT_EQ(b.run(b.frame->place_mass(Mass::from_si(0.1))).error().code, Errc::refused);
  b.armed();
  EXPECT_EQ(b.run(b.frame->place_mass(Mass::from_si(0.3))).error().code, Errc::limit_tripped);
  EXPECT_EQ(b.run(b.frame->place_mass(Mass::from_si(-0.1))).error().code, Errc::invalid_request);
  EXPECT_EQ(b.run(b.frame->move_to(1.0_mm, 1.0_mm_s)).error().code, Errc::refused);
  EXPECT_EQ(b.run(b.frame->ramp_force(1.0_N, 1.0_N_s)).error().code, Errc::refused);
  EXPECT_FALSE(b.run(b.frame->zero(true, false)));
  EXPECT_TRUE(b.prompts.empty());
}

TEST(DeadWeight, CloseLeavesNoWaiter) {
  WeightBench b;
  b.armed();
  support::Outcome<Result<MotionOutcome>> out;
  support::spawn(b.io, b.frame->place_mass(Mass::from_si(0.1)), out);
  b.clock.run_for(b.io, 5s);
  b.frame->close();
  b.clock.run_for(b.io, 1ms);
  ASSERT_TRUE(out.done);
  EXPECT_EQ(out.value->error().code, Errc::disconnected);
  EXPECT_EQ(b.clock.pending(), 0U);
}

}  // namespace
}  // namespace lcrig
