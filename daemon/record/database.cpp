// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/database.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "storage/runs.hpp"

namespace lcrig {

Result<OwnedDatabase> open_as_owner(const std::string& path, std::int64_t now_unix_ns,
                                    const std::string& vfs) {
  if (auto one = require_one_name(path); !one) return fail(one.error());
  if (vfs != kInMemory) {
    if (auto safe = require_safe_to_create(path); !safe) return fail(safe.error());
  }
  auto lock = WriterLock::acquire(path);
  if (!lock) return fail(lock.error());
  auto db = open_read_write(path, vfs);
  if (!db) return fail(db.error());
  auto interrupted = close_orphaned_runs(*db, now_unix_ns);
  if (!interrupted) return fail(interrupted.error());
  return OwnedDatabase{std::move(*lock), std::move(*db), std::move(*interrupted)};
}

Result<> wait_for_locks(const Database& db, Duration time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
  return db.execute(fmt::format("PRAGMA busy_timeout = {}", ms));
}

}  // namespace lcrig
