// SPDX-License-Identifier: Apache-2.0
// Measures how often `ci95` and the expanded uncertainty contain the true values under disturbances
// (the table of docs/analysis.md). It uses no instrument and no protocol. It takes only the times
// and forces of a synthetic or recorded run and computes new capacitances, so 600 seeds take
// minutes.
//
//   coverage_worlds_bench [SEEDS=200] [FIRST_SEED=1] [REPEATS=4] [static|dynamic|real|all] [WORLD]
//   coverage_worlds_bench ... recorded WORLD|'' FILE.db RUN    times and forces of that run
#include <cstdlib>
#include <map>
#include <string>

#include "bench/cell.hpp"
#include "bench/worlds.hpp"
#include "storage/database.hpp"

namespace {

using namespace lcrig;
using namespace lcrig::worlds;

void run(const RunData& shape, const std::vector<World>& list, int seeds, int first,
         const std::string& only) {
  const TrueSpecimen specimen = straight_and_bent();
  std::uint64_t cell = 0;  // each world gets its own random numbers
  for (const World& w : list) {
    cell += 100'000;
    if (!only.empty() && w.name.find(only) == std::string::npos) continue;
    std::map<std::string, Cell> cells;
    for (int seed = first; seed < first + seeds; ++seed) {
      const MadeRun made = rewrite(shape, specimen, w, cell + static_cast<std::uint64_t>(seed));
      for (const Judged& j : judge(made, specimen, w)) cells[j.result].add(j);
    }
    for (const auto& [result, counts] : cells) print(w.name, result, counts);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  const int seeds = number(1, 200), first = number(2, 1), repeats = number(3, 4);
  const std::string what = argc > 4 ? argv[4] : "all", only = argc > 5 ? argv[5] : "";
  print_header();
  if (what == "recorded" && argc > 7) {
    const auto db = open_read_only(argv[6]).value();
    run(load_run_data(db, number(7, 1)).value(), static_worlds(), seeds, first, only);
    return 0;
  }
  StaticShape shape;
  shape.repeats = repeats;
  DynamicShape cycles;
  cycles.cycles = repeats;
  if (what == "static" || what == "all") {
    run(static_run(shape), static_worlds(), seeds, first, only);
  }
  if (what == "real" || what == "all") {
    run(static_run(shape), {realistic_world()}, seeds, first, only);
  }
  if (what == "slow" || what == "all") {
    run(static_run(shape), slow_worlds(), seeds, first, only);
    run(dynamic_run(cycles), slow_worlds(), seeds, first, only);
  }
  if (what == "dynamic" || what == "all") {
    run(dynamic_run(cycles), dynamic_worlds(), seeds, first, only);
  }
}
