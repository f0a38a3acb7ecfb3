// SPDX-License-Identifier: Apache-2.0
// What must hold for the model's errors on stacks to which nothing was fitted. model_study judges
// many of them (docs/model.md, "Auto"). These are as many as every push can afford.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "model/auto_level.hpp"
#include "model/fem_space.hpp"
#include "tests/support/stack_truth.hpp"

namespace lcrig {
namespace {

using namespace literals;

// Neither the seeds of the study nor those that something was tuned on (1 to 120).
constexpr std::uint64_t kFirstSeed = 500'001;
constexpr std::uint64_t kStacks = 12;
constexpr std::size_t kMostLayers = 8;  // a scene for a push, not for a night

template <class Judge>
void for_each_stack(const Judge& judge) {
  std::uint64_t judged = 0;
  for (std::uint64_t seed = kFirstSeed; judged < kStacks; ++seed) {
    if (random_stack(seed).layer_count() > kMostLayers) continue;
    ++judged;
    judge(seed);
  }
}

JudgePlan short_plan() {
  JudgePlan plan;
  plan.pressure_Pa = {10e3};
  plan.finest_linear = plan.finest_finite = 0;
  plan.truth_linear = 3;
  plan.truth_finite = 1;
  return plan;
}

TEST(RandomStacks, EstimatesCoverTheErrorAndAreNotFarAboveIt) {
  int judged = 0, below = 0, far_above = 0;
  for_each_stack([&](std::uint64_t seed) {
    judge_stack(seed, short_plan(), [&](const Judged& j) {
      if (!j.counts()) return;
      ++judged;
      below += j.ratio() < 1;
      far_above += j.ratio() > 10;
      EXPECT_GE(j.ratio(), 0.5) << "seed " << j.seed << " " << j.level << " mesh " << j.mesh;
    });
  });
  EXPECT_GE(judged, 20);
  EXPECT_LE(below, judged / 20);
  EXPECT_LE(far_above, judged / 10);
}

// bench/fenicsx/truths.csv: the slope at zero load by FEniCSx, independent of our elements.
TEST(RandomStacks, EstimatesCoverTheDifferenceToAnotherCode) {
  std::ifstream file("bench/fenicsx/truths.csv");
  ASSERT_TRUE(file) << "run from the root of the source tree";
  int judged = 0, far_above = 0;
  for (const SlopeTruth& truth : read_slope_truths(file)) {
    if (random_stack(truth.seed).layer_count() > kMostLayers) continue;
    judge_slope(truth, 1, [&](const Judged& j) {
      if (!j.counts()) return;
      ++judged;
      far_above += j.ratio() > 10;
      EXPECT_GE(j.ratio(), 1) << "seed " << j.seed << " mesh " << j.mesh;
    });
  }
  EXPECT_GE(judged, 20);
  EXPECT_LE(far_above, judged / 10);
}

TEST(RandomStacks, EachMeshHalvesTheErrorAtLeast) {
  for_each_stack([](std::uint64_t seed) {
    ErrorEstimator solved(random_stack(seed));
    std::vector<double> delta;
    for (int mesh = -1; mesh <= 2; ++mesh) {
      LevelSettings settings;
      settings.level = Level::fem_linear;
      settings.mesh.refinement = mesh;
      const auto value = solved.delta_F(settings, Pressure::from_si(1.0));
      ASSERT_TRUE(value) << value.error().what;
      delta.push_back(*value);
    }
    const double first = delta[1] - delta[0], second = delta[2] - delta[1];
    const double third = delta[3] - delta[2];
    // Each step is about half of the one before; a single one may be small by chance.
    EXPECT_LE(std::abs(third), std::abs(first) / 4) << seed;
    EXPECT_LE(std::abs(third), std::abs(second) / 2 + 1e-7 * delta[3]) << seed;
  });
}

// Blocks of one material that electrodes cut. When electrodes lay inside rows, the coarse meshes of
// these stacks agreed by chance, and estimates were only 0.006 to 0.4 times the error.
TEST(RandomStacks, ElectrodesInsideOfABlockLeaveNoErrorUnseen) {
  struct Case {
    std::uint64_t seed;
    Level level;
    double pressure_kPa;
  };
  for (const Case& c : {Case{2'000'963, Level::fem_finite, 10},
                        {2'001'030, Level::fem_finite, 100},
                        {2'001'652, Level::fem_finite, 30},
                        {2'001'199, Level::fem_linear, 1e-3},
                        {4'000'019, Level::fem_linear, 1e-3}}) {
    ErrorEstimator solved(random_stack(c.seed));
    const Pressure pressure = Pressure::from_si(1e3 * c.pressure_kPa);
    LevelSettings settings;
    settings.level = c.level;
    settings.mesh.refinement = 0;
    const auto limit = solved.mesh_limit(settings, pressure);
    const auto mine = solved.delta_F(settings, pressure);
    const auto truth = find_truth(solved, c.level, c.level == Level::fem_linear ? 3 : 2, pressure);
    ASSERT_TRUE(limit && mine && truth) << c.seed;
    const double estimate = std::abs(*mine - limit->value) + kDoubtFactor * limit->doubt;
    const double error = std::abs(*mine - truth->value_F);
    EXPECT_TRUE(limit->settled) << c.seed;
    EXPECT_GE(estimate, error) << c.seed;
    EXPECT_LE(estimate, 10 * error) << c.seed;
  }
}

TEST(RandomStacks, RowsEndAtTheElectrodesInsideOfABlock) {
  const Specimen s = random_stack(2'000'963);
  for (const bool finite : {false, true}) {
    for (int mesh = kCoarsestMember; mesh <= 1; ++mesh) {
      const auto space = StackSpace::make(s, MeshSettings{mesh}, finite);
      ASSERT_TRUE(space);
      for (const auto& capacitor : space->capacitors()) {
        EXPECT_NEAR(capacitor.front().bottom.zeta, -1, 1e-4);
        EXPECT_NEAR(capacitor.back().top.zeta, 1, 1e-4);
      }
    }
  }
}

// On this stack the finest mesh of finite strain, mesh 2, has no solution above 22.6 kPa. It was
// once chosen, and then there was no curve.
TEST(RandomStacks, AutoTakesNoMeshWithoutAnAnswer) {
  const Specimen s = random_stack(16'000'015);
  const Pressure pressure = 30.0_kPa;
  const auto refused = choose_level(s, 0.01, pressure);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("(mesh 2) has no solution beyond"), std::string::npos)
      << refused.error().what;
  const auto choice = choose_level(s, 0.02, pressure);
  ASSERT_TRUE(choice) << choice.error().what;
  const auto model = make_level_model(s, choice->settings);
  ASSERT_TRUE(model);
  EXPECT_TRUE((*model)->at_pressure(pressure));
}

TEST(RandomStacks, AutoKeepsTheToleranceOrRefuses) {
  int chosen = 0;
  for_each_stack([&](std::uint64_t seed) {
    ErrorEstimator solved(random_stack(seed));
    const auto truth = find_finite_truth(solved, 1, 3, 10.0_kPa);
    for (const double tolerance : {0.1, 1e-2}) {
      const auto choice = choose_level(solved, tolerance, 10.0_kPa);
      if (!choice) {
        EXPECT_NE(choice.error().what.find("can be met"), std::string::npos) << choice.error().what;
        continue;
      }
      EXPECT_LE(choice->error_estimate, tolerance);
      if (!truth || choice->lost_beyond || truth->doubt_F > tolerance / 10 * truth->value_F) {
        continue;
      }
      ++chosen;
      const double delta = solved.delta_F(choice->settings, 10.0_kPa).value();
      EXPECT_LE(std::abs(delta / truth->value_F - 1), tolerance) << seed << " " << choice->reason;
    }
  });
  EXPECT_GE(chosen, 10);
}

TEST(RandomStacks, ABudgetEndsTheSearch) {
  double time = 0;
  const SearchTime patience{3, [&] { return time += 0.5; }};
  const auto choice = choose_level(random_stack(kFirstSeed), 1e-9, 10.0_kPa, patience);
  ASSERT_FALSE(choice);
  EXPECT_NE(choice.error().what.find("over the limit of"), std::string::npos)
      << choice.error().what;
}

TEST(RandomStacks, AModulusOfNoSolidIsRefused) {
  for (const double modulus_Pa : {0.0, 5e-324, 1e-310, 1e300, HUGE_VAL, std::nan("")}) {
    Specimen s = random_stack(kFirstSeed);
    s.materials.front().youngs_modulus_Pa = modulus_Pa;
    EXPECT_FALSE(choose_level(s, 1e-2, 10.0_kPa)) << modulus_Pa;
  }
}

// A soft block that folds over below the largest load: the estimate refers to where that is.
TEST(RandomStacks, AnEstimateBeyondTheLastSolutionSaysWhereThatIs) {
  Specimen s = random_stack(26);  // four soft-topped capacitors of 78 kPa
  ErrorEstimator estimator(s);
  LevelSettings settings;
  settings.level = Level::fem_finite;
  settings.mesh.refinement = 0;
  const auto estimate = estimator.estimate(settings, Pressure::from_si(1e6));
  ASSERT_TRUE(estimate) << estimate.error().what;
  ASSERT_TRUE(estimate->lost_beyond);
  EXPECT_LT(*estimate->lost_beyond, Pressure::from_si(1e6));
  EXPECT_FALSE(estimator.delta_F(settings, Pressure::from_si(1e6)));
  EXPECT_TRUE(estimator.delta_F(settings, *estimate->lost_beyond));
}

// A soft top whose rim bulges until its electrode would be below the next one.
TEST(RandomStacks, ALayerThatClosesSaysAtWhichLoad) {
  ErrorEstimator estimator(random_stack(1'000'035));
  LevelSettings settings;
  settings.level = Level::fem_finite;
  settings.mesh.refinement = -1;
  const auto closed = estimator.delta_F(settings, 30.0_kPa);
  ASSERT_FALSE(closed);
  const std::string& what = closed.error().what;
  EXPECT_NE(what.find("a layer has closed"), std::string::npos) << what;
  const std::string before = "at 30 kPa; the largest load before is ";
  ASSERT_NE(what.find(before), std::string::npos) << what;
  const double open_kPa = std::stod(what.substr(what.find(before) + before.size()));
  EXPECT_LT(open_kPa, 30);
  EXPECT_TRUE(estimator.delta_F(settings, Pressure::from_si(open_kPa * 999)));
}

}  // namespace
}  // namespace lcrig
