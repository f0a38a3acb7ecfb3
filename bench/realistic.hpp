// SPDX-License-Identifier: Apache-2.0
// Rehearses on a bench with the errors of real ones, and judges every interval by the values that
// were drawn. For coverage_bench and tests/coverage/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/worlds.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig::worlds {

// A shipped protocol in the form in which it is rehearsed.
struct Rehearsed {
  std::string name, text;  // of the protocol
  ParameterValues parameters;
};
Rehearsed rehearsed_levels(int repeats, int readings);
Rehearsed rehearsed_cycles(int cycles);

// Makes four rehearsals with this seed.
//
// The first run has all errors and is judged. Its truth comes from what its bench drew
// (drawn_truth.hpp) where that is enough: for C0, noise, drift, limit of detection, repeatability
// and all results from levels. The second run is on the same rig another day, so the true increase
// from the first to the second is 0. For the other results, the third run gives the truth of
// `ci95`, because it has no noise, no drift and no differences between loadings. The fourth gives
// the truth of the expanded uncertainty, because its instruments are perfect.
//
// `folder` holds the databases and must exist. Throws where a rehearsal fails.
std::vector<Judged> judge_on_bench(const Rehearsed& what, std::uint64_t seed,
                                   const std::string& folder);

}  // namespace lcrig::worlds
