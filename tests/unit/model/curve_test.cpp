// SPDX-License-Identifier: Apache-2.0
#include "model/curve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "model/compare.hpp"
#include "model/design.hpp"
#include "model/fit.hpp"
#include "model/ladder.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

TEST(Pressures, RangesAndLists) {
  const auto range = parse_pressures_kPa("0:100:10");
  ASSERT_TRUE(range);
  ASSERT_EQ(range->size(), 11U);
  EXPECT_DOUBLE_EQ(range->back().si(), 100e3);
  EXPECT_EQ(parse_pressures_kPa("0:0.3:0.1")->size(), 4U);
  EXPECT_EQ(parse_pressures_kPa("5,7.5")->at(1).si(), 7.5e3);
}

TEST(Pressures, BadOnesAreRefusedBeforeWorkStarts) {
  for (const char* bad : {"", "a", "0:100", "0:100:0", "0:100:-1", "100:0:1", "nan", "0:inf:1",
                          "-1,2", "3,2", "1,1", "0:100:10:1", "1,,2", "0:1000000:1"}) {
    const auto pressures = parse_pressures_kPa(bad);
    ASSERT_FALSE(pressures) << bad;
    EXPECT_EQ(pressures.error().code, Errc::invalid_request);
  }
}

TEST(Curve, ChoosesALevelAndPrintsIt) {
  const auto pressures = parse_pressures_kPa("0:100:10").value();
  const auto curve = calc_curve(shipped("paper-1"), std::nullopt, 1e-3, pressures);
  ASSERT_TRUE(curve) << curve.error().what;
  const auto json = to_json(*curve);
  EXPECT_EQ(json["level"], "hyperelastic");
  EXPECT_EQ(json["points"].size(), 11U);
  EXPECT_NEAR(json["points"][0]["capacitance_pF"].get<double>(), 3.6457, 5e-5);
  EXPECT_EQ(json["points"][0]["delta_C_fF"], 0.0);
  EXPECT_NEAR(json["points"][10]["capacitance_pF"].get<double>() * 5, 20.855, 1e-3);
}

TEST(Curve, SaysAtWhichPressureALevelEnds) {
  LevelSettings linear;
  linear.level = Level::linear;
  const auto pressures = parse_pressures_kPa("100:300:100").value();
  const auto curve = calc_curve(shipped("paper-1"), linear, 1, pressures);
  ASSERT_FALSE(curve);
  EXPECT_THAT(curve.error().what, testing::HasSubstr("at 200 kPa"));
}

TEST(Curve, SlopeHasCentredSums) {
  std::vector<ModelPoint> points;
  for (int i = 0; i <= 10; ++i) points.push_back({1e12 + i, 0, 3.0 * i, 0});
  EXPECT_DOUBLE_EQ(fit_slope(points), 3);
}

TEST(Curve, FringeRaisesC0AndChange) {
  const auto pressures = parse_pressures_kPa("1e-6,50").value();
  LevelSettings settings;
  const auto plain = calc_curve(shipped("paper-1"), settings, 1, pressures).value();
  settings.fringe = true;
  const auto fringed = calc_curve(shipped("paper-1"), settings, 1, pressures).value();
  EXPECT_NEAR(fringed.points[0].capacitance_F / plain.points[0].capacitance_F, 1.0970315, 1e-6);
  // The fringe weakens as the gap closes, so the change gains less from it than C0.
  for (std::size_t i = 0; i < 2; ++i) {
    const double ratio =
        fringed.points[i].delta_capacitance_F / plain.points[i].delta_capacitance_F;
    EXPECT_GT(ratio, 1.0);
    EXPECT_LT(ratio, 1.0970315);
  }
}

// Once all air is pressed out, the stack is equal to the one without air.
TEST(Curve, ContactGapAddsAirThatIsPressedOut) {
  const auto pressures = parse_pressures_kPa("0,0.001,100").value();
  Specimen s = shipped("paper-2");
  const auto plain = calc_curve(s, LevelSettings{}, 1, pressures).value();
  s.contact_gap = ContactGap{5e-6, 1.0};
  const auto loose = calc_curve(s, LevelSettings{}, 1, pressures).value();
  const double area = s.area_m2();
  const double gap = s.dielectric_gap_m(s.capacitors[0]) + 5e-6;
  expect_relative(loose.points[0].capacitance_F, 2 * kVacuumPermittivity_F_m * area / gap, 1e-14);
  EXPECT_NEAR(loose.points[1].shortening_m - plain.points[1].shortening_m, 2 * 2.5e-6, 1e-15);
  expect_relative(loose.points[2].capacitance_F, plain.points[2].capacitance_F, 1e-4);
}

TEST(Design, FreeFacesFollowTheClosedForm) {
  DesignRequest request;
  request.faces = Faces::free;
  const auto design = design_partition(request);
  ASSERT_TRUE(design) << design.error().what;
  EXPECT_NEAR(design->options.front().gain, 0.964286, 1e-6);  // the reference's +96.43 %
  EXPECT_EQ(design->options.back().placement, "equal layers");
}

TEST(Design, BondedBaseWantsThinLayersAtTheFreeSide) {
  const auto design = design_partition(DesignRequest{});
  ASSERT_TRUE(design) << design.error().what;
  ASSERT_EQ(design->options.size(), 5U);
  const auto& best = design->options.front();
  EXPECT_THAT(best.placement, testing::StartsWith("thin layers at the top"));
  EXPECT_GT(best.thickness_m.front(), best.thickness_m.back());
  EXPECT_GT(best.gain, 1.0);
  for (const auto& option : design->options) {
    if (option.placement.starts_with("thin layers at the base")) {
      EXPECT_NEAR(option.gain, 0.208, 2e-3);  // small-strain slopes 20.89 over 17.29
      EXPECT_NEAR(option.fitted_F_Pa * 1e18, 32.459, 0.01);
    }
  }
}

// Every partition was tried, not only vertices: none beats thin layers at the free side.
TEST(Design, BondedBaseSearchFindsNothingBetterThanTheVertex) {
  for (const int n : {2, 4, 7}) {
    DesignRequest request;
    request.capacitors = n;
    const auto design = design_partition(request);
    ASSERT_TRUE(design) << design.error().what;
    EXPECT_GT(design->search_grid_m, 0);
    EXPECT_THAT(design->options.front().placement, testing::StartsWith("thin layers at the top"));
    EXPECT_EQ(design->options.size(), static_cast<std::size_t>(n) + 1);
  }
}

// Very thin bonded layers are so stiff that they must be avoided: the search leaves vertices.
TEST(Design, SearchBetweenFilmsRatesStiffness) {
  DesignRequest request;
  request.faces = Faces::bonded_laminate;
  request.material.poisson_ratio = 0.4999;
  request.least_layer = Length::from_si(1e-6);
  const auto design = design_partition(request);
  ASSERT_TRUE(design) << design.error().what;
  for (const auto& option : design->options) {
    EXPECT_LE(option.gain, design->options.front().gain);
  }
  double total = 0;
  for (const double t : design->options.front().thickness_m) total += t;
  EXPECT_NEAR(total, 1e-3, 1e-12);
  EXPECT_GE(design->options.front().gain, 0);
}

TEST(Design, WhatDoesNotFitIsRefused) {
  DesignRequest request;
  request.capacitors = 11;
  EXPECT_FALSE(design_partition(request));
  request.capacitors = 0;
  EXPECT_FALSE(design_partition(request));
  request = DesignRequest{};
  request.total = Length::from_si(-1);
  EXPECT_FALSE(design_partition(request));
}

TEST(Ladder, MeasuresEveryRung) {
  double time = 0;
  const auto ladder = climb_ladder(shipped("paper-1"), 50.0_kPa, [&] { return time += 0.3; });
  ASSERT_TRUE(ladder) << ladder.error().what;
  int references = 0;
  for (const auto& row : ladder->rows) {
    references += row.reference;
    if (row.reference) {
      EXPECT_EQ(row.settings.level, Level::hyperelastic);
    }
    if (row.settings.level == Level::fem_finite) {
      EXPECT_LT(row.relative_error, 1e-9);
    }
    if (row.settings.level == Level::linear) {
      EXPECT_GT(row.relative_error, 0.1);
    }
  }
  EXPECT_EQ(references, 1);
  EXPECT_EQ(to_json(*ladder)["rows"].size(), ladder->rows.size());
  EXPECT_THAT(to_table(*ladder), testing::HasSubstr("reference"));
}

TEST(Compare, RowsOfThePaper) {
  const auto rows = compare_with_paper();
  ASSERT_TRUE(rows) << rows.error().what;
  int t3 = 0;
  for (const auto& row : *rows) {
    if (row.target == "T1") {
      EXPECT_TRUE(row.reproduced) << row.quantity;
    }
    if (row.assumption == "same, area of the deformed electrode") {
      ++t3;
      if (row.paper == 7) {
        EXPECT_NEAR(row.model, 8.5, 0.15);
      }
      if (row.paper == 130) {
        EXPECT_NEAR(row.model, 106.6, 0.3);
      }
      if (row.paper == 120) {
        EXPECT_NEAR(row.model, 121.6, 0.1);
      }
    }
    if (row.target == "T2" && row.paper == 8.9 &&
        row.assumption.starts_with("free faces, mu 42 kPa, p")) {
      EXPECT_NEAR(row.model, 8.26, 0.01);
    }
  }
  EXPECT_EQ(t3, 3);
  EXPECT_EQ(paper_errata().size(), 17U);
}

std::vector<FitPoint> made_up_run(double mu_Pa, double offset_Pa, double noise_F) {
  Specimen s = shipped("paper-2");
  for (Material& m : s.materials) {
    if (!m.rigid) m.given_shear_modulus_Pa = mu_Pa;
  }
  auto model = make_level_model(s, {}).value();
  std::vector<FitPoint> points;
  for (int i = 1; i <= 14; ++i) {
    const double p = 7e3 * i;
    const double noise = noise_F * std::sin(37.0 * i);
    points.push_back(
        {p, model->at_pressure(Pressure::from_si(p - offset_Pa))->delta_capacitance_F + noise, 0});
  }
  return points;
}

TEST(Fit, FindsModulusAndOffset) {
  const auto fit = fit_response(shipped("paper-2"), {}, FitData(made_up_run(55e3, 2e3, 0)));
  ASSERT_TRUE(fit) << fit.error().what;
  EXPECT_NEAR(fit->shear_modulus_Pa.value, 55e3, 0.1);
  EXPECT_NEAR(fit->contact_offset_Pa.value, 2e3, 0.1);
}

TEST(Fit, IntervalCoversTheTruthAndShrinksWithNoise) {
  const auto rough =
      fit_response(shipped("paper-2"), {}, FitData(made_up_run(55e3, 2e3, 1e-15))).value();
  const auto fine =
      fit_response(shipped("paper-2"), {}, FitData(made_up_run(55e3, 2e3, 1e-16))).value();
  EXPECT_LT(rough.shear_modulus_Pa.ci95_low, 55e3);
  EXPECT_GT(rough.shear_modulus_Pa.ci95_high, 55e3);
  // Ten times the noise; what is allowed for a misfit grows less.
  const double ratio = rough.shear_modulus_Pa.standard_error / fine.shear_modulus_Pa.standard_error;
  EXPECT_GT(ratio, 4);
  EXPECT_LT(ratio, 12);
  EXPECT_LT(rough.residual_F, 2e-15);
}

TEST(Fit, TooLittleIsRefused) {
  EXPECT_FALSE(fit_response(shipped("paper-2"), {}, FitData()));
  std::vector<FitPoint> same(6, FitPoint{10e3, 1e-14, 0});
  EXPECT_FALSE(fit_response(shipped("paper-2"), {}, FitData(same)));
}

TEST(Fit, StudentsQuantile) {
  EXPECT_NEAR(student_t975(1), 12.706, 1e-3);
  EXPECT_NEAR(student_t975(12), 2.179, 1e-3);
  EXPECT_NEAR(student_t975(1000), 1.962, 1e-3);
}

}  // namespace
}  // namespace lcrig
