// SPDX-License-Identifier: Apache-2.0
// The uuid of a run (RFC 9562), which it keeps when it is copied into another database. Used by the
// rows of runs and their chain.
#pragma once

#include <string>
#include <string_view>

#include "storage/row_hash.hpp"

namespace lcrig {

std::string random_uuid();  // version 4

// The uuid (version 8) of a run recorded before runs had uuids, derived from the first link of its
// chain. Migration 8 computes the same in SQL.
std::string uuid_of_link(const Sha256& first_link);
bool is_of_link(std::string_view uuid);

// Whether `text` can stand for a uuid: at least its first four characters, and not only digits,
// because a number means a run.
bool is_beginning_of_uuid(std::string_view text);

}  // namespace lcrig
