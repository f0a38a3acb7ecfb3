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

// Rehearses three times with this seed. The first run has all errors and is judged. The second has
// neither noise nor drift nor differences between loadings, and gives the truth of `ci95`. The
// third has perfect instruments, and gives the truth of the expanded uncertainty: the specimen's
// own. `folder` holds the databases and must exist. Throws where a rehearsal fails.
std::vector<Judged> judge_on_bench(const Rehearsed& what, std::uint64_t seed,
                                   const std::string& folder);

}  // namespace lcrig::worlds
