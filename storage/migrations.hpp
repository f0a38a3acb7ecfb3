// SPDX-License-Identifier: Apache-2.0
// Forward-only schema changes, schema/sql/NNNN_*.sql, embedded at build time. open_read_write
// (storage/database.hpp) applies them; copy_runs compares versions with them.
#pragma once

#include <span>
#include <string_view>

#include "storage/sqlite.hpp"

namespace lcrig {

struct Migration {
  int version;  // 1, 2, ... without gaps; becomes user_version
  std::string_view name;
  std::string_view sql;
};

std::span<const Migration> shipped_migrations();

// Runs the migrations that `db` lacks, each in one transaction that also raises user_version.
Result<> migrate(const Database& db, std::span<const Migration> migrations = shipped_migrations());

}  // namespace lcrig
