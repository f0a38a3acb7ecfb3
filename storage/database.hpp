// SPDX-License-Identifier: Apache-2.0
// Opens an lcrig database. Checks first that the file is one, that its schema is known and, for
// writing, that it is writable. Used by the daemon, the command line and analysis.
#pragma once

#include <string>

#include "storage/sqlite.hpp"

namespace lcrig {

constexpr std::int32_t kApplicationId = 0x6c637267;  // "lcrg", in the file's header

// Pass as `vfs` for a database in memory, in tests. All connections of the process that give the
// same absolute path share it, and it is gone when the last one closes. It has no WAL, so readers
// and writers block each other.
inline constexpr const char* kInMemory = "memdb";

// How much of the disk must stay free beside a planned run, for what no plan can know, such as
// pauses and losses of instruments. The recorder refuses a run that leaves less; `lcrig doctor`
// warns.
inline constexpr std::int64_t kStaysFree_bytes = 64 << 20;

// Creates or migrates the file (which is logged); sets WAL, synchronous=FULL and foreign keys. Its
// -wal and -shm stay beside it for good, because readers may lack the right to create them. Refuses
// a file that is not a database, belongs to another program, or has a newer schema than this
// program.
Result<Database> open_read_write(const std::string& path, const std::string& vfs = "");

// For callers that may create the file, before anything is created. Errors: there is a log without
// its database, and creating the database would delete it; or the name is a link to nothing, and
// the log and the lock would be named after the link instead of the file.
Result<> require_safe_to_create(const std::string& path);

// For the only writer. The lock and the log of a database are named after its path. Under a second
// name of the file they would differ, and two programs would write the same file
// (sqlite.org/howtocorrupt.html, 2.5).
Result<> require_one_name(const std::string& path);

// For analysis and export, whether the daemon runs, was stopped or was killed. Creates and deletes
// no file, so the right to read the database and the files beside it is enough, also on a read-only
// medium.
Result<Database> open_read_only(const std::string& path, const std::string& vfs = "");

// Whether the schema has uuids, tags and copied runs; false: it is older.
Result<bool> has_uuids(const Database& db);
Result<bool> has_table(const Database& db, std::string_view name);
// The result of `read`, or an empty value where the schema is too old for it (`is_known` is false).
template <class Read>
auto read_if(const Result<bool>& is_known, Read read) -> std::invoke_result_t<Read&> {
  if (!is_known) return fail(is_known.error());
  if (!*is_known) return typename std::invoke_result_t<Read&>::value_type();
  return read();
}

// `run` is a number, or the text that somebody typed instead.
template <class Run>
Error no_such_run(const Database& db, const Run& run) {
  return Error(Errc::invalid_request,
               fmt::format("{}: no run {}; see `lcrig runs`", db.path(), run));
}

}  // namespace lcrig
