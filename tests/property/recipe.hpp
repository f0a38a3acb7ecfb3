// SPDX-License-Identifier: Apache-2.0
// Random protocols. A recipe is a few small integers that do not depend on a rig; RapidCheck draws
// and shrinks them. `write_protocol` turns a recipe into a protocol for one rig, with speeds and
// forces within what our own arithmetic allows, or deliberately beyond. Used by sweeps.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/lcrig-sim/random_rig.hpp"

namespace lcrig::property {

struct Choice {
  Choice() = default;
  int kind = 0;
  std::array<int, 4> at{};  // 0 to 1000: the place of each number in its range
};

struct Recipe {
  Recipe() = default;
  // 0: everything is within the rig's abilities; otherwise this many of 1000 steps go beyond
  int beyond = 0;
  std::array<int, 10> base{};  // for limits, contact and samples
  std::vector<Choice> steps;
};

struct Written {
  Written() = default;
  std::string text;
  double gap_m = 0;  // gap of the rig at the start, so that no distance takes too long
  bool presses = false;
};

constexpr int kKindsOfSteps = 20;
Written write_protocol(const Recipe& recipe, const sim::RandomRig& rig);

}  // namespace lcrig::property
