// SPDX-License-Identifier: Apache-2.0
// Compares the model's error estimates with the true errors, over seeded stacks. Prints one line of
// CSV for each answer of each level, then the shares that docs/model.md quotes.
//   model_study FIRST_SEED COUNT [PRESSURE_kPa ...]   without pressures: small strains alone
//   model_study describe FIRST_SEED COUNT             the stacks as JSON lines, for other codes
//   model_study judge < truths.csv                    against bench/fenicsx/truths.py
//   model_study race [PRESSURE_kPa] < truths.csv      seconds, against its coarsest mesh
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/stack_truth.hpp"

namespace lcrig {
namespace {

struct Share {
  std::vector<double> ratio;
  int met = 0;  // estimate and error both negligible
  int left_out = 0;  // without a good enough truth
};

void print_share(const std::string& level, Share& share) {
  auto& r = share.ratio;
  if (r.empty()) {
    std::printf("# %-26s     0 judged, %5d negligible, %5d not\n", level.c_str(), share.met,
                share.left_out);
    return;
  }
  std::sort(r.begin(), r.end());
  const auto below = [&](double limit) {
    return static_cast<double>(std::lower_bound(r.begin(), r.end(), limit) - r.begin()) /
           static_cast<double>(r.size());
  };
  std::printf(
      "# %-26s %5zu judged, %5d negligible, %5d not: below 0.5 %.2f %%, below 1 %.2f %%, 1 to 10 "
      "%.1f %%, "
      "median %.2f, least %.2f, most %.3g\n",
      level.c_str(), r.size(), share.met, share.left_out, 100 * below(0.5), 100 * below(1),
      100 * (below(10) - below(1)), r[r.size() / 2], r.front(), r.back());
}

void print(const Judged& j, std::map<std::string, Share>& shares) {
  std::printf("%llu,%g,%s,%d,%.3e,%.3e,%.1e,%.2f,%d,%d\n", static_cast<unsigned long long>(j.seed),
              j.pressure_Pa / 1e3, j.level.c_str(), j.mesh, j.estimate, j.error, j.truth_doubt,
              j.order, j.settled, j.counts());
  const bool one_mesh = j.level.substr(0, 3) != "fem";
  Share& share = shares[one_mesh ? j.level : fmt::format("{}, mesh {}", j.level, j.mesh)];
  if (j.met()) {
    ++share.met;
  } else if (j.counts()) {
    share.ratio.push_back(j.ratio());
  } else {
    ++share.left_out;
  }
}

// The finest meshes take up to a minute if there are more layers. Such stacks are judged by coarser
// truths, and without `auto`.
constexpr std::size_t kMostLayers = 4;

constexpr const char* kColumns =
    "seed,pressure_kPa,level,mesh,estimate,error,truth_doubt,order,settled,counts\n";

int run(std::uint64_t first, std::uint64_t count, const JudgePlan& plan) {
  std::map<std::string, Share> shares;
  std::printf("%s", kColumns);
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    JudgePlan mine = plan;
    if (random_stack(seed).layer_count() > kMostLayers) {
      --mine.truth_linear;
      --mine.truth_finite;
      mine.tolerance.clear();
    }
    mine.finest_finite = mine.truth_finite - 1;
    judge_stack(seed, mine, [&](const Judged& j) { print(j, shares); });
    std::fflush(stdout);
  }
  for (auto& [level, share] : shares) print_share(level, share);
  return 0;
}

int judge_by_other_code() {
  std::map<std::string, Share> shares;
  std::printf("%s", kColumns);
  for (const SlopeTruth& truth : read_slope_truths(std::cin)) {
    judge_slope(truth, 2, [&](const Judged& j) { print(j, shares); });
    std::fflush(stdout);
  }
  for (auto& [level, share] : shares) print_share(level, share);
  return 0;
}

const Pressure kTiny = Pressure::from_si(1e-3);

struct Timed {
  double value_F = 0, alone_s = 0, with_estimate_s = 0;  // processor seconds, medians of three
};

// The problem of one race: at small strain, or at a pressure and finite strain.
struct RaceScene {
  Specimen specimen;
  Level level = Level::fem_linear;
  Pressure pressure = kTiny;
};

std::optional<Timed> time_mesh(const RaceScene& scene, int mesh) {
  const auto now = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  LevelSettings settings;
  settings.level = scene.level;
  settings.mesh.refinement = mesh;
  Timed result;
  std::array<double, 3> alone{}, with_estimate{};
  for (std::size_t i = 0; i < alone.size(); ++i) {
    ErrorEstimator solved(scene.specimen);
    const double began = now();
    const auto mine = solved.delta_F(settings, scene.pressure);
    alone[i] = now() - began;
    if (!mine || !solved.mesh_limit(settings, scene.pressure)) return std::nullopt;
    with_estimate[i] = now() - began;
    result.value_F = *mine;
  }
  std::sort(alone.begin(), alone.end());
  std::sort(with_estimate.begin(), with_estimate.end());
  result.alone_s = alone[1];
  result.with_estimate_s = with_estimate[1];
  return result;
}

struct Race {
  std::vector<double> alone, with_estimate;  // speed-up factors, by scene
};

// Finds our coarsest mesh whose error is at most that of the other code's coarsest mesh, and its
// processor seconds with and without the estimate. Both are judged by the limit of our finest
// meshes, where this is known to a tenth of the other code's error. `other_unit` converts its
// values to F.
void race_one(const SlopeTruth& other, const RaceScene& scene, double other_unit, Race& ratios) {
  ErrorEstimator solved(scene.specimen);
  const auto truth = scene.level == Level::fem_linear
                         ? find_truth(solved, scene.level, kFinestMember, scene.pressure)
                         : find_finite_truth(solved, 2, kFinestMember, scene.pressure);
  const auto error_of = [&](double value_F) { return std::abs(value_F / truth->value_F - 1); };
  const auto seed = static_cast<unsigned long long>(other.seed);
  if (!truth || truth->doubt_F / truth->value_F > error_of(other.coarse_F_Pa * other_unit) / 10) {
    std::printf("# %llu has no truth\n", seed);
    return;
  }
  const double other_error = error_of(other.coarse_F_Pa * other_unit);
  for (int mesh = 0; mesh <= kFinestMesh; ++mesh) {
    const auto mine = time_mesh(scene, mesh);
    if (!mine || (error_of(mine->value_F) > other_error && mesh < kFinestMesh)) continue;
    std::printf("%llu,%d,%.2e,%.2e,%.4f,%.4f,%.3f,%.1e,%.1e\n", seed, mesh, error_of(mine->value_F),
                other_error, mine->alone_s, mine->with_estimate_s, *other.coarse_s,
                truth->doubt_F / truth->value_F, error_of(other.slope_F_Pa * other_unit));
    std::fflush(stdout);
    ratios.alone.push_back(*other.coarse_s / mine->alone_s);
    ratios.with_estimate.push_back(*other.coarse_s / mine->with_estimate_s);
    return;
  }
}

void print_times(const char* what, std::vector<double> faster) {
  if (faster.empty()) return;
  std::sort(faster.begin(), faster.end());
  const double median = (faster[(faster.size() - 1) / 2] + faster[faster.size() / 2]) / 2;
  std::printf("# %zu scenes, %s: faster by %.1f in the median, %.1f at least, %.1f at most\n",
              faster.size(), what, median, faster.front(), faster.back());
}

int race(std::optional<Pressure> pressure) {
  std::printf(
      "seed,mesh,error,other_error,seconds,seconds_with_estimate,other_seconds,truth_doubt,"
      "difference_of_limits\n");
  Race ratios;
  for (const SlopeTruth& truth : read_slope_truths(std::cin)) {
    if (!truth.coarse_s) continue;
    RaceScene scene{random_stack(truth.seed)};
    if (pressure) scene = {scene.specimen, Level::fem_finite, *pressure};
    // At finite strain the table has changes in fF, which its reader took for fF/kPa.
    race_one(truth, scene, pressure ? 1e3 : scene.pressure.si(), ratios);
  }
  print_times("without the estimate", ratios.alone);
  print_times("with the estimate", ratios.with_estimate);
  return 0;
}

void describe_layer(const Specimen& s, std::size_t capacitor, const Layer& layer, bool first) {
  const Material& m = s.material(layer);
  std::printf(
      "%s{\"capacitor\":%zu,\"thickness_mm\":%.17g,\"relative_permittivity\":%.17g,"
      "\"youngs_modulus_kPa\":%.17g,\"poisson_ratio\":%.17g,\"rigid\":%s,\"soft\":%s}",
      first ? "" : ",", capacitor, layer.thickness_m * 1e3, m.relative_permittivity,
      m.youngs_modulus_Pa / 1e3, m.poisson_ratio, m.rigid ? "true" : "false",
      s.is_soft(m) ? "true" : "false");
}

int describe(std::uint64_t first, std::uint64_t count) {
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const Specimen s = random_stack(seed);
    std::printf(R"({"seed":%llu,"diameter_mm":%.17g,"faces":"%s","top":"%s","layers":[)",
                static_cast<unsigned long long>(seed), s.disc_diameter_m * 1e3,
                std::string(to_string(s.faces)).c_str(), std::string(to_string(s.top)).c_str());
    for (std::size_t i = 0; i < s.capacitors.size(); ++i) {
      for (const Layer& layer : s.capacitors[i].layers) {
        describe_layer(s, i, layer, i == 0 && &layer == &s.capacitors[0].layers[0]);
      }
    }
    std::printf("]}\n");
  }
  return 0;
}

std::uint64_t whole(const char* text) {
  return std::strtoull(text, nullptr, 10);
}

}  // namespace
}  // namespace lcrig

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "judge") return lcrig::judge_by_other_code();
  if ((argc == 2 || argc == 3) && std::string(argv[1]) == "race") {
    std::optional<lcrig::Pressure> pressure;
    if (argc == 3) pressure = lcrig::Pressure::from_si(1e3 * std::strtod(argv[2], nullptr));
    return lcrig::race(pressure);
  }
  if (argc == 4 && std::string(argv[1]) == "describe") {
    return lcrig::describe(lcrig::whole(argv[2]), lcrig::whole(argv[3]));
  }
  if (argc < 3) {
    std::fprintf(stderr,
                 "usage: model_study FIRST_SEED COUNT [PRESSURE_kPa ...]\n"
                 "       model_study describe FIRST_SEED COUNT\n"
                 "       model_study judge < truths.csv\n"
                 "       model_study race [PRESSURE_kPa] < truths.csv\n");
    return 2;
  }
  lcrig::JudgePlan plan;
  plan.pressure_Pa.clear();
  plan.truth_linear = lcrig::kFinestMember;
  plan.tolerance = {1e-2, 1e-3, 1e-4};
  for (int i = 3; i < argc; ++i) plan.pressure_Pa.push_back(1e3 * std::strtod(argv[i], nullptr));
  return lcrig::run(lcrig::whole(argv[1]), lcrig::whole(argv[2]), plan);
}
