// SPDX-License-Identifier: Apache-2.0
#include "model/level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

StackState at(const Specimen& s, const LevelSettings& settings, double pressure_kPa) {
  auto model = make_level_model(s, settings);
  EXPECT_TRUE(model) << (model ? "" : model.error().what);
  auto state = (*model)->at_pressure(pressure_kPa * 1.0_kPa);
  EXPECT_TRUE(state) << (state ? "" : state.error().what);
  return state.value_or(StackState{});
}

LevelSettings linear() {
  LevelSettings settings;
  settings.level = Level::linear;
  return settings;
}

TEST(Specimen, PaperCapacitances) {
  expect_relative(shipped("paper-1").c0_F(), 3.64570443699941e-12, 1e-14);
  expect_relative(shipped("paper-2").c0_F(), 7.29140887399881e-12, 1e-14);
  expect_relative(shipped("paper-3").c0_F(), 10.9371133109982e-12, 1e-14);
}

TEST(Specimen, CapacitancesOfEveryStack) {
  LCRIG_NEED_REFERENCE(rows, "r1_c0.csv");
  for (const auto& row : rows) {
    Specimen s = shipped("paper-1");
    s.capacitors.assign(static_cast<std::size_t>(row.number(0)), s.capacitors.front());
    expect_relative(s.c0_F(), row.number(1) * 1e-12, 1e-13, row[0]);
  }
}

TEST(Linear, FollowsEquationNineAndTheSeriesForm) {
  LCRIG_NEED_REFERENCE(rows, "r1_eq9.csv");
  for (const auto& row : rows) {
    if (row.number(0) >= 200 || row[3].empty()) continue;
    const double p = row.number(0);
    const double conditioned = 1e-13 + 1e-15 * 200 / (200 - p);
    if (!row[2].empty()) {
      expect_relative(at(soft_stack({100e-6}), linear(), p).delta_capacitance_F,
                      row.number(2) * 1e-15, conditioned, row[0]);
    }
    expect_relative(at(shipped("paper-1"), linear(), p).delta_capacitance_F, row.number(3) * 1e-15,
                    1e-13, row[0]);
  }
}

TEST(Linear, ChangeKeepsAllDigitsAtTinyPressure) {
  const double eps = std::numeric_limits<double>::epsilon();
  const Specimen s = shipped("paper-1");
  const double k = 14.0 / 47;
  for (double p = 1e-12; p < 200; p *= 7) {
    const double e = p / 200;
    expect_relative(at(s, linear(), p).delta_capacitance_F, s.c0_F() * k * e / (1 - k * e), 4 * eps,
                    std::to_string(p));
  }
}

TEST(Linear, ReferenceChangeAtTinyPressure) {
  LCRIG_NEED_REFERENCE(rows, "r6_cancellation.csv");
  for (const auto& row : rows) {
    expect_relative(at(shipped("paper-1"), linear(), row.number(0)).delta_capacitance_F,
                    row.number(1) * 1e-15, 1e-14, row[0]);
  }
}

TEST(Linear, ClosedLayerIsAnErrorThatSaysSo) {
  auto model = make_level_model(shipped("paper-1"), linear());
  ASSERT_TRUE(model);
  EXPECT_TRUE((*model)->at_pressure(199.99_kPa));
  for (const auto p : {200.0_kPa, 1000.0_kPa}) {
    const auto state = (*model)->at_pressure(p);
    ASSERT_FALSE(state);
    EXPECT_EQ(state.error().code, Errc::invalid_request);
    EXPECT_THAT(state.error().what, testing::HasSubstr("not below Young's modulus"));
  }
}

TEST(Linear, PartitionsOfTheReference) {
  LCRIG_NEED_REFERENCE(rows, "r1_optimal_partition.csv");
  for (const auto& row : rows) {
    const auto n = static_cast<std::size_t>(row.number(0));
    const std::vector<double> equal(n, 1e-3 / static_cast<double>(n));
    std::vector<double> optimal(n, 0.1e-3);
    optimal.back() = 1e-3 - 0.1e-3 * static_cast<double>(n - 1);
    expect_relative(soft_stack(equal).c0_F(), row.number(3) * 1e-12, 1e-12, row[0]);
    expect_relative(soft_stack(optimal).c0_F(), row.number(4) * 1e-12, 1e-12, row[0]);
    const double p = 1e-9;
    expect_relative(at(soft_stack(equal), linear(), p).delta_capacitance_F / p,
                    row.number(5) * 1e-15, 1e-11, row[0]);
    expect_relative(at(soft_stack(optimal), linear(), p).delta_capacitance_F / p,
                    row.number(6) * 1e-15, 1e-11, row[0]);
  }
}

TEST(Hyperelastic, ChangeFollowsTheReferenceTable) {
  LCRIG_NEED_REFERENCE(rows, "r2_hyperelastic_1d.csv");
  for (const auto& row : rows) {
    LevelSettings settings;
    settings.form = parse_word<EnergyForm>(row[0]).value();
    settings.lateral = row[1] == "confined" ? Lateral::confined : Lateral::free;
    settings.pressure_kind = parse_word<PressureKind>(row[2]).value_or(PressureKind::dead);
    expect_relative(at(shipped("paper-1"), settings, row.number(3)).delta_capacitance_F,
                    row.number(8) * 1e-15, 2e-13, row[0] + row[1] + row[2] + " " + row[3]);
  }
}

TEST(Hyperelastic, StacksOfTheReference) {
  LCRIG_NEED_REFERENCE(rows, "t5_nstack_1d.csv");
  for (const auto& row : rows) {
    Specimen s = shipped("paper-1");
    s.capacitors.assign(static_cast<std::size_t>(row.number(0)), s.capacitors.front());
    LevelSettings settings;
    settings.form = parse_word<EnergyForm>(row[1]).value();
    settings.lateral = row[2] == "confined" ? Lateral::confined : Lateral::free;
    settings.pressure_kind = parse_word<PressureKind>(row[3]).value_or(PressureKind::dead);
    const auto state = at(s, settings, row.number(4));
    expect_relative(s.c0_F() + state.delta_capacitance_F, row.number(5) * 1e-12, 1e-12,
                    row[0] + row[1] + row[2] + row[3] + " " + row[4]);
    EXPECT_EQ(state.capacitor_delta_F.size(), s.capacitors.size());
  }
}

TEST(Hyperelastic, PinnedAtHundredKilopascal) {
  LevelSettings settings;
  Specimen s = shipped("paper-1");
  s.capacitors.assign(5, s.capacitors.front());
  EXPECT_NEAR(s.c0_F() + at(s, settings, 100).delta_capacitance_F, 20.855e-12, 0.5e-15);
  settings.pressure_kind = PressureKind::true_area;
  EXPECT_NEAR(s.c0_F() + at(s, settings, 100).delta_capacitance_F, 22.247e-12, 0.5e-15);
}

TEST(LevelModel, RefusesPressureThatIsNone) {
  for (const auto level : {Level::linear, Level::hyperelastic}) {
    LevelSettings settings;
    settings.level = level;
    auto model = make_level_model(shipped("paper-1"), settings);
    ASSERT_TRUE(model);
    EXPECT_FALSE((*model)->at_pressure(-(1.0_kPa)));
    EXPECT_FALSE((*model)->at_pressure(Pressure::from_si(std::nan(""))));
    EXPECT_EQ((*model)->at_pressure(0.0_kPa)->delta_capacitance_F, 0);
  }
}

TEST(LevelModel, RefusesASpecimenThatIsNone) {
  Specimen s = shipped("paper-1");
  s.capacitors.clear();
  EXPECT_FALSE(make_level_model(s, linear()));
  s = shipped("paper-1");
  s.capacitors[0].layers[0].thickness_m = 0;
  EXPECT_FALSE(make_level_model(s, linear()));
  s.capacitors[0].layers[0].thickness_m = std::nan("");
  EXPECT_FALSE(make_level_model(s, linear()));
}

}  // namespace
}  // namespace lcrig
