// SPDX-License-Identifier: Apache-2.0
#include "storage/corrections.hpp"

#include "storage/database.hpp"

namespace lcrig {

namespace {

Result<bool> stores_corrections(const Database& db) {
  return has_table(db, "lcr_correction");
}

}  // namespace

Result<> add_correction(const Database& db, const StoredCorrection& made) {
  return db.change(
      "INSERT INTO lcr_correction (kind, meter, lcr_identity, simulated, operator, operator_uid,"
      " made_unix_ns) VALUES (?,?,?,?,?,?,?)",
      to_string(made.kind), made.meter, made.lcr_identity, std::int64_t{made.simulated ? 1 : 0},
      made.operator_name, made.operator_uid, made.made_unix_ns);
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
        [&state](const Statement& s) { s.read(state.made_unix_ns, state.made_by); }, meter.meter,
        kind);
    if (!found) return found;
  }
  return {};
}

Result<std::vector<MeterCorrections>> list_corrections(const Database& db) {
  auto known = stores_corrections(db);
  if (!known) return fail(known.error());
  if (!*known) return std::vector<MeterCorrections>();
  const auto read = [](const Statement& s) {
    MeterCorrections out;
    s.read(out.meter, out.simulated);
    return out;
  };
  auto meters = db.rows(
      "SELECT meter, max(simulated) FROM lcr_correction GROUP BY meter ORDER BY max(id) DESC",
      read);
  if (!meters) return meters;
  for (MeterCorrections& meter : *meters) {
    if (auto found = look_up_corrections(db, meter); !found) return fail(found.error());
  }
  return meters;
}

}  // namespace lcrig
