// SPDX-License-Identifier: Apache-2.0
// Decided before a run moves anything: whether the disk has room for what it will store.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace lcrig {

// `bytes`: of the plans of all runs that are to be stored. What has to stay free besides is for
// what no plan knows: pauses, losses, a log that a slow reader keeps long. A disk that cannot tell
// is believed to have room. Errors: io, with both figures.
Result<> require_room(const std::string& database, std::int64_t bytes);

}  // namespace lcrig
