// SPDX-License-Identifier: Apache-2.0
#include "storage/specimens.hpp"

#include "storage/row_hash.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kColumns = "id, name, version, sha256, text, added_unix_ns";

StoredSpecimen read_row(const Statement& s) {
  StoredSpecimen out;
  s.read(out.id, out.name, out.version, out.sha256, out.text, out.added_unix_ns);
  return out;
}

}  // namespace

Result<StoredSpecimen> add_specimen(const Database& db, const std::string& name,
                                    const std::string& text, std::int64_t now_unix_ns) {
  if (name.empty()) return fail(Errc::invalid_request, "a specimen needs a name");
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto newest = find_specimen(db, name);
  if (!newest) return fail(newest.error());
  StoredSpecimen specimen;
  specimen.sha256 = sha256_hex(text);
  if (*newest && (*newest)->sha256 == specimen.sha256) return **newest;
  specimen.name = name;
  specimen.version = *newest ? (*newest)->version + 1 : 1;
  specimen.text = text;
  specimen.added_unix_ns = now_unix_ns;
  auto stored = db.change(
      "INSERT INTO specimen (name, version, sha256, text, added_unix_ns) VALUES (?,?,?,?,?)",
      specimen.name, specimen.version, specimen.sha256, specimen.text, specimen.added_unix_ns);
  if (!stored) return fail(stored.error());
  specimen.id = db.last_insert_id();
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return specimen;
}

Result<std::optional<StoredSpecimen>> find_specimen(const Database& db, std::string_view name) {
  return db.first(
      fmt::format("SELECT {} FROM specimen WHERE name = ? ORDER BY version DESC LIMIT 1", kColumns),
      read_row, name);
}

Result<std::vector<StoredSpecimen>> list_specimens(const Database& db) {
  return db.rows(
      fmt::format("SELECT {} FROM specimen AS a WHERE version ="
                  " (SELECT max(version) FROM specimen AS b WHERE b.name = a.name) ORDER BY name",
                  kColumns),
      read_row);
}

}  // namespace lcrig
