// SPDX-License-Identifier: Apache-2.0
// Rehearses on a bench that errs as real ones do, and judges every interval by what was drawn. For
// coverage_bench and tests/coverage/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/worlds.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig::worlds {

// A shipped protocol as it is rehearsed.
struct Rehearsed {
  std::string name, text;  // of the protocol
  ParameterValues parameters;
};
Rehearsed rehearsed_levels(int repeats, int readings);
Rehearsed rehearsed_cycles(int cycles);

// Rehearses four times with this seed. The first run has all errors and is judged, by what its
// bench drew (drawn_truth.hpp) where that tells the truth: C0, noise, drift, limit of detection,
// repeatability and what is made of levels. The second is on the same rig another day: the increase
// from the first to it is none. For the other results the third gives the truth of `ci95`, because
// it has neither noise nor drift nor differences between loadings; the fourth that of the expanded
// uncertainty, because its instruments are perfect. `folder` holds the databases and must exist.
// Throws where a rehearsal fails.
std::vector<Judged> judge_on_bench(const Rehearsed& what, std::uint64_t seed,
                                   const std::string& folder);

}  // namespace lcrig::worlds
