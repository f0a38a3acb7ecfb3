// SPDX-License-Identifier: Apache-2.0
// What a specimen should show before anything presses it: whoever shows something else is a
// stranger, and is not pressed before a person has looked.
#pragma once

#include <optional>
#include <string>

#include "base/result.hpp"
#include "daemon/session.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// Of its own last run with this frequency that ended well; else of its file. nullopt: neither says
// anything. Errors: an unreadable database.
Result<std::optional<ExpectedAtRest>> expected_at_rest(const Database& db, const PreparedRun& run);

}  // namespace lcrig
