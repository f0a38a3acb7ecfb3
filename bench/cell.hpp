// SPDX-License-Identifier: Apache-2.0
// One line of a table of coverage: how often the intervals of one result held in one world.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "bench/worlds.hpp"

namespace lcrig::worlds {

struct Cell {
  int runs = 0, held = 0, budgets = 0, expanded_held = 0;
  double bias = 0, squares = 0, half = 0, expanded = 0, own_squares = 0, truth = 0;
  void add(const Judged& j) {
    ++runs;
    const auto& i = *j.estimate.interval;
    held += i[0] <= j.of_rig && j.of_rig <= i[1] ? 1 : 0;
    const double error = j.estimate.value - j.of_rig, own = j.estimate.value - j.own;
    bias += error;
    squares += error * error;
    half += (i[1] - i[0]) / 2;
    truth += std::abs(j.of_rig);
    own_squares += own * own;
    if (!j.expanded) return;
    ++budgets;
    expanded_held += std::abs(own) <= *j.expanded ? 1 : 0;
    expanded += *j.expanded;
  }
};

inline void print_header() {
  fmt::print("{:<30} {:<40} {:>5} {:>7} {:>7} {:>9} {:>9} {:>8} {:>9} {:>8}\n", "world", "result",
             "runs", "ci95_%", "exp_%", "bias_%", "half_%", "x_needed", "exp_half%", "x_needed");
}

// Prints half-widths beside the width that the errors need, 1.96 times their root mean square.
inline void print(const std::string& world, const std::string& result, const Cell& c) {
  // In percent of the truth. A result that ought to be 0 is in percent already.
  const double n = c.runs, truth = c.truth > 0 ? c.truth / n : 100;
  fmt::print("{:<30} {:<40} {:>5} {:>7.1f} {:>7.1f} {:>9.3f} {:>9.3f} {:>8.2f} {:>9.3f} {:>8.2f}\n",
             world, result, c.runs, 100 * c.held / n,
             c.budgets > 0 ? 100.0 * c.expanded_held / c.budgets : NAN, c.bias / n / truth * 100,
             c.half / n / truth * 100, c.half / n / (1.96 * std::sqrt(c.squares / n)),
             c.budgets > 0 ? c.expanded / c.budgets / truth * 100 : NAN,
             c.budgets > 0 ? c.expanded / c.budgets / (1.96 * std::sqrt(c.own_squares / n)) : NAN);
  std::fflush(stdout);
}

}  // namespace lcrig::worlds
