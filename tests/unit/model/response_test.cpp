// SPDX-License-Identifier: Apache-2.0
#include "model/response.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

std::unique_ptr<TabulatedResponse> table(const LevelSettings& settings, Force max_force,
                                         double tolerance) {
  auto response = make_response(shipped("paper-2"), settings, max_force, tolerance);
  EXPECT_TRUE(response) << (response ? "" : response.error().what);
  return std::move(response.value());
}

TEST(TabulatedResponse, StaysWithinATenthOfTheTolerance) {
  const Specimen s = shipped("paper-2");
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const auto response = table(LevelSettings{}, 20.0_N, tolerance);
    auto model = make_level_model(s, LevelSettings{}).value();
    for (double force = 1e-6; force < 20; force *= 1.07) {
      const auto exact = model->at_pressure(Pressure::from_si(force / s.area_m2())).value();
      expect_relative(response->shortening_m(force), exact.shortening_m, tolerance / 10);
      expect_relative(response->delta_capacitance_F(force), exact.delta_capacitance_F,
                      tolerance / 10);
    }
    EXPECT_LE(response->relative_error(), tolerance / 10);
  }
}

TEST(TabulatedResponse, RisesEverywhere) {
  const auto response = table(LevelSettings{}, 5.0_N, 1e-3);
  double shortening = 0, capacitance = response->c0_F();
  for (double force = 1e-4; force < 8; force += 1e-3) {
    EXPECT_GT(response->shortening_m(force), shortening);
    EXPECT_GT(response->capacitance_F(force), capacitance);
    shortening = response->shortening_m(force);
    capacitance = response->capacitance_F(force);
  }
  EXPECT_EQ(response->shortening_m(0), 0);
  EXPECT_EQ(response->capacitance_F(0), response->c0_F());
}

TEST(TabulatedResponse, EndsWhereTheLevelEnds) {
  LevelSettings settings;
  settings.level = Level::linear;
  const auto response = table(settings, 5.0_N, 1e-3);  // the spring law closes at 2.51 N
  EXPECT_GT(response->max_force_N(), 2.0);
  EXPECT_LT(response->max_force_N(), 2.5133);
  EXPECT_GT(response->shortening_m(5), response->shortening_m(2.5));
}

TEST(TabulatedResponse, AnyLevelCanBeTabulated) {
  Specimen s = shipped("paper-1");
  s.faces = Faces::bonded_laminate;
  LevelSettings settings;
  settings.level = Level::fem_finite;
  settings.mesh.refinement = 0;
  const auto response = make_response(s, settings, 2.0_N, 1e-2);
  ASSERT_TRUE(response) << response.error().what;
  auto model = make_level_model(s, settings).value();
  const double exact =
      model->at_pressure(Pressure::from_si(0.7 / s.area_m2()))->delta_capacitance_F;
  expect_relative((*response)->delta_capacitance_F(0.7), exact, 1e-3);
}

TEST(TabulatedResponse, RefusesSenselessRequests) {
  EXPECT_FALSE(make_response(shipped("paper-1"), LevelSettings{}, 0.0_N, 1e-3));
  EXPECT_FALSE(make_response(shipped("paper-1"), LevelSettings{}, 1.0_N, 0));
  EXPECT_FALSE(make_response(shipped("paper-1"), LevelSettings{}, 1.0_N, std::nan("")));
  Specimen none = shipped("paper-1");
  none.capacitors.clear();
  EXPECT_FALSE(make_response(none, LevelSettings{}, 1.0_N, 1e-3));
}

}  // namespace
}  // namespace lcrig
