// SPDX-License-Identifier: Apache-2.0
// Many pairs of rig and protocol against one property: drawn from seeds, shrunk when they fail,
// counted. docs/testing.md says how to run a big one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/property/trial.hpp"

namespace lcrig::property {

// What a sweep makes of each pair before it is run.
struct Kind {
  std::string name;  // of the property, in files and messages
  double share = 1;  // of LCRIG_PAIRS
  bool lies = false;
  int beyond = 0;  // of 1000 protocols, so many go beyond the rig's abilities
  // What happens in the middle; may be empty. Drawn from the number given.
  std::function<void(std::uint64_t draw, Case&)> disturb;
  // Told of each pair once, when it was judged. May be empty.
  std::function<void(Trial&)> note = {};
};
using Judge = std::function<Broken(Trial&, Counters&)>;

struct Worst {
  double over_limit_N = -1e9, over_limit_of_uncertainty = -1e9, overshoot_ratio = 0;
  std::uint64_t over_limit_seed = 0, overshoot_seed = 0;
};

struct Summary {
  std::int64_t pairs = 0, held = 0;
  Counters counters;
  Worst worst;
  std::vector<std::string> failures;  // each with a case that shows it
};

// Runs it, writes what LCRIG_SWEEP asks for, and tells GoogleTest of failures and of counters
// that stayed 0.
Summary sweep(const Kind& kind, const Judge& judge, const std::vector<std::string>& sometimes);

}  // namespace lcrig::property
