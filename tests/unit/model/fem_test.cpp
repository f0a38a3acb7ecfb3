// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "balance.hpp"
#include "model/fem_capacitance.hpp"
#include "model/fem_levels.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

LevelSettings at_level(Level level, int refinement = 1) {
  LevelSettings settings;
  settings.level = level;
  settings.mesh.refinement = refinement;
  return settings;
}

double apparent_modulus(double shape_factor, double nu, int refinement) {
  const Specimen s = punch(shape_factor, nu);
  auto model = FemLinear::make(s, at_level(Level::fem_linear, refinement));
  EXPECT_TRUE(model) << (model ? "" : model.error().what);
  expect_balance(s, refinement, "mesh " + std::to_string(refinement));
  const double shortening = (*model)->at_pressure(Pressure::from_si(1e-3))->shortening_m;
  return 1e-3 / (shortening * 2 * shape_factor);
}

TEST(FemLinear, BondedDiscOnTheDefaultMesh) {
  LCRIG_NEED_REFERENCE(rows, "r3_bonded_disc_dolfinx_q4.csv");
  for (const auto& row : rows) {
    expect_relative(apparent_modulus(row.number(0), row.number(1), 1), row.number(4), 1e-4,
                    row[0] + " nu " + row[1]);
  }
}

TEST(FemLinear, BondedDiscOnAFinerMesh) {
  LCRIG_NEED_REFERENCE(rows, "r3_bonded_disc_dolfinx_q4.csv");
  for (const auto& row : rows) {
    if (row.number(0) == 0.5 || row.number(0) == 2 || row.number(0) == 80) {
      expect_relative(apparent_modulus(row.number(0), row.number(1), 2), row.number(4), 1e-5,
                      row[0] + " nu " + row[1]);
    }
  }
}

TEST(FemLinear, NothingLocks) {
  expect_relative(apparent_modulus(2, 0.4999, 1), 8.70688, 1e-4);
  expect_relative(apparent_modulus(10, 0.5, 1), 199.13471, 1e-4);
}

TEST(FemLinear, ThinLayerNearlyIncompressible) {
  LCRIG_NEED_REFERENCE(rows, "r6_thin_layer_24um.csv");
  for (const auto& row : rows) {
    expect_relative(apparent_modulus(row.number(0), row.number(1), 1), row.number(3), 1e-4,
                    "nu " + row[1]);
  }
}

TEST(FemLinear, ErrorFallsWithTheMesh) {
  const double exact = 5.65009;
  const double coarse = std::abs(apparent_modulus(2, 0.49, 0) - exact);
  const double medium = std::abs(apparent_modulus(2, 0.49, 1) - exact);
  const double fine = std::abs(apparent_modulus(2, 0.49, 2) - exact);
  EXPECT_LT(medium, coarse / 2);
  EXPECT_LT(fine, medium / 2);
}

double slope_fF_kPa(const Specimen& s, int refinement, bool mild_corners = false) {
  LevelSettings settings = at_level(Level::fem_linear, refinement);
  settings.mesh.mild_corners = mild_corners;
  auto model = FemLinear::make(s, settings).value();
  return model->at_pressure(1e-6 * 1.0_kPa)->delta_capacitance_F * 1e15 / 1e-6;
}

TEST(FemLinear, LaminateSlopes) {
  LCRIG_NEED_REFERENCE(rows, "lam_initial_slope.csv");
  for (const auto& row : rows) {
    if (row[0] == "LAM-PK" && row.number(1) <= 5) {
      const double best = std::stod(row[3].substr(row[3].rfind('/') + 1));
      expect_relative(slope_fF_kPa(laminate(static_cast<std::size_t>(row.number(1))), 1), best,
                      5e-5, row[1]);
    }
  }
}

TEST(FemLinear, LaminateSlopePinned) {
  expect_relative(slope_fF_kPa(laminate(1), 1), 0.540921, 5e-5);
}

TEST(FemLinear, SoftBlockSlopes) {
  LCRIG_NEED_REFERENCE(rows, "soft_initial_slope.csv");
  for (const auto& row : rows) {
    const Specimen s = soft_block(static_cast<std::size_t>(row.number(0)));
    const double best = std::stod(row[2].substr(row[2].rfind('/') + 1));
    expect_relative(slope_fF_kPa(s, 1), best, 1e-4, row[0]);
  }
}

TEST(FemLinear, OneFactorizationForEveryPartitionOfTheBlock) {
  LCRIG_NEED_REFERENCE(rows, "t3_linear_block.csv");
  const std::map<std::string, std::vector<double>> partitions{
      {"equal4", std::vector<double>(4, 0.25e-3)},
      {"optimal4", {0.1e-3, 0.1e-3, 0.1e-3, 0.7e-3}},
      {"optimal6", {0.1e-3, 0.1e-3, 0.1e-3, 0.1e-3, 0.1e-3, 0.5e-3}},
      {"equal6", std::vector<double>(6, 1e-3 / 6)}};
  Specimen block = soft_stack({1e-3});
  block.faces = Faces::bonded_base;
  LevelSettings settings = at_level(Level::fem_linear);
  auto reference = FemLinear::make(block, settings).value();
  settings.electrode_area = ElectrodeArea::deformed;
  auto deformed = FemLinear::make(block, settings).value();
  std::map<std::string, double> start;
  for (const auto& row : rows) {
    const auto& cut = partitions.at(row[0]);
    const Pressure p = row.number(1) * 1.0_kPa;
    if (row.number(1) == 0) {
      start[row[0]] = row.number(2);
      continue;
    }
    const double change = reference->at_pressure(p, cut)->delta_capacitance_F * 1e12;
    expect_relative(change, row.number(2) - start[row[0]], 3e-4, row[0] + " " + row[1]);
    const double stretched = deformed->at_pressure(p, cut)->delta_capacitance_F * 1e12;
    expect_relative(stretched, row.number(5) - start[row[0]], 5e-4, row[0] + " " + row[1]);
  }
}

TEST(FemLinear, PartitionMustAddUp) {
  Specimen block = soft_stack({1e-3});
  block.faces = Faces::bonded_base;
  auto model = FemLinear::make(block, at_level(Level::fem_linear)).value();
  EXPECT_FALSE(model->at_pressure(1.0_kPa, {0.5e-3, 0.4e-3}));
  EXPECT_FALSE(model->at_pressure(1.0_kPa, {0.5e-3, -0.5e-3, 1e-3}));
  auto stack = FemLinear::make(laminate(1), at_level(Level::fem_linear)).value();
  EXPECT_FALSE(stack->at_pressure(1.0_kPa, {100e-6}));
}

TEST(FemLinear, FreeFacesAreTheSpringLaw) {
  auto fem = make_level_model(shipped("paper-2"), at_level(Level::fem_linear)).value();
  auto spring = make_level_model(shipped("paper-2"), at_level(Level::linear)).value();
  for (const auto p : {1e-9 * 1.0_kPa, 1.0_kPa, 100.0_kPa}) {
    expect_relative(fem->at_pressure(p)->delta_capacitance_F,
                    spring->at_pressure(p)->delta_capacitance_F, 1e-11);
    expect_relative(fem->at_pressure(p)->shortening_m, spring->at_pressure(p)->shortening_m, 1e-11);
  }
}

TEST(FemLinear, ClosedLayerIsAnError) {
  auto model = make_level_model(shipped("paper-1"), at_level(Level::fem_linear)).value();
  const auto state = model->at_pressure(Pressure::from_si(1e6));
  ASSERT_FALSE(state);
  EXPECT_THAT(state.error().what, testing::HasSubstr("closed"));
}

TEST(FemLinear, RigidPlateIsStifferThanPressure) {
  Specimen s = soft_stack({1e-3});
  s.faces = Faces::bonded_base;
  const double loose = slope_fF_kPa(s, 0);
  s.top = Top::plate;
  const double flat = slope_fF_kPa(s, 0);
  s.top = Top::bonded_plate;
  const double held = slope_fF_kPa(s, 0);
  EXPECT_GT(loose, 0);
  EXPECT_GT(flat, held);
  s.faces = Faces::free;
  EXPECT_FALSE(make_level_model(s, at_level(Level::fem_linear)));
}

TEST(FemLinear, HugeMeshIsRefusedBeforeWorkStarts) {
  LevelSettings settings = at_level(Level::fem_linear);
  settings.mesh.max_unknowns = 1000;
  const auto model = make_level_model(laminate(10), settings);
  ASSERT_FALSE(model);
  EXPECT_THAT(model.error().what, testing::HasSubstr("coarser"));
  EXPECT_FALSE(make_level_model(laminate(1), at_level(Level::fem_linear, 7)));
}

TEST(FemFinite, PatchTestIsExact) {
  for (const auto p : {1e-6 * 1.0_kPa, 10.0_kPa, 100.0_kPa}) {
    auto fem = make_level_model(shipped("paper-2"), at_level(Level::fem_finite)).value();
    auto exact = make_level_model(shipped("paper-2"), at_level(Level::hyperelastic)).value();
    expect_relative(fem->at_pressure(p)->delta_capacitance_F,
                    exact->at_pressure(p)->delta_capacitance_F, 1e-9);
  }
}

TEST(FemFinite, LaminateToHundredKilopascal) {
  auto model = FemFinite::make(laminate(1), at_level(Level::fem_finite)).value();
  expect_relative(model->at_pressure(10.0_kPa)->delta_capacitance_F, 5.378e-15, 3e-4);
  expect_relative(model->at_pressure(100.0_kPa)->delta_capacitance_F, 51.18e-15, 3e-4);
  EXPECT_TRUE(model->stable());
}

TEST(FemFinite, SmallLoadIsTheLinearLimit) {
  auto model = FemFinite::make(laminate(1), at_level(Level::fem_finite)).value();
  const double slope = model->at_pressure(1e-6 * 1.0_kPa)->delta_capacitance_F * 1e15 / 1e-6;
  expect_relative(slope, slope_fF_kPa(laminate(1), 1, true), 1e-6);  // on the same mesh
}

TEST(FemFinite, NewtonConvergesQuadratically) {
  auto model = FemFinite::make(laminate(1), at_level(Level::fem_finite, 0)).value();
  ASSERT_TRUE(model->at_pressure(10.0_kPa));
  const auto& history = model->report().history;
  ASSERT_GE(history.size(), 3U);
  bool squared = false;
  for (std::size_t i = 0; i + 1 < history.size(); ++i) {
    squared = squared || (history[i] < 1e-2 && history[i + 1] < 100 * history[i] * history[i]);
  }
  EXPECT_TRUE(squared) << testing::PrintToString(history);
}

TEST(FemFinite, LostSolutionIsReportedWithTheLastLoad) {
  Specimen s = soft_stack(std::vector<double>(3, 100e-6));
  s.faces = Faces::bonded_base;
  auto model = FemFinite::make(s, at_level(Level::fem_finite, 0)).value();
  const auto state = model->at_pressure(Pressure::from_si(2e6));
  ASSERT_FALSE(state);
  EXPECT_THAT(state.error().what, testing::HasSubstr("no equilibrium found beyond"));
  EXPECT_GT(model->last_converged()->si(), 0);
  EXPECT_LT(model->last_converged()->si(), 2e6);
  EXPECT_TRUE(model->at_pressure(*model->last_converged()));  // what was reached stays
}

TEST(FemFinite, SmoothBenchmark) {
  LCRIG_NEED_REFERENCE(rows, "smooth_neohooke.csv");
  for (const auto& row : rows) {
    if (row[2] != "C pF" || row[6] == "nan") continue;
    Specimen s = soft_stack({1e-3});
    for (Material& m : s.materials) m.poisson_ratio = row.number(0);
    SpaceVariation variation;
    variation.uniform_cells = 16;
    variation.wall = true;
    variation.load = [](double r) { return 0.5 * (1 + std::cos(std::acos(-1.0) * r / 2e-3)); };
    const auto space = StackSpace::make(s, {}, true, variation).value();
    FemSystem system(space);
    FemState state = system.rest();
    for (double part = 0.25; part <= 1; part += 0.25) {
      ASSERT_TRUE(system.solve(part * row.number(1) * 1e3, state).converged);
    }
    const auto change =
        capacitance_changes(space, space.capacitors(), state.u, 1, ElectrodeArea::reference);
    ASSERT_TRUE(change);
    expect_relative((s.c0_F() + change->front()) * 1e12, row.number(6), 1e-6,
                    row[0] + " " + row[1]);
  }
}

// Force over the current area, compared with the level that is exact for sliding faces.
TEST(FemFinite, TruePressureIsForceOverTheCurrentArea) {
  LevelSettings settings = at_level(Level::fem_finite);
  settings.pressure_kind = PressureKind::true_area;
  auto fem = make_level_model(shipped("paper-2"), settings).value();
  settings.level = Level::hyperelastic;
  auto exact = make_level_model(shipped("paper-2"), settings).value();
  for (const auto p : {0.0_kPa, 1e-3 * 1.0_kPa, 30.0_kPa, 100.0_kPa}) {
    expect_relative(fem->at_pressure(p)->delta_capacitance_F,
                    exact->at_pressure(p)->delta_capacitance_F, 1e-8);
  }
  EXPECT_GE(fem->last_converged()->si(), 100e3 * (1 - 1e-8));  // the search may go a little beyond
  EXPECT_LE(fem->last_converged()->si(), 102e3);
}

TEST(FemFinite, TruePressureUnderAHeldFaceIsDeadPressure) {
  LevelSettings settings = at_level(Level::fem_finite, 0);
  Specimen s = shipped("paper-1");
  s.faces = Faces::bonded_laminate;
  auto dead = make_level_model(s, settings).value();
  settings.pressure_kind = PressureKind::true_area;
  auto real = make_level_model(s, settings).value();
  EXPECT_EQ(real->at_pressure(40.0_kPa)->delta_capacitance_F,
            dead->at_pressure(40.0_kPa)->delta_capacitance_F);
}

TEST(FemFinite, OptionsOfOtherLevelsAreRefused) {
  LevelSettings settings = at_level(Level::fem_finite);
  settings.form = EnergyForm::b;
  EXPECT_FALSE(make_level_model(laminate(1), settings));
  settings = at_level(Level::bonded);
  settings.electrode_area = ElectrodeArea::deformed;
  EXPECT_FALSE(make_level_model(laminate(1), settings));
  settings = at_level(Level::linear);
  settings.lateral = Lateral::confined;
  EXPECT_FALSE(make_level_model(laminate(1), settings));
}

}  // namespace
}  // namespace lcrig
