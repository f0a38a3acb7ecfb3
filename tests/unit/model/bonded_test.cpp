// SPDX-License-Identifier: Apache-2.0
#include "model/bonded.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "model/error_estimate.hpp"
#include "model/fringe.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

double modulus(double shape_factor, double nu) {
  return bonded_modulus_Pa(1 / (2 * (1 + nu)), nu, shape_factor);
}

TEST(Bonded, BesselRatioAgreesWithTheLibraryAndNeverOverflows) {
  for (const double x : {1e-3, 0.1, 1.0, 10.0, 59.9, 60.1, 300.0}) {
    const double expected = 8 * std::cyl_bessel_i(2.0, x) / std::cyl_bessel_i(0.0, x) / (x * x);
    expect_relative(bessel_bulge(x), expected, 1e-13, std::to_string(x));
  }
  EXPECT_EQ(bessel_bulge(0), 1);
  expect_relative(bessel_bulge(1e6), 8e-12 * (1 - 2e-6), 1e-11);
}

TEST(Bonded, IncompressibleLimitIsReached) {
  for (const double s : {0.5, 2.0, 40.0, 80.0}) {
    expect_relative(modulus(s, 0.5), 1 + 2 * s * s, 1e-14);
    expect_relative(modulus(s, 0.5 - 1e-13), 1 + 2 * s * s, 1e-6);
  }
}

TEST(Bonded, FormulaOfTheReference) {
  LCRIG_NEED_REFERENCE(rows, "r6_thin_layer_24um.csv");
  for (const auto& row : rows) {
    expect_relative(modulus(row.number(0), row.number(1)), row.number(5), 6e-6, row[1]);
  }
}

TEST(Bonded, NonlinearFormStartsLinear) {
  const double small = bonded_strain(42.0_kPa, 0.49, 40, Pressure::from_si(1)).value();
  expect_relative(small, 1 / bonded_modulus_Pa(42e3, 0.49, 40), 1e-5);
  expect_relative(bonded_strain(42.0_kPa, 0.5, 40, 1.0_kPa).value(), 1e3 / (126e3 * (1 + 2 * 1600)),
                  1e-12);
}

TEST(Fringe, LoveFactorOfTheReference) {
  LCRIG_NEED_REFERENCE(rows, "r4_fringe.csv");
  for (const auto& row : rows) {
    expect_relative(love_factor(row.number(0) / 2), row.number(1), 1e-9, row[0]);
    expect_relative(kirchhoff_factor(row.number(0) / 2), row.number(3), 1e-7, row[0]);
  }
}

TEST(Fringe, PinnedAndFarApart) {
  expect_relative(love_factor(0.05), 1.0970315493, 1e-9);
  // Two discs far apart: C -> 4 eps a each, in series, so C/C_plate -> 8 a d / (2 pi a^2) ...
  expect_relative(love_factor(100), 4 * 100 / std::acos(-1.0), 1e-2);
}

}  // namespace
}  // namespace lcrig
