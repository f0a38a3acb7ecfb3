// SPDX-License-Identifier: Apache-2.0
#include "storage/copied_from.hpp"

#include "storage/database.hpp"

namespace lcrig {

Result<std::optional<CopiedFrom>> get_copied_from(const Database& db, std::int64_t run) {
  auto known = has_uuids(db);
  if (!known) return fail(known.error());
  if (!*known) return std::nullopt;
  return db.first(
      "SELECT recorded_run, recorded_specimen_id, copied_from, copied_by, copied_unix_ns"
      " FROM run_copy WHERE run_id = ?",
      [](const Statement& s) {
        CopiedFrom out;
        out.run = s.integer(0);
        out.specimen_id = s.optional_integer(1);
        out.file = s.text(2);
        out.by = s.text(3);
        out.copied_unix_ns = s.integer(4);
        return out;
      },
      run);
}

Result<std::optional<std::string>> get_uuid(const Database& db, std::int64_t run) {
  auto known = has_uuids(db);
  if (!known) return fail(known.error());
  if (!*known) return std::nullopt;
  return db.first(
      "SELECT uuid FROM run WHERE id = ?",
      [](const Statement& s) { return std::string(s.text(0)); }, run);
}

}  // namespace lcrig
