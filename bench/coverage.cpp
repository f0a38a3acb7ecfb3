// SPDX-License-Identifier: Apache-2.0
// Measures how often `ci95` and the expanded uncertainty contain the true values, in rehearsals on
// a bench with the errors of real ones (docs/simulator.md). Run it from the source tree.
//
//   coverage_bench [SEEDS=600] [FIRST_SEED=1] [levels|cycles|all] [REPEATS=4]
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "base/log.hpp"
#include "bench/cell.hpp"
#include "bench/realistic.hpp"

namespace {

using namespace lcrig::worlds;

void measure(const Rehearsed& what, int seeds, int first, const std::string& folder) {
  std::map<std::string, Cell> cells;
  for (int seed = first; seed < first + seeds; ++seed) {
    for (const Judged& j : judge_on_bench(what, static_cast<std::uint64_t>(seed), folder)) {
      cells[j.result].add(j);
    }
  }
  for (const auto& [result, counts] : cells) print(what.name, result, counts);
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  const int seeds = number(1, 600), first = number(2, 1), repeats = number(4, 4);
  const std::string what = argc > 3 ? argv[3] : "all";
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("coverage-{}", ::getpid());
  std::filesystem::create_directories(folder);
  lcrig::set_up_logging("warn");
  print_header();
  if (what != "cycles") measure(rehearsed_levels(repeats, 30), seeds, first, folder.string());
  if (what != "levels") measure(rehearsed_cycles(repeats), seeds, first, folder.string());
  std::filesystem::remove_all(folder);
}
