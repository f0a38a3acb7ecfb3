// SPDX-License-Identifier: Apache-2.0
// Errors that the points of a run share: an error of C0, and differences between repeats.
#include "model/fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "model/specimen_file.hpp"

namespace lcrig {
namespace {

constexpr double kMu_Pa = 55e3, kOffset_Pa = 1e3;

Specimen paper_1() {
  return parse_specimen(std::string(shipped_specimens().front().text), "paper-1").value();
}

// Two repeats over 14 levels. A C0 that is too low by `shift_F` raises every point.
std::vector<FitPoint> shifted_run(double shift_F, double slope_of_second) {
  Specimen s = paper_1();
  for (Material& m : s.materials) {
    if (!m.rigid) m.given_shear_modulus_Pa = kMu_Pa;
  }
  auto model = make_level_model(s, {}).value();
  std::vector<FitPoint> points;
  for (int repeat = 1; repeat <= 2; ++repeat) {
    for (int i = 1; i <= 14; ++i) {
      const double p = 7e3 * i;
      const double delta =
          model->at_pressure(Pressure::from_si(p - kOffset_Pa))->delta_capacitance_F;
      const double factor = repeat == 2 ? slope_of_second : 1;
      points.emplace_back(p, delta * factor + shift_F, 1e-17, repeat);
    }
  }
  return points;
}

TEST(FitShared, AnErrorOfC0IsFoundAndDoesNotMoveTheOthers) {
  const double shift_F = 2e-15;
  const auto points = shifted_run(shift_F, 1);
  const auto blind = fit_response(paper_1(), {}, points).value();
  EXPECT_GT(std::abs(blind.contact_offset_Pa.value - kOffset_Pa), 50);
  const auto fit = fit_response(paper_1(), {}, points, C0Error(1e-12)).value();
  EXPECT_NEAR(fit.shear_modulus_Pa.value / kMu_Pa, 1, 1e-3);
  EXPECT_NEAR(fit.contact_offset_Pa.value, kOffset_Pa, 5);
  EXPECT_NEAR(fit.c0_shift_F.value, shift_F, 2e-17);
}

TEST(FitShared, RepeatsThatDifferWidenTheInterval) {
  const auto alike = fit_response(paper_1(), {}, shifted_run(0, 1)).value();
  const auto differ = fit_response(paper_1(), {}, shifted_run(0, 1.02)).value();
  EXPECT_EQ(differ.repeats, 2);
  EXPECT_GT(differ.shear_modulus_Pa.standard_error,
            100 * std::abs(alike.shear_modulus_Pa.standard_error));
  EXPECT_LT(differ.shear_modulus_Pa.ci95_low, kMu_Pa);
  EXPECT_GT(differ.shear_modulus_Pa.ci95_high, kMu_Pa);
}

// The scatter of repeats does not show the errors that all of them share.
TEST(FitShared, TheErrorOfC0StaysWhereRepeatsAreAlike) {
  const double known_F = 0.01e-15;
  const auto fit = fit_response(paper_1(), {}, shifted_run(0, 1), C0Error(known_F)).value();
  const FitValue& c0 = fit.c0_shift_F;
  EXPECT_GT(c0.standard_error, 0.5 * known_F);
  EXPECT_LE(c0.standard_error, 1.01 * known_F);
  EXPECT_NEAR((c0.ci95_high - c0.ci95_low) / 2 / c0.standard_error, 1.96, 0.01);
  EXPECT_GT(fit.contact_offset_Pa.standard_error, 0.01);
  const auto few = fit_response(paper_1(), {}, shifted_run(0, 1), C0Error(known_F, 2)).value();
  EXPECT_NEAR((few.c0_shift_F.ci95_high - few.c0_shift_F.ci95_low) / 2 / c0.standard_error, 4.303,
              0.01);
}

TEST(FitShared, AModelThatIsWrongMovesTheModulusByAboutAsMuch) {
  const auto fit = fit_response(paper_1(), {}, shifted_run(0, 1)).value();
  const double share = fit.shear_modulus_Pa.per_model_error / kMu_Pa;
  EXPECT_GT(std::abs(share), 0.3);
  EXPECT_LT(std::abs(share), 3);
}

}  // namespace
}  // namespace lcrig
