// SPDX-License-Identifier: Apache-2.0
// Random protocols. A recipe is a few small numbers that know nothing of a rig: RapidCheck draws
// and shrinks them. `write_protocol` makes of it a file for one rig, with speeds and forces that
// our own arithmetic says the rig can do, or on purpose beyond them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::property {

struct Choice {
  Choice() = default;
  int kind = 0;
  std::array<int, 4> at{};  // 0 to 1000: where in its range each number lies
};

struct Recipe {
  Recipe() = default;
  int beyond = 0;  // 0: everything within; else so many thousandths of the steps are not
  std::array<int, 10> base{};  // of limits, contact and samples
  std::vector<Choice> steps;
};

struct Written {
  Written() = default;
  std::string text;
  double gap_m = 0;  // of the rig at the start, so that the way is not too long
  bool presses = false;
};

constexpr int kKindsOfSteps = 20;
Written write_protocol(const Recipe& recipe, const sim::RandomRig& rig);

}  // namespace lcrig::property
