// SPDX-License-Identifier: Apache-2.0
// Opens the database and finds the run that a command names. Used by every command that reads runs.
#pragma once

#include <cstdint>
#include <string>

#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/command.hpp"

namespace lcrig::cli {

Outcome<Database> open_runs(const Context& context);
inline constexpr const char* kWhichRun = "A number, the beginning of its uuid, or `last`";
// `text` is one of the three forms above.
Outcome<std::int64_t> named_run(const Context& context, const Database& db,
                                const std::string& text);
// The database, and the run in it that `text` names.
struct NamedRun {
  Database db;
  std::int64_t number = 0;
};
Outcome<NamedRun> open_run(const Context& context, const std::string& text);
// Only the number, for a command that writes afterwards: a reader that stays open would keep SQLite
// from emptying its log.
Outcome<std::int64_t> number_of_run(const Context& context, const std::string& text);
// The hint that fits `error`: when the database is damaged or cannot be read, to replace it by a
// backup; otherwise `otherwise`.
std::string next_after(const Error& error, std::string otherwise = {});
// For commands that use the numbers of a run but do not show the state of its chain.
void note_if_changed(const Context& context, const ChainReport& chain, std::int64_t run);
// "2026-01-31T12:00:00Z"
std::string format_utc(std::int64_t unix_ns);
// One run as a line of JSON, as docs/cli-json.md promises. It is formatted directly: ten thousand
// JSON values would take longer than reading the runs.
std::string run_listing_line(const RunListing& run);

}  // namespace lcrig::cli
