// SPDX-License-Identifier: Apache-2.0
// Checks, before a run moves anything, that the disk has room for its rows. Used by the session and
// by the queue.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace lcrig {

// `bytes`: of the plans of all runs to be stored. More has to stay free for what no plan knows:
// pauses, losses, and a log that a slow reader keeps long. A disk that does not report its space
// counts as having room. Errors: io, with both figures.
Result<> require_room(const std::string& database, std::int64_t bytes);

}  // namespace lcrig
