// SPDX-License-Identifier: Apache-2.0
// Tells whether a daemon that died may have left a frame moving. App asks before it opens the
// database for writing, because another program, a full or a slow disk may hold that up, and the
// frame has to be stopped first.
#pragma once

#include <cstdint>
#include <string>

#include "base/time.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// False when the protocol of the run commands no frame. What cannot be read counts as one that
// does.
bool commanded_frame(const Database& db, std::int64_t run);

// False when it is known that nothing was left: there was no database, or every run without an end
// commanded no frame or is being recorded by another process. True also when nobody can tell within
// `patience`.
bool may_have_left_motion(const std::string& database, Duration patience);

}  // namespace lcrig
