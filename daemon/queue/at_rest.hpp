// SPDX-License-Identifier: Apache-2.0
// The capacitance that a specimen should show before anything presses it. If another one is shown,
// the queue asks a person before it presses. App asks for it before each turn.
#pragma once

#include <optional>
#include <string>

#include "base/result.hpp"
#include "daemon/session.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// From the specimen's last run at this frequency that ended well, else from its file. nullopt:
// neither says anything. Errors: an unreadable database.
Result<std::optional<ExpectedAtRest>> expected_at_rest(const Database& db, const PreparedRun& run);

}  // namespace lcrig
