// SPDX-License-Identifier: Apache-2.0
#include "storage/corrections.hpp"

namespace lcrig {

namespace {

// False: its schema is older.
Result<bool> stores_corrections(const Database& db) {
  auto tables = db.integer("SELECT count(*) FROM sqlite_schema WHERE name = 'lcr_correction'");
  if (!tables) return fail(tables.error());
  return *tables > 0;
}

}  // namespace

Result<> add_correction(const Database& db, const StoredCorrection& made) {
  return db.change(
      "INSERT INTO lcr_correction (kind, meter, lcr_identity, simulated, operator, operator_uid,"
      " made_unix_ns) VALUES (?,?,?,?,?,?,?)",
      to_string(made.kind), std::string_view(made.meter), std::string_view(made.lcr_identity),
      std::int64_t{made.simulated ? 1 : 0}, std::string_view(made.operator_name), made.operator_uid,
      made.made_unix_ns);
}

Result<> look_up_corrections(const Database& db, MeterCorrections& meter) {
  auto known = stores_corrections(db);
  if (!known) return fail(known.error());
  if (!*known) return {};
  for (const CorrectionKind kind : kCorrectionKinds) {
    CorrectionState& state = meter.of(kind);
    auto found = db.each(
        "SELECT made_unix_ns, operator FROM lcr_correction WHERE meter = ? AND kind = ?"
        " ORDER BY id DESC LIMIT 1",
        [&state](const Statement& s) {
          state.made_unix_ns = s.integer(0);
          state.made_by = s.text(1);
        },
        std::string_view(meter.meter), to_string(kind));
    if (!found) return found;
  }
  return {};
}

Result<std::vector<MeterCorrections>> list_corrections(const Database& db) {
  auto known = stores_corrections(db);
  if (!known) return fail(known.error());
  if (!*known) return std::vector<MeterCorrections>();
  auto meters = db.rows(
      "SELECT meter, max(simulated) FROM lcr_correction GROUP BY meter ORDER BY max(id) DESC",
      [](const Statement& s) {
        MeterCorrections out;
        out.meter = s.text(0);
        out.simulated = s.integer(1) != 0;
        return out;
      });
  if (!meters) return meters;
  for (MeterCorrections& meter : *meters) {
    if (auto found = look_up_corrections(db, meter); !found) return fail(found.error());
  }
  return meters;
}

}  // namespace lcrig
