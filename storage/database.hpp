// SPDX-License-Identifier: Apache-2.0
// Opening an lcrig database: is it one, is its schema ours, may we write.
#pragma once

#include <string>

#include "storage/sqlite.hpp"

namespace lcrig {

constexpr std::int32_t kApplicationId = 0x6c637267;  // "lcrg", in the file's header

// As `vfs`: a database in memory, for tests that want none on a disk. All connections of this
// process that give the same absolute path share it, and it is gone with the last of them. A reader
// keeps a writer waiting, and the other way round: it has no WAL.
inline constexpr const char* kInMemory = "memdb";

// Creates or migrates the file; WAL, synchronous=FULL, foreign keys. Refuses what is no database,
// another program's, or newer than this program.
Result<Database> open_read_write(const std::string& path, const std::string& vfs = "");

// For analysis and export: never changes the file, works beside a running daemon and on a read-only
// medium. Refuses an older schema too (only a writer migrates).
Result<Database> open_read_only(const std::string& path, const std::string& vfs = "");

}  // namespace lcrig
