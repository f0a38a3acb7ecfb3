// SPDX-License-Identifier: Apache-2.0
#include "storage/copied_from.hpp"

#include "storage/database.hpp"

namespace lcrig {

Result<std::optional<CopiedFrom>> get_copied_from(const Database& db, std::int64_t run) {
  const auto read = [](const Statement& s) {
    CopiedFrom out;
    s.read(out.run, out.specimen_id, out.file, out.by, out.copied_unix_ns);
    return out;
  };
  return read_if(has_uuids(db), [&] {
    return db.first(
        "SELECT recorded_run, recorded_specimen_id, copied_from, copied_by, copied_unix_ns"
        " FROM run_copy WHERE run_id = ?",
        read, run);
  });
}

Result<std::optional<std::string>> get_uuid(const Database& db, std::int64_t run) {
  return read_if(has_uuids(db),
                 [&] { return db.first<std::string>("SELECT uuid FROM run WHERE id = ?", run); });
}

}  // namespace lcrig
