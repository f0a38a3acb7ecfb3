// SPDX-License-Identifier: Apache-2.0
// The name of a run that stays when the run is copied into another database (RFC 9562). Rows of
// runs and their chain use it.
#pragma once

#include <string>
#include <string_view>

#include "storage/row_hash.hpp"

namespace lcrig {

std::string random_uuid();  // version 4

// The uuid (version 8) of a run that was recorded before runs had such names, from the first link
// of its chain. Migration 8 makes the same in SQL.
std::string uuid_of_link(const Sha256& first_link);
bool is_of_link(std::string_view uuid);

// Enough of one to be meant: at least four of its characters from the left, and not only digits,
// which are the number of a run.
bool is_beginning_of_uuid(std::string_view text);

}  // namespace lcrig
