// SPDX-License-Identifier: Apache-2.0
// Tests one property on many pairs of rig and protocol that are drawn from seeds, and shrinks the
// failures. docs/testing.md says how to run a big sweep. Used by properties_test.cpp and
// lies_test.cpp.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/property/trial.hpp"

namespace lcrig::property {

// How a sweep prepares each pair before it is run.
struct Kind {
  std::string name;  // name of the property in files and messages
  double share = 1;  // number of pairs, as a share of LCRIG_PAIRS
  bool lies = false;
  int beyond = 0;  // this many of 1000 protocols go beyond the rig's abilities
  // Adds what happens in the middle of the run, drawn from `draw`. May be empty.
  std::function<void(std::uint64_t draw, Case&)> disturb;
  // Called once for each pair after it was judged. May be empty.
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
  std::vector<std::string> failures;  // what failed, and the case that shows it
};

// Runs the sweep, writes what LCRIG_SWEEP asks for, and reports to GoogleTest all failures, and
// those counters of `sometimes` that stayed 0.
Summary sweep(const Kind& kind, const Judge& judge, const std::vector<std::string>& sometimes);

}  // namespace lcrig::property
