// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/run_database.hpp"

#include <fmt/chrono.h>

#include <system_error>

#include "storage/runs.hpp"

namespace lcrig::cli {

Outcome<Database> open_runs(const Context& context) {
  auto path = context.db_path();
  if (!path) return path.error();
  std::error_code unknown;
  if (!std::filesystem::exists(*path, unknown) && !unknown) {
    return Failure(kFailed, fmt::format("there is no database at {}", *path),
                   "lcrig rehearse static-frame --specimen paper-1   (makes a first "
                   "run), or give --db FILE");
  }
  auto db = open_read_only(*path);
  if (!db) return Failure(db.error(), "give another --db");
  return std::move(*db);
}

Outcome<std::int64_t> named_run(const Database& db, const std::string& text) {
  auto run = find_run(db, text);
  if (!run) return Failure(run.error(), "lcrig runs   (lists them)");
  return *run;
}

Outcome<NamedRun> open_run(const Context& context, const std::string& text) {
  auto db = open_runs(context);
  if (!db) return db.error();
  auto number = named_run(*db, text);
  if (!number) return number.error();
  return NamedRun{std::move(*db), *number};
}

std::string format_utc(std::int64_t unix_ns) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(static_cast<std::time_t>(unix_ns / 1'000'000'000)));
}

}  // namespace lcrig::cli
