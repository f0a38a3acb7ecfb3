// SPDX-License-Identifier: Apache-2.0
// Cases that break careless elements and solvers, and what the faces mean for the elements.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "balance.hpp"
#include "model/bonded.hpp"
#include "model/fem_levels.hpp"
#include "reference.hpp"

namespace lcrig {
namespace {

using namespace literals;

std::unique_ptr<FemLinear> linear(const Specimen& s, int mesh = 1) {
  LevelSettings settings;
  settings.level = Level::fem_linear;
  settings.mesh.refinement = mesh;
  auto model = FemLinear::make(s, settings);
  EXPECT_TRUE(model) << (model ? "" : model.error().what);
  return std::move(model.value());
}

double initial_slope_fF_kPa(const Specimen& s, int mesh = 1) {
  return linear(s, mesh)->at_pressure(Pressure::from_si(1e-3))->delta_capacitance_F * 1e21;
}

double modulus_of_disc(double shape_factor, double nu, int mesh) {
  const Specimen s = punch(shape_factor, nu);
  return 1e-3 /
         (linear(s, mesh)->at_pressure(Pressure::from_si(1e-3))->shortening_m * 2 * shape_factor);
}

TEST(HardCases, ThinBondedLayerUpToIncompressible) {  // 24 um x 4 mm
  for (const auto& [nu, exact] :
       {std::pair{0.4999, 958.308}, std::pair{0.49999, 2717.37}, std::pair{0.5, 3464.91}}) {
    expect_relative(modulus_of_disc(4.0 / (4 * 0.024), nu, 1), exact, 1e-4, std::to_string(nu));
  }
}

TEST(HardCases, ThickBlockDoesNotLock) {
  expect_relative(modulus_of_disc(2, 0.4999, 1), 8.70688, 1e-4);
  expect_relative(modulus_of_disc(2, 0.5, 1), 8.75783, 1e-4);
}

// Kapton is 2e4 times stiffer than the layers it carries. Layers with 1/lambda = 0 are tested, too.
TEST(HardCases, ModulusContrastAndIncompressibilityLeaveNoResidual) {
  Specimen s = laminate(3);
  for (const double nu : {0.49, 0.5}) {
    for (Material& m : s.materials) m.poisson_ratio = m.youngs_modulus_Pa < 1e6 ? nu : 0.34;
    // the last digit of a stiff film's displacement means a force of nearly this size
    expect_balance(s, 1, "nu " + std::to_string(nu), 1e-8);
  }
}

TEST(HardCases, TenLayerStack) {
  expect_relative(initial_slope_fF_kPa(laminate(10), 0), 5.3696862, 1e-4);
  const Specimen soft = soft_block(10);
  EXPECT_GT(initial_slope_fF_kPa(soft, 0), 10 * initial_slope_fF_kPa(soft_block(1), 0));
}

TEST(HardCases, ChangeKeepsAllDigitsAtTinyPressure) {
  const auto model = linear(laminate(1));
  const double unit = model->at_pressure(1e-6 * 1.0_kPa)->delta_capacitance_F * 1e6;
  for (const double p : {1e-12, 1e-9}) {
    expect_relative(model->at_pressure(p * 1.0_kPa)->delta_capacitance_F, unit * p, 1e-8);
    // to first order in the pressure the change is proportional to it, to the last digits
    expect_relative(model->at_pressure(p * 1.0_kPa)->delta_capacitance_F,
                    2 * model->at_pressure(p / 2 * 1.0_kPa)->delta_capacitance_F, 1e-11);
  }
}

// At a singular corner even meshes converge with an order near 1 whatever the element. Graded
// meshes keep the order of the element. The reference has seven digits; the steps between meshes
// have more.
TEST(HardCases, ConvergenceOrderOnAGradedMesh) {
  const double exact = 5.6500910;
  std::vector<double> modulus;
  for (int mesh = -2; mesh <= 3; ++mesh) modulus.push_back(modulus_of_disc(2, 0.49, mesh));
  for (const std::size_t finest : {4U, 5U}) {  // each second mesh halves every cell
    const double ratio =
        (modulus[finest - 2] - modulus[finest - 4]) / (modulus[finest] - modulus[finest - 2]);
    EXPECT_GE(std::log2(ratio), 4) << "to mesh " << finest - 2;
  }
  expect_relative(modulus[4], exact, 2e-6);
}

TEST(Faces, BondedBaseHoldsTheBaseAloneAndTopLayersAreFreeSideways) {
  LCRIG_NEED_REFERENCE(rows, "lam_initial_slope.csv");
  int compared = 0;
  for (const auto& row : rows) {
    if (row[0] != "LAM-KP") continue;
    const double best = std::stod(row[3].substr(row[3].rfind('/') + 1));
    const auto s = open_laminate(static_cast<std::size_t>(row.number(1)));
    expect_relative(initial_slope_fF_kPa(s), best, 1.5e-4, row[1]);
    ++compared;
  }
  EXPECT_EQ(compared, 2);
}

// Films that are not listed are the electrodes: each layer is a disc between rigid plates.
TEST(Faces, LaminateHoldsEveryLayerAtItsElectrodes) {
  Specimen s = soft_stack({100e-6, 50e-6});
  s.faces = Faces::bonded_laminate;
  const Material& m = s.material(s.capacitors.front().layers.front());
  const double mu = m.youngs_modulus_Pa / (2 * (1 + m.poisson_ratio));
  double expected = 0;  // of the closed form, within 0.4 % for these shapes
  for (const Capacitor& c : s.capacitors) {
    const double shape_factor = s.disc_diameter_m / (4 * c.layers.front().thickness_m);
    expected += s.c0_F(c) / bonded_modulus_Pa(mu, m.poisson_ratio, shape_factor);
  }
  expect_relative(initial_slope_fF_kPa(s) * 1e-18, expected, 5e-3);
  Specimen open = s;
  open.faces = Faces::bonded_base;
  EXPECT_GT(initial_slope_fF_kPa(open), 2 * initial_slope_fF_kPa(s));
}

TEST(Faces, ListedRigidFilmsAndImpliedOnesHoldAlike) {
  Specimen listed = shipped("paper-2");
  listed.faces = Faces::bonded_laminate;
  Specimen implied = listed;
  for (Capacitor& c : implied.capacitors) c.layers.resize(1);  // PDMS alone
  const auto shortening = [](const Specimen& s) {
    return linear(s)->at_pressure(10.0_kPa)->shortening_m;
  };
  expect_relative(shortening(implied), shortening(listed), 1e-9);
}

TEST(Faces, ALaminateCannotBeCutAnewOverOneField) {
  Specimen s = soft_stack({1e-3});
  s.faces = Faces::bonded_laminate;
  const auto cut = linear(s, 0)->at_pressure(1.0_kPa, {0.5e-3, 0.5e-3});
  ASSERT_FALSE(cut);
  EXPECT_THAT(cut.error().what, testing::HasSubstr("films"));
}

TEST(Mesh, LimitFollowsTheMachinesMemory) {
  EXPECT_GE(affordable_unknowns(), 10'000U);
  EXPECT_LE(affordable_unknowns(), 3'000'000U);
}

}  // namespace
}  // namespace lcrig
