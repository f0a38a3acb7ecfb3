// SPDX-License-Identifier: Apache-2.0
#include "model/stretch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

constexpr auto kForms = {EnergyForm::incompressible,
                         EnergyForm::a,
                         EnergyForm::b,
                         EnergyForm::c,
                         EnergyForm::d,
                         EnergyForm::e};

// Energy per reference volume over mu, straight from the definitions in the header.
double energy(EnergyForm form, double nu, double log_z, double log_r) {
  const double j = log_z + 2 * log_r;
  const double J = std::exp(j);
  const double i1 = std::exp(2 * log_z) + 2 * std::exp(2 * log_r);
  const double lambda = nu < 0.5 ? 2 * nu / (1 - 2 * nu) : 0;
  const double bulk = lambda + 2.0 / 3;
  const double coupled = 0.5 * (i1 - 3 - 2 * j);
  const double split = 0.5 * (std::pow(J, -2.0 / 3) * i1 - 3);
  switch (form) {
    case EnergyForm::incompressible: return 0.5 * (i1 - 3);
    case EnergyForm::a: return coupled + lambda / 2 * j * j;
    case EnergyForm::b: return split + bulk / 2 * (J - 1) * (J - 1);
    case EnergyForm::c: return coupled + lambda / 2 * (J - 1) * (J - 1);
    case EnergyForm::d: return split + bulk / 4 * (J * J - 1 - 2 * j);
    case EnergyForm::e: return coupled + lambda / 4 * (J * J - 1 - 2 * j);
  }
  return 0;
}

Stretch solve(EnergyForm form, Lateral lateral, PressureKind kind, Pressure p, double nu = 0.49) {
  auto s = solve_stretch(42.0_kPa, nu, form, lateral, kind, p);
  EXPECT_TRUE(s) << (s ? "" : s.error().what);
  return s.value_or(Stretch{});
}

// The dead pressure is the slope of the energy along the path of equilibria; sideways it is 0.
TEST(Stretch, PressureIsDerivativeOfEnergy) {
  for (const auto form : kForms) {
    for (const double nu : {0.0, 0.3, 0.49}) {
      if (nu == 0.0 && form != EnergyForm::a) continue;
      const auto s = solve(form, Lateral::free, PressureKind::dead, 60.0_kPa, nu);
      const double h = 1e-5;
      const bool locked = form == EnergyForm::incompressible;
      const auto along = [&](double d) {
        return energy(form, nu, s.log_lambda_z + d, s.log_lambda_r - (locked ? d / 2 : 0));
      };
      const double slope = (along(h) - along(-h)) / (2 * h) / std::exp(s.log_lambda_z);
      EXPECT_NEAR(-slope * 42, 60, 1e-6) << to_string(form) << " nu " << nu;
      if (!locked) {
        const double sideways = energy(form, nu, s.log_lambda_z, s.log_lambda_r + h) -
                                energy(form, nu, s.log_lambda_z, s.log_lambda_r - h);
        EXPECT_NEAR(sideways / (2 * h), 0, 1e-7) << to_string(form);
      }
    }
  }
}

TEST(Stretch, ConfinedPressureIsDerivativeOfEnergy) {
  for (const auto form : kForms) {
    if (form == EnergyForm::incompressible) continue;
    const auto s = solve(form, Lateral::confined, PressureKind::dead, 500.0_kPa);
    const double h = 1e-6;
    const double slope =
        (energy(form, 0.49, s.log_lambda_z + h, 0) - energy(form, 0.49, s.log_lambda_z - h, 0)) /
        (2 * h) / std::exp(s.log_lambda_z);
    EXPECT_NEAR(-slope * 42, 500, 1e-5) << to_string(form);
    EXPECT_EQ(s.log_lambda_r, 0);
  }
}

TEST(Stretch, SmallPressureGivesYoungsModulus) {
  for (const auto form : kForms) {
    const double nu = form == EnergyForm::incompressible ? 0.5 : 0.49;
    const auto s = solve(form, Lateral::free, PressureKind::dead, Pressure::from_si(1e-9));
    expect_relative(s.strain, 1e-9 / (2 * 42e3 * (1 + nu)), 1e-13, std::string(to_string(form)));
  }
}

TEST(Stretch, TruePressureIsForceOverCurrentArea) {
  for (const auto form : kForms) {
    const auto dead = solve(form, Lateral::free, PressureKind::dead, 100.0_kPa);
    const double area = std::exp(2 * dead.log_lambda_r);
    const auto same = solve(form, Lateral::free, PressureKind::true_area, 100.0_kPa / area);
    expect_relative(same.strain, dead.strain, 1e-13, std::string(to_string(form)));
  }
}

TEST(Stretch, FollowsTheReferenceTable) {
  LCRIG_NEED_REFERENCE(rows, "r2_hyperelastic_1d.csv");
  for (const auto& row : rows) {
    const auto form = parse_word<EnergyForm>(row[0]);
    const auto kind = parse_word<PressureKind>(row[2].substr(0, 4));
    ASSERT_TRUE(form) << row[0];
    const auto lateral = row[1] == "confined" ? Lateral::confined : Lateral::free;
    const auto s = solve(*form, lateral, kind.value_or(PressureKind::dead),
                         Pressure::from_si(row.number(3) * 1e3));
    const std::string what = row[0] + " " + row[1] + " " + row[2] + " " + row[3] + " kPa";
    expect_relative(s.strain, row.number(7), 1e-13, what + " strain");
    expect_relative(std::exp(s.log_lambda_z), row.number(4), 1e-13, what + " lambda");
    expect_relative(std::exp(s.log_lambda_r), row.number(5), 1e-13, what + " lambda_r");
    expect_relative(std::exp(s.log_j), row.number(6), 1e-13, what + " J");
  }
}

TEST(Stretch, ReachesATenthOfTheThickness) {
  LCRIG_NEED_REFERENCE(rows, "r2_inverse.csv");
  for (const auto& row : rows) {
    const double z = row.number(0);
    const auto check = [&](std::size_t column, EnergyForm form, Lateral lateral, PressureKind k) {
      const auto s = solve(form, lateral, k, Pressure::from_si(row.number(column) * 1e3));
      // the last digit of the first row's pressure, 1e-15, corresponds to 1e-13 of the strain
      EXPECT_NEAR(std::exp(s.log_lambda_z), z, 1e-13 * std::max(z, 0.01))
          << row[0] << " " << column;
    };
    check(1, EnergyForm::incompressible, Lateral::free, PressureKind::dead);
    check(2, EnergyForm::incompressible, Lateral::free, PressureKind::true_area);
    check(3, EnergyForm::a, Lateral::confined, PressureKind::dead);
    check(4, EnergyForm::b, Lateral::confined, PressureKind::dead);
  }
}

// The same without files: lambda = 0.1 incompressible, dead 4196 - 4.2... kPa by the closed form.
TEST(Stretch, ClosedFormAtATenth) {
  for (const double z : {0.9, 0.5, 0.1, 0.03}) {
    const auto dead = solve(EnergyForm::incompressible, Lateral::free, PressureKind::dead,
                            42.0_kPa * (1 / (z * z) - z));
    expect_relative(1 - dead.strain, z, 1e-13);
    const auto real = solve(EnergyForm::incompressible, Lateral::free, PressureKind::true_area,
                            42.0_kPa * (1 / z - z * z));
    expect_relative(1 - real.strain, z, 1e-13);
  }
}

TEST(Stretch, HalfPoissonIsIncompressibleForEveryForm) {
  const auto expected =
      solve(EnergyForm::incompressible, Lateral::free, PressureKind::dead, 100.0_kPa);
  for (const auto form : kForms) {
    EXPECT_EQ(solve(form, Lateral::free, PressureKind::dead, 100.0_kPa, 0.5).strain,
              expected.strain);
    EXPECT_EQ(solve(form, Lateral::confined, PressureKind::dead, 100.0_kPa, 0.5).strain, 0);
  }
  EXPECT_EQ(solve(EnergyForm::a, Lateral::free, PressureKind::dead, 0.0_kPa).strain, 0);
}

TEST(Stretch, RefusesWhatHasNoMeaning) {
  const double nan = std::nan("");
  const auto with = [](double mu, double nu, double p) {
    return solve_stretch(Pressure::from_si(mu), nu, EnergyForm::a, Lateral::free,
                         PressureKind::dead, Pressure::from_si(p));
  };
  EXPECT_FALSE(with(0, 0.3, 1));
  EXPECT_FALSE(with(nan, 0.3, 1));
  EXPECT_FALSE(with(1, 0.51, 1));
  EXPECT_FALSE(with(1, nan, 1));
  EXPECT_FALSE(with(1, 0.3, -1));
  EXPECT_FALSE(with(1, 0.3, nan));
}

TEST(Stretch, FormBSaysWhenItCollapses) {
  const auto s =
      solve_stretch(42.0_kPa, 0.3, EnergyForm::b, Lateral::free, PressureKind::dead, 1000.0_kPa);
  ASSERT_FALSE(s);
  EXPECT_THAT(s.error().what, testing::HasSubstr("form B has no equilibrium"));
}

}  // namespace
}  // namespace lcrig
