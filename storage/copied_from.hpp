// SPDX-License-Identifier: Apache-2.0
// Facts about a run that outlive its copy into another database: its name, and the number under
// which it was recorded. Reading rows, checking the chain and continuing a run use them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// The origin of a run that was recorded into another database.
struct CopiedFrom {
  std::int64_t run = 0;  // its number there
  std::optional<std::int64_t> specimen_id;  // likewise
  std::string file, by;
  std::int64_t copied_unix_ns = 0;
};
// nullopt: it was recorded here.
Result<std::optional<CopiedFrom>> get_copied_from(const Database& db, std::int64_t run);

// nullopt: no such run, or its schema is older than such names.
Result<std::optional<std::string>> get_uuid(const Database& db, std::int64_t run);

}  // namespace lcrig
