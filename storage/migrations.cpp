// SPDX-License-Identifier: Apache-2.0
#include "storage/migrations.hpp"

#include "storage/database.hpp"

namespace lcrig {

namespace {

Result<> apply(const Database& db, const Migration& m) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  // Another process may have migrated while this one waited for the lock.
  auto version = db.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*version >= m.version) return {};
  const auto describe = [&](const Error& e) {
    return fail(e.code, "{} (migration {}; nothing was changed)", e.what, m.name);
  };
  if (auto r = db.execute(std::string(m.sql)); !r) return describe(r.error());
  const auto pragmas = fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                   kApplicationId, m.version);
  if (auto r = db.execute(pragmas); !r) return describe(r.error());
  if (auto r = transaction->commit(); !r) return describe(r.error());
  return {};
}

}  // namespace

Result<> migrate(const Database& db, std::span<const Migration> migrations) {
  auto version = db.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  bool raised = false;
  for (const Migration& m : migrations) {
    if (m.version <= *version) continue;
    if (auto r = apply(db, m); !r) return r;
    raised = true;
  }
  // The package's scripts read the schema version from the file's header, without SQLite and its
  // log.
  if (raised) return db.execute("PRAGMA wal_checkpoint(TRUNCATE)");
  return {};
}

}  // namespace lcrig
