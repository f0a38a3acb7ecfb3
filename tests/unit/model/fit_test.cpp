// SPDX-License-Identifier: Apache-2.0
// Errors that the points of a run share (C0, differences between repeats), and fits that do not
// fit.
#include "model/fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "model/specimen_file.hpp"

namespace lcrig {
namespace {

constexpr double kMu_Pa = 55e3, kOffset_Pa = 1e3;

Specimen paper_1() {
  return parse_specimen(std::string(shipped_specimens().front().text), "paper-1").value();
}

// Two repeats over 14 levels. A C0 that is too low by `shift_F` raises every point. The specimen of
// the second repeat is stiffer by a factor.
std::vector<FitPoint> shifted_run(double shift_F, double stiffer) {
  std::vector<FitPoint> points;
  for (int repeat = 1; repeat <= 2; ++repeat) {
    Specimen s = paper_1();
    for (Material& m : s.materials) {
      if (!m.rigid) m.given_shear_modulus_Pa = kMu_Pa * (repeat == 2 ? stiffer : 1);
    }
    auto model = make_level_model(s, {}).value();
    for (int i = 1; i <= 14; ++i) {
      const double p = 7e3 * i;
      const double delta =
          model->at_pressure(Pressure::from_si(p - kOffset_Pa))->delta_capacitance_F;
      points.emplace_back(p, delta + shift_F, 1e-17, repeat);
    }
  }
  return points;
}

TEST(FitShared, AnErrorOfC0IsFoundAndDoesNotMoveTheOthers) {
  const double shift_F = 2e-15;
  const auto points = shifted_run(shift_F, 1);
  const auto blind = fit_response(paper_1(), {}, FitData(points)).value();
  EXPECT_GT(std::abs(blind.contact_offset_Pa.value - kOffset_Pa), 50);
  const auto fit = fit_response(paper_1(), {}, FitData(points, C0Error(1e-12))).value();
  EXPECT_NEAR(fit.shear_modulus_Pa.value / kMu_Pa, 1, 1e-3);
  EXPECT_NEAR(fit.contact_offset_Pa.value, kOffset_Pa, 5);
  EXPECT_NEAR(fit.c0_shift_F.value, shift_F, 2e-17);
}

TEST(FitShared, RepeatsThatDifferWidenTheInterval) {
  const auto alike = fit_response(paper_1(), {}, FitData(shifted_run(0, 1))).value();
  const auto differ = fit_response(paper_1(), {}, FitData(shifted_run(0, 1.02))).value();
  EXPECT_EQ(differ.repeats, 2);
  EXPECT_GT(differ.shear_modulus_Pa.standard_error,
            100 * std::abs(alike.shear_modulus_Pa.standard_error));
  EXPECT_LT(differ.shear_modulus_Pa.ci95_low, kMu_Pa);
  EXPECT_GT(differ.shear_modulus_Pa.ci95_high, kMu_Pa);
}

// The scatter of repeats does not show the errors that all of them share.
TEST(FitShared, TheErrorOfC0StaysWhereRepeatsAreAlike) {
  const double known_F = 0.01e-15;
  const auto fit =
      fit_response(paper_1(), {}, FitData(shifted_run(0, 1), C0Error(known_F))).value();
  const FitValue& c0 = fit.c0_shift_F;
  EXPECT_GT(c0.standard_error, 0.5 * known_F);
  EXPECT_LE(c0.standard_error, 1.01 * known_F);
  EXPECT_NEAR((c0.ci95_high - c0.ci95_low) / 2 / c0.standard_error, 1.96, 0.01);
  EXPECT_GT(fit.contact_offset_Pa.standard_error, 0.01);
  const auto few =
      fit_response(paper_1(), {}, FitData(shifted_run(0, 1), C0Error(known_F, 2))).value();
  EXPECT_NEAR((few.c0_shift_F.ci95_high - few.c0_shift_F.ci95_low) / 2 / c0.standard_error, 4.303,
              0.05);  // a little of it is the allowance for misfit
}

TEST(FitShared, AModelThatIsWrongMovesTheModulusByAboutAsMuch) {
  const auto fit = fit_response(paper_1(), {}, FitData(shifted_run(0, 1))).value();
  const double share = fit.shear_modulus_Pa.per_model_error / kMu_Pa;
  EXPECT_GT(std::abs(share), 0.3);
  EXPECT_LT(std::abs(share), 3);
}

// Delta C of a free stack in closed form (incompressible neo-Hookean: P = mu (1/stretch^2 -
// stretch)); nothing of model/ takes part.
class ClosedForm {
 public:
  double soft_m = 25e-6;
  double mu_Pa = 42e3;

  double capacitance_F(double pressure_Pa) const {
    double low = 1e-3, high = 1;
    for (int i = 0; i < 60; ++i) {
      const double stretch = (low + high) / 2;
      (mu_Pa * (1 / (stretch * stretch) - stretch) > pressure_Pa ? low : high) = stretch;
    }
    return 8.8541878128e-12 * std::numbers::pi * 4e-6 / (low * soft_m / 2.75 + 75e-6 / 3.5);
  }
  double delta_F(double pressure_Pa) const { return capacitance_F(pressure_Pa) - capacitance_F(0); }
};

Specimen incompressible() {
  Specimen s = paper_1();
  s.materials.front().poisson_ratio = 0.5;
  s.materials.front().given_shear_modulus_Pa = 50e3;
  s.materials.front().youngs_modulus_Pa = 150e3;
  return s;
}

constexpr double kNoise_F = 0.05e-15;  // of a point

// Three repeats of ten levels, bent by an error that all readings share and that grows with the
// pressure.
FitData bent_run(const ClosedForm& truth, double bend_F, double gain = 1) {
  FitData data;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int repeat = 1; repeat <= 3; ++repeat) {
    for (int i = 1; i <= 10; ++i) {
      const double Pa = 10e3 * i, x = i / 10.0;
      const double delta_F = truth.delta_F(Pa) * gain + bend_F * std::sin(3 * x) * x;
      data.points.emplace_back(Pa, delta_F + kNoise_F * normal(random), kNoise_F, repeat);
    }
  }
  data.c0 = C0Error(0.1e-15, 50);
  return data;
}

bool holds(const FitValue& v, double truth) {
  return v.ci95_low <= truth && truth <= v.ci95_high;
}

TEST(FitMisfit, AnExactLawIsNotAMisfitAndItsIntervalIsNarrow) {
  const ClosedForm truth;
  const Fit fit = fit_response(incompressible(), {}, bent_run(truth, 0)).value();
  EXPECT_FALSE(fit.misfit.found()) << fit.misfit.p;
  EXPECT_TRUE(holds(fit.shear_modulus_Pa, truth.mu_Pa));
  EXPECT_LT(fit.shear_modulus_Pa.ci95_high / fit.shear_modulus_Pa.ci95_low, 1.01);
  EXPECT_EQ(fit.misfit.pulls.size(), 10U);
}

// 30 readings with one and the same error of 10 fF are one datum, not thirty.
TEST(FitMisfit, ReadingsThatShareAnErrorDoNotOutvoteC0) {
  const ClosedForm truth;
  const Fit fit = fit_response(incompressible(), {}, bent_run(truth, 10e-15)).value();
  EXPECT_TRUE(fit.misfit.found());
  EXPECT_LT(std::abs(fit.c0_shift_F.value), 3 * 0.1e-15);
  EXPECT_TRUE(holds(fit.shear_modulus_Pa, truth.mu_Pa))
      << fit.shear_modulus_Pa.ci95_low << " " << fit.shear_modulus_Pa.ci95_high;
  EXPECT_GT(std::abs(fit.misfit.c0_pull), 3);  // the law alone would have moved it
  ASSERT_FALSE(fit.misfit.patterns.empty());
  EXPECT_EQ(fit.misfit.patterns.front().kind, FitPatternKind::law);
  EXPECT_GT(fit.misfit.law_F, 1e-15);
}

TEST(FitMisfit, AWrongThicknessIsNamedAndIncluded) {
  ClosedForm truth;
  truth.soft_m = 26e-6;  // the file says 25 um
  FitData data = bent_run(truth, 0);
  data.measured_c0_F = truth.capacitance_F(0);
  data.c0_tolerance = 5e-4;
  const Fit fit = fit_response(incompressible(), {}, data).value();
  EXPECT_TRUE(holds(fit.shear_modulus_Pa, truth.mu_Pa));
  ASSERT_FALSE(fit.misfit.patterns.empty());
  EXPECT_EQ(fit.misfit.patterns.front().kind, FitPatternKind::size);
  EXPECT_THAT(fit.misfit.patterns.front().text, testing::HasSubstr("soft layers +4 % thick"));
}

TEST(FitMisfit, WrongFacesAreRefusedByName) {
  Specimen bonded = paper_1();
  bonded.faces = Faces::bonded_laminate;
  LevelSettings settings;
  settings.level = Level::bonded;
  auto model = make_level_model(bonded, settings).value();
  FitData data;
  for (int i = 1; i <= 10; ++i) {
    const double Pa = 10e3 * i;
    data.points.emplace_back(Pa, model->at_pressure(Pressure::from_si(Pa))->delta_capacitance_F,
                             1e-18);
  }
  const auto fit = fit_response(paper_1(), {}, data);
  ASSERT_FALSE(fit) << fit->shear_modulus_Pa.value;
  EXPECT_THAT(fit.error().what,
              testing::AllOf(testing::HasSubstr("with bonded_laminate faces the file's modulus"),
                             testing::HasSubstr("state the faces")));
}

TEST(FitMisfit, UnloadingIsInTheInterval) {
  const ClosedForm truth;
  FitData data = bent_run(truth, 0);
  for (FitPoint& p : data.points) {
    const double x = p.pressure_Pa / 100e3;
    p.gap_F = 40e-15 * x * (1 - x);
    p.delta_capacitance_F -= p.gap_F / 2;  // the law describes the middle of the branches
  }
  const Fit fit = fit_response(incompressible(), {}, data).value();
  EXPECT_TRUE(holds(fit.shear_modulus_Pa, truth.mu_Pa));
  EXPECT_GT(fit.parts.hysteresis, 0.001);
}

TEST(FitMisfit, NothingLikeTheLawIsRefused) {
  const auto fit = [](auto shape) {
    FitData data;
    for (int i = 1; i <= 10; ++i) {
      data.points.emplace_back(10e3 * i, 500e-15 * shape(i / 10.0), 0.1e-15);
    }
    data.c0 = C0Error(0.05e-15, 50);
    return fit_response(incompressible(), {}, data);
  };
  const auto stiffens_never = fit([](double x) { return x * x; });
  ASSERT_FALSE(stiffens_never);
  EXPECT_THAT(stiffens_never.error().what,
              testing::AllOf(testing::HasSubstr("fit refused"), testing::HasSubstr("law: ")));
  EXPECT_FALSE(fit([](double x) { return x > 0.5 ? 1.0 : 0.0; }));
  EXPECT_FALSE(fit([](double x) { return std::sin(31 * x); }));
  EXPECT_FALSE(fit([](double x) { return -x; }));
}

TEST(FitMisfit, TooFewLevelsAreRefusedInWords) {
  const ClosedForm truth;
  FitData data;
  for (int repeat = 1; repeat <= 8; ++repeat) {
    data.points.emplace_back(50e3, truth.delta_F(50e3), kNoise_F, repeat);
  }
  const auto one = fit_response(incompressible(), {}, data);
  ASSERT_FALSE(one);
  EXPECT_THAT(one.error().what, testing::HasSubstr("1 different pressure (up to 50 kPa)"));
  data.points.emplace_back(80e3, truth.delta_F(80e3), kNoise_F, 1);
  const auto two = fit_response(incompressible(), {}, data);
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().what, testing::HasSubstr("2 different pressures"));
}

}  // namespace
}  // namespace lcrig
