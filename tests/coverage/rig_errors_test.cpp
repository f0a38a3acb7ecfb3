// SPDX-License-Identifier: Apache-2.0
// What an uncertainty leaves out. In each world one error of the rig stands alone: the test draws
// it, and so knows the truth that an expanded interval has to hold. Without the part of this error
// the same interval must miss the truth often, or the world would prove nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include "tests/unit/analysis/disturbed_run.hpp"
#include "tests/unit/analysis/stated_rig.hpp"

namespace lcrig {
namespace {

// Of DisturbedRun: 4000 fF, 7.5 fF/kPa up to 84 kPa under 1e-5 m2.
constexpr double kC0_pF = 4, kSlope = 7.5, kTop_kPa = 84, kArea_m2 = 1e-5;
constexpr double kRange_percent = kSlope * kTop_kPa / (kC0_pF * 1e3) * 100;
constexpr double kSlope_fF_N = kSlope * 1e-3 / kArea_m2;

double truth_of(UncertainResult result) {
  switch (result) {
    case UncertainResult::sensitivity: return kSlope;
    case UncertainResult::c0: return kC0_pF;
    case UncertainResult::delta_C: return kSlope * kTop_kPa;
    case UncertainResult::dynamic_range: return kRange_percent;
    case UncertainResult::force_sensitivity: return kSlope_fF_N;
    case UncertainResult::hysteresis: return 0;
  }
  return 0;
}

using DrawWithin = std::function<double(double limit)>;
using Results = std::vector<UncertainResult>;

struct ErrorWorld {
  const char* name;
  const char* part;  // name of the part, or its beginning
  Results results;  // that the error moves
  // States the rig, draws the error within its limits, and applies it to the readings.
  std::function<void(StatedRig&, RunData&, const DrawWithin&)> disturb;
};

void scale_load(RunData& data, double true_over_shown) {
  for (RunReading& r : data.readings) {
    const double load_F = r.capacitance_F - kC0_pF * 1e-12;
    r.capacitance_F = kC0_pF * 1e-12 + load_F * true_over_shown;
  }
}
void scale_all(RunData& data, double factor) {
  for (RunReading& r : data.readings) r.capacitance_F *= factor;
}
void shift_all(RunData& data, double offset_F) {
  for (RunReading& r : data.readings) r.capacitance_F += offset_F;
}

const std::vector<ErrorWorld>& worlds() {
  // lint: table
  using enum UncertainResult;
  static const std::vector<ErrorWorld> all{
      {"open correction off, stray capacitance stated",
       "open correction",
       {c0, dynamic_range},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         rig.corrections.open.on = false;
         rig.corrections.stray_limit_F = 40e-15;
         shift_all(data, std::abs(within(40e-15)));  // it only adds
       }},
      {"class 3 as the run recorded it",
       "force",
       {sensitivity, delta_C, dynamic_range, force_sensitivity},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         rig.options.rig.force_class_percent.reset();
         data.force_class_percent = 3;
         scale_load(data, 1 / (1 + within(0.03)));
       }},
      {"class 0.5 as a person stated it",
       "force",
       {sensitivity, delta_C, dynamic_range, force_sensitivity},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         data.force_class_percent = 3;
         rig.options.rig.force_class_percent = 0.5;
         scale_load(data, 1 / (1 + within(0.005)));
       }},
      {"diameter of the probe",
       "area of the probe",
       {sensitivity, delta_C, dynamic_range},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         rig.options.rig.probe_diameter_tolerance_mm = 0.05;
         const double diameter_mm = *data.probe_diameter_m * 1e3;
         const double true_mm = diameter_mm + within(0.05);
         scale_load(data, diameter_mm * diameter_mm / (true_mm * true_mm));
       }},
      // lcr-6100.md 4.1: A is 0.1 % for FAST, and 2.5 times that at 0.1 V.
      {"gain of the meter",
       "meter",
       {sensitivity, delta_C, force_sensitivity, c0},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         rig.setting.aperture = Aperture::fast;
         rig.setting.level_V = 0.1;
         scale_all(data, 1 + within(0.0025));
       }},
      // The same at 30 degrees Celsius: Kc is 2.
      {"temperature of the meter",
       "meter",
       {sensitivity, delta_C, force_sensitivity, c0},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         rig.setting.aperture = Aperture::fast;
         rig.setting.level_V = 0.1;
         rig.options.rig.meter.temperature_C = 30;
         scale_all(data, 1 + within(0.005));
       }},
      // At 1 kHz, 1 V, SLOW: Kb of 4 pF is 4.27 %, about 0.17 pF whatever the value (4.3).
      {"offset of the meter",
       "meter",
       {c0, dynamic_range},
       [](StatedRig& rig, RunData& data, const DrawWithin& within) {
         rig.setting.frequency_Hz = 1000;
         shift_all(data, within(0.169e-12));
       }}};
  return all;
}

bool holds_truth(const Uncertainty& u) {
  return std::abs(u.value - truth_of(u.result)) <= u.expanded;
}

Uncertainty without(Uncertainty u, const std::string& name) {
  std::erase_if(u.parts, [&](const UncertaintyPart& p) { return p.name.starts_with(name); });
  combine(u, u.confidence);
  return u;
}

struct HeldTruth {
  int of = 0, with = 0, without = 0;
  double share(int n) const { return static_cast<double>(n) / of; }
};

std::map<UncertainResult, HeldTruth> held_in(const ErrorWorld& world, int draws) {
  std::map<UncertainResult, HeldTruth> out;
  for (int i = 0; i < draws; ++i) {
    std::mt19937_64 random(static_cast<std::uint64_t>(i) + 77'000);
    Disturbed quiet;
    quiet.white = 0.02;
    quiet.force_noise_N = 1e-6;
    RunData data = DisturbedRun(quiet, random()).data;
    StatedRig rig;
    world.disturb(rig, data, [&random](double limit) {
      return std::uniform_real_distribution<double>(-limit, limit)(random);
    });
    for (const Uncertainty& u : analysis_of(rig, std::move(data)).uncertainties) {
      if (std::ranges::find(world.results, u.result) == world.results.end()) continue;
      HeldTruth& held = out[u.result];
      ++held.of;
      held.with += holds_truth(u) ? 1 : 0;
      held.without += holds_truth(without(u, world.part)) ? 1 : 0;
    }
  }
  return out;
}

TEST(RigParts, ExpandedIntervalsHoldTheTruthWhereOneErrorDominates) {
  constexpr int kDraws = 200;
  for (const ErrorWorld& world : worlds()) {
    const auto held = held_in(world, kDraws);
    ASSERT_EQ(held.size(), world.results.size()) << world.name;
    for (const auto& [result, h] : held) {
      SCOPED_TRACE(fmt::format("{}, result {}", world.name, static_cast<int>(result)));
      EXPECT_GE(h.of, kDraws);
      EXPECT_GE(h.share(h.with), 0.93);
      EXPECT_LT(h.share(h.without), 0.6) << "the world would not notice a missing part";
    }
  }
}

}  // namespace
}  // namespace lcrig
