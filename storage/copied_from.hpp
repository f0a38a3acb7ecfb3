// SPDX-License-Identifier: Apache-2.0
// Facts about a run that survive copying it into another database: its uuid, and the number under
// which it was recorded. Used to read rows, check the chain and continue a run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// Where a run was recorded that was copied into this database.
struct CopiedFrom {
  std::int64_t run = 0;  // its number there
  std::optional<std::int64_t> specimen_id;  // its specimen's number there
  std::string file, by;
  std::int64_t copied_unix_ns = 0;
};
// nullopt: the run was recorded here.
Result<std::optional<CopiedFrom>> get_copied_from(const Database& db, std::int64_t run);

// nullopt: no such run, or the schema is older than uuids.
Result<std::optional<std::string>> get_uuid(const Database& db, std::int64_t run);

}  // namespace lcrig
