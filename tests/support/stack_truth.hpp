// SPDX-License-Identifier: Apache-2.0
// Compares the answers of the levels for a random stack with solutions on finer meshes, and the
// estimated errors with the true ones. For tests/model_study and a unit test of the model.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <istream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "model/auto_level.hpp"
#include "tests/support/random_stack.hpp"

namespace lcrig {

// The judgement of one answer of one level.
struct Judged {
  std::uint64_t seed = 0;
  double pressure_Pa = 0;
  // A level; or "fem_linear (own)": the error of its mesh alone, at small strains; or "auto 0.001":
  // what `auto` chose at this tolerance; or "auto 0.001 refused": the tolerance, and the error of
  // the best level there is.
  std::string level;
  int mesh = 0;
  double estimate = 0, error = 0;  // relative
  double truth_doubt = 0;  // relative doubt in the truth that was used
  double order = 0;
  bool settled = true;
  double negligible = 1e-7;  // errors below this do not matter
  double ratio() const { return estimate / error; }
  // Estimate and error are both negligible, so their ratio means nothing.
  bool met() const {
    return estimate <= negligible && error <= negligible && truth_doubt <= negligible;
  }
  // The truth must be known better than the error by this factor. For meshes of finite strain no
  // truth is that good.
  double least_exactness = 100;
  bool counts() const { return !met() && truth_doubt <= error / least_exactness; }
};

inline double least_exactness(Level level) {
  return level == Level::fem_finite ? 10 : 100;
}

struct JudgePlan {
  std::vector<double> pressure_Pa{10e3, 30e3, 100e3};
  int finest_linear = 1, finest_finite = 1;  // finest meshes that are judged
  int truth_linear = 3, truth_finite = 2;  // finest meshes of the limits by which they are judged
  std::vector<double> tolerance;  // tolerances at which `auto` is judged
};

// Aitken's limit of three meshes that halve each other. The doubt is the distance to the limit of
// three others whose finest is one member coarser.
struct StackTruth {
  double value_F = 0, doubt_F = 0;
};

// `value` gives the answer on a mesh; nullopt: there is none.
inline std::optional<StackTruth> limit_of_halvings(
    int finest, int half_as_fine, const std::function<std::optional<double>(int mesh)>& value) {
  struct Limit {
    double value;
    bool falling;
  };
  const auto limit_to = [&](int mesh) -> std::optional<Limit> {
    const auto a = value(mesh - 2 * half_as_fine), b = value(mesh - half_as_fine), c = value(mesh);
    if (!a || !b || !c) return std::nullopt;
    const double before = *b - *a, last = *c - *b;
    const bool falling = std::abs(before) > 1.5 * std::abs(last);
    return Limit{falling ? *c + last * last / (before - last) : *c, falling};
  };
  const auto coarse = limit_to(finest - 1), fine = limit_to(finest);
  if (!coarse || !fine || !fine->falling) return std::nullopt;
  return StackTruth{fine->value, std::abs(fine->value - coarse->value)};
}

// At small strain every second member halves the cells, with finite strain every member does.
inline std::optional<StackTruth> find_truth(ErrorEstimator& solved, Level level, int finest,
                                            Pressure pressure) {
  return limit_of_halvings(finest, level == Level::fem_linear ? 2 : 1,
                           [&](int mesh) -> std::optional<double> {
                             LevelSettings settings;
                             settings.level = level;
                             settings.mesh.refinement = mesh;
                             const auto found = solved.delta_F(settings, pressure);
                             return found ? std::optional(*found) : std::nullopt;
                           });
}

// The truth for finite strain: the limit at small strain times the limit of the ratio of finite to
// small strain on the same meshes. The error at bonded corners is nearly the same in both, so the
// ratio converges better than either. nullopt when it does not converge: finite strain then only
// seems to converge, because its gain at small strain hides the rest. nullopt also when its own
// limit lies elsewhere.
inline std::optional<StackTruth> find_finite_truth(ErrorEstimator& solved, int finest,
                                                   int finest_linear, Pressure pressure) {
  const auto direct = find_truth(solved, Level::fem_finite, finest, pressure);
  const auto linear = find_truth(solved, Level::fem_linear, finest_linear, pressure);
  if (!direct || !linear) return direct;
  const auto share = limit_of_halvings(finest, 1, [&](int mesh) -> std::optional<double> {
    LevelSettings settings;
    settings.mesh = {mesh, true};
    settings.level = Level::fem_linear;
    const auto small = solved.delta_F(settings, pressure);
    settings.mesh.mild_corners = false;
    settings.level = Level::fem_finite;
    const auto large = solved.delta_F(settings, pressure);
    return small && large ? std::optional(*large / *small) : std::nullopt;
  });
  if (!share) return std::nullopt;
  const StackTruth product{linear->value_F * share->value_F,
                           linear->doubt_F * share->value_F + linear->value_F * share->doubt_F};
  if (std::abs(product.value_F - direct->value_F) > direct->doubt_F + product.doubt_F) {
    return std::nullopt;
  }
  return product.doubt_F < direct->doubt_F ? product : direct;
}

// Judges the mesh of one answer at small strain alone.
inline std::optional<Judged> judge_mesh(ErrorEstimator& solved, std::uint64_t seed, int mesh,
                                        Pressure pressure, const StackTruth& truth) {
  LevelSettings settings;
  settings.level = Level::fem_linear;
  settings.mesh.refinement = mesh;
  const auto limit = solved.mesh_limit(settings, pressure);
  const auto mine = solved.delta_F(settings, pressure);
  if (!limit || !mine) return std::nullopt;
  const double doubt = kDoubtFactor * limit->doubt;
  Judged j;
  j.seed = seed;
  j.pressure_Pa = pressure.si();
  j.level = "fem_linear (own)";
  j.mesh = mesh;
  j.estimate = (std::abs(*mine - limit->value) + doubt) / (limit->value - doubt);
  j.error = std::abs(*mine / truth.value_F - 1);
  j.truth_doubt = truth.doubt_F / truth.value_F;
  j.order = limit->order;
  j.settled = limit->settled;
  return j;
}

// A stack's slope at zero load from another code, and how much its last refinement changed it.
struct SlopeTruth {
  std::uint64_t seed = 0;
  double slope_F_Pa = 0, doubt_F_Pa = 0;
  // of its coarsest mesh: slope and processor seconds; older tables have no seconds
  double coarse_F_Pa = 0;
  std::optional<double> coarse_s;
};

// Reads the table that bench/fenicsx/truths.py writes.
inline std::vector<SlopeTruth> read_slope_truths(std::istream& in) {
  constexpr double kPerPa = 1e-15 / 1e3;  // from fF/kPa
  std::vector<SlopeTruth> truths;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || std::isdigit(static_cast<unsigned char>(line[0])) == 0) continue;
    std::stringstream cells(line);
    std::vector<double> v;
    for (std::string cell; std::getline(cells, cell, ',');) v.push_back(std::stod(cell));
    const double before = v.at(6), last = v.at(7);
    truths.push_back({static_cast<std::uint64_t>(v.at(0)), last * kPerPa,
                      std::abs(last - before) * kPerPa, v.at(5) * kPerPa,
                      v.size() > 8 ? std::optional(v[8]) : std::nullopt});
  }
  return truths;
}

inline void judge_slope(const SlopeTruth& truth, int finest_mesh,
                        const std::function<void(const Judged&)>& take) {
  const Specimen s = random_stack(truth.seed);
  ErrorEstimator solved(s);
  const Pressure tiny = Pressure::from_si(1e-3);
  const StackTruth at{truth.slope_F_Pa * tiny.si(), truth.doubt_F_Pa * tiny.si()};
  for (int mesh = 0; mesh <= finest_mesh; ++mesh) {
    auto j = judge_mesh(solved, truth.seed, mesh, tiny, at);
    if (!j) continue;
    // the doubt is the change by the last refinement, of which about a tenth is left
    j->least_exactness = 10;
    take(*j);
  }
}

inline void judge_own_mesh(ErrorEstimator& solved, const JudgePlan& plan, std::uint64_t seed,
                           const std::function<void(const Judged&)>& take) {
  const Pressure tiny = Pressure::from_si(1.0);
  const auto truth = find_truth(solved, Level::fem_linear, plan.truth_linear, tiny);
  if (!truth) return;
  for (int mesh = 0; mesh <= plan.finest_linear; ++mesh) {
    if (const auto j = judge_mesh(solved, seed, mesh, tiny, *truth)) take(*j);
  }
}

inline std::vector<LevelSettings> judged_levels(const Specimen& s, const JudgePlan& plan) {
  std::vector<LevelSettings> list;
  const auto add = [&](Level level, int mesh) {
    LevelSettings settings;
    settings.level = level;
    settings.mesh.refinement = mesh;
    list.push_back(settings);
  };
  add(Level::linear, 0);
  if (s.faces == Faces::bonded_laminate) add(Level::bonded, 0);
  for (int mesh = 0; mesh <= plan.finest_linear; ++mesh) add(Level::fem_linear, mesh);
  for (int mesh = 0; mesh <= plan.finest_finite; ++mesh) add(Level::fem_finite, mesh);
  return list;
}

inline void judge_levels(ErrorEstimator& solved, const JudgePlan& plan, const Judged& blank,
                         const StackTruth& truth, const std::function<void(const Judged&)>& take) {
  const Pressure pressure = Pressure::from_si(blank.pressure_Pa);
  for (const LevelSettings& settings : judged_levels(solved.specimen(), plan)) {
    const auto mine = solved.delta_F(settings, pressure);
    const auto estimate = solved.estimate(settings, pressure);
    if (!mine || !estimate || estimate->lost_beyond) continue;
    Judged j = blank;
    j.level = std::string(to_string(settings.level));
    j.mesh = settings.mesh.refinement;
    j.estimate = estimate->relative;
    j.error = std::abs(*mine / truth.value_F - 1);
    j.order = estimate->order;
    j.settled = estimate->settled;
    j.least_exactness = least_exactness(settings.level);
    take(j);
  }
}

// `least_error`: error of the best level that was judged.
inline void judge_auto(ErrorEstimator& solved, double tolerance, double least_error,
                       const Judged& blank, const StackTruth& truth,
                       const std::function<void(const Judged&)>& take) {
  const Pressure pressure = Pressure::from_si(blank.pressure_Pa);
  const auto choice = choose_level(solved, tolerance, pressure);
  Judged j = blank;
  j.level = fmt::format("auto {:g}{}", tolerance, choice ? "" : " refused");
  if (!choice) {
    j.estimate = tolerance;
    j.error = least_error;
    take(j);
    return;
  }
  const auto mine = solved.delta_F(choice->settings, pressure);
  if (!mine || choice->lost_beyond) return;
  j.negligible = tolerance / 10;
  j.mesh = choice->settings.mesh.refinement;
  j.estimate = choice->error_estimate;
  j.least_exactness = least_exactness(choice->settings.level);
  j.error = std::abs(*mine / truth.value_F - 1);
  take(j);
}

inline void judge_stack(std::uint64_t seed, const JudgePlan& plan,
                        const std::function<void(const Judged&)>& take) {
  ErrorEstimator solved(random_stack(seed));
  judge_own_mesh(solved, plan, seed, take);
  for (const double pressure_Pa : plan.pressure_Pa) {
    const auto truth = find_finite_truth(solved, plan.truth_finite, plan.truth_linear,
                                         Pressure::from_si(pressure_Pa));
    if (!truth) continue;
    Judged blank;
    blank.seed = seed;
    blank.pressure_Pa = pressure_Pa;
    blank.truth_doubt = truth->doubt_F / truth->value_F;
    double least_error = std::numeric_limits<double>::infinity();
    judge_levels(solved, plan, blank, *truth, [&](const Judged& j) {
      least_error = std::min(least_error, j.error);
      take(j);
    });
    for (const double tolerance : plan.tolerance) {
      judge_auto(solved, tolerance, least_error, blank, *truth, take);
    }
  }
}

}  // namespace lcrig
