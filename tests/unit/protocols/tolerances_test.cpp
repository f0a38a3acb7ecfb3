// SPDX-License-Identifier: Apache-2.0
// Each tolerance against its formula, in round numbers.
#include "protocols/rig/tolerances.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "protocols/rig/cell_noise.hpp"
#include "tests/support/watched_frame.hpp"

namespace lcrig {
namespace {

using namespace std::chrono_literals;

constexpr double kLimit_N = 2, kRate_Hz = 50;

// Forces of these steps of 0.1 mN about zero, at a travel that waits at 1 mm with this amplitude.
CellNoise noise_of(std::initializer_list<int> steps, double travel_m = 0) {
  RestMeasurement rest;
  MonoTime t = MonoTime() + 1s;
  int i = 0;
  for (int round = 0; round < 10; ++round) {
    for (const int step : steps) {
      FrameSample s;
      s.received = t += 20ms;
      s.force_N = 1e-4 * step;
      s.travel_m = 1e-3 + travel_m * (++i % 3 - 1);
      rest.add(std::span(&s, 1));
    }
  }
  return CellNoise(rest);
}

Tolerances tolerances(double stiffness_N_m, const std::optional<CellNoise>& noise,
                      double noise_N = 1e-3, FrameCapabilities caps = watched_capabilities()) {
  return tolerances_of(caps, ForceBound({}, stiffness_N_m), kLimit_N, kRate_Hz,
                       noise ? &*noise : nullptr, noise_N);
}

TEST(Tolerances, OfATravelAreHuntingNoiseAndItsStep) {
  const Tolerances quiet = tolerances(1e3, std::nullopt);
  EXPECT_DOUBLE_EQ(quiet.against_m, 3e-6);
  EXPECT_DOUBLE_EQ(quiet.standing_m, 10e-6) << "a soft contact bears more, and 10 um are standing";
  EXPECT_DOUBLE_EQ(quiet.order_travel_m, 10e-6);
  EXPECT_NEAR(tolerances(40e3, std::nullopt).standing_m, 0.1 * kLimit_N / 40e3, 1e-12);
  EXPECT_DOUBLE_EQ(tolerances(1e6, std::nullopt).standing_m, 3e-6) << "a stiff one bears less";
  const CellNoise noise = noise_of({-2, 1, 3, -1, 0, 2}, 1e-6);
  const double wanders_m = 10 * noise.travel_noise_m.value();
  ASSERT_GT(wanders_m, 5e-6);
  const Tolerances noisy = tolerances(1e6, noise);
  EXPECT_NEAR(noisy.against_m, 3e-6 + wanders_m, 1e-12);
  EXPECT_NEAR(noisy.standing_m, 3e-6 + wanders_m, 1e-12);
  EXPECT_NEAR(noisy.order_travel_m, 10e-6 + wanders_m, 1e-12);
  FrameCapabilities coarse = watched_capabilities();
  coarse.travel_step = Length::from_si(8e-6);
  const Tolerances stepped = tolerances(1e6, std::nullopt, 1e-3, coarse);
  EXPECT_NEAR(stepped.against_m, 12e-6, 1e-12);
  EXPECT_NEAR(stepped.standing_m, 12e-6, 1e-12);
  coarse.travel_step = Length::from_si(1e-6);
  const Tolerances both = tolerances(1e6, noise, 1e-3, coarse);
  EXPECT_NEAR(both.against_m, 3e-6 + wanders_m, 1e-12) << "the larger one";
  EXPECT_NEAR(both.standing_m, 3e-6 + wanders_m, 1e-12);
}

TEST(Tolerances, OfAForceAreItsNoiseOrAPartOfTheLimit) {
  EXPECT_DOUBLE_EQ(tolerances(1e3, std::nullopt, 1e-3).contact_force_N, 5e-3);
  EXPECT_DOUBLE_EQ(tolerances(1e3, std::nullopt, 1e-4).order_force_N, 0.01 * kLimit_N);
  EXPECT_NEAR(tolerances(1e3, std::nullopt, 0.01).order_force_N, std::sqrt(2) * 6.25 * 0.01, 1e-6);
  const CellNoise noise = noise_of({-200, 100, 300, -100, 0, 200});
  EXPECT_NEAR(tolerances(1e3, noise, 0).order_force_N, std::sqrt(2) * 6.25 * noise.sure_noise_N(),
              1e-6);
}

TEST(Tolerances, OfTimeFollowTheFrame) {
  FrameCapabilities slow = watched_capabilities();
  slow.reaction = 600ms;
  EXPECT_DOUBLE_EQ(tolerances(1e3, std::nullopt, 1e-3, slow).stall_s, 2.6);
  EXPECT_DOUBLE_EQ(tolerances(1e3, std::nullopt).settled_s, 0.5);
  const auto at = [](double rate_Hz) {
    return tolerances_of(watched_capabilities(), ForceBound({}, 1e3), kLimit_N, rate_Hz, nullptr,
                         1e-3);
  };
  EXPECT_DOUBLE_EQ(at(2).settled_s, 1.5);
  EXPECT_DOUBLE_EQ(at(0).settled_s, 0.5) << "of a frame that sends none";
  EXPECT_DOUBLE_EQ(at(50).frozen_force_s.value(), 0.5) << "25 samples are assumed";
  EXPECT_FALSE(at(0).frozen_force_s);
}

TEST(Tolerances, AFrozenCellRepeatsItselfMoreOftenThanTheRestMeasurementDid) {
  const CellNoise usual = noise_of({-2, 1, 3, -1, 0, 2});
  const std::int64_t samples = tolerances(1e3, usual).frozen_samples.value();
  EXPECT_GE(samples, 5);
  const CellNoise repeats = noise_of({-2, -2, -2, -2, -2, -2, -2, -2, -2, -2, 1, 3, -1, 0, 2});
  ASSERT_EQ(repeats.longest_run, 10);
  EXPECT_GE(tolerances(1e3, repeats).frozen_samples.value(), 40);
  EXPECT_FALSE(tolerances(1e3, noise_of({0, 0, 0, 0, 0, 0, 0, 0, 1})).frozen_samples)
      << "its digits are coarser than its noise";
}

TEST(Tolerances, AreStoredInTheUnitsOfTheirNames) {
  Tolerances t = round_tolerances();
  t.order_travel_m = 7e-6;
  t.travel_noise_m = 2e-6;
  const nlohmann::json json = to_json(t);
  EXPECT_NEAR(json.at("against_mm").get<double>(), 3e-3, 1e-12);
  EXPECT_NEAR(json.at("standing_mm").get<double>(), 5e-3, 1e-12);
  EXPECT_NEAR(json.at("order_travel_mm").get<double>(), 7e-3, 1e-12);
  EXPECT_NEAR(json.at("travel_noise_mm").get<double>(), 2e-3, 1e-12);
  EXPECT_DOUBLE_EQ(json.at("order_force_N").get<double>(), 0.01);
  EXPECT_TRUE(json.at("frozen_force_s").is_null());
}

// A cell in the middle of a digit as coarse as this repeats it with p = erf(0.5 / sqrt(2) / s),
// where s is its noise in digits without what the digit itself adds; fewer than one of 1e12 runs is
// longer.
TEST(Tolerances, ACoarseDigitRepeatsItselfMoreOften) {
  CellNoise noise;
  noise.alive = true;
  noise.noise_N = 1e-3;
  for (const auto& [digits, samples] :
       {std::pair(1.2, 48), {1.5, 76}, {1.79, 136}, {1.81, 0}, {0.5, 17}, {1e-3, 5}, {0.0, 5}}) {
    noise.digit_N = digits * noise.noise_N;
    EXPECT_EQ(tolerances(1e3, noise).frozen_samples.value_or(0), samples) << digits;
  }
  noise.longest_run = 12;
  EXPECT_EQ(tolerances(1e3, noise).frozen_samples.value_or(0), 48);
}

}  // namespace
}  // namespace lcrig
