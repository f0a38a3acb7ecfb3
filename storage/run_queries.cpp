// SPDX-License-Identifier: Apache-2.0
#include "storage/runs.hpp"

#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/tags.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

// The numbers of rows are read from the last link of the chain, so that a long run costs no
// counting; those of a run that ended from the index chain_at_end, which has nothing else. A run
// whose links somebody deleted is listed all the same, without numbers: `verify` tells what is
// missing.
constexpr std::string_view kListing =
    "SELECT run.id, protocol_name, specimen_name, run.operator, simulated, started_unix_ns,"
    " exit_status, coalesce(reason, ''), ended_unix_ns, coalesce(lcr_reading_seq, 0),"
    " coalesce(frame_sample_seq, 0), coalesce(level_seq, 0), coalesce(event_seq, 0), {}"
    " FROM run LEFT JOIN run_end ON run_end.run_id = run.id"
    " LEFT JOIN chain ON chain.run_id = run.id AND chain.run_end = 1 AND chain.seq ="
    " (SELECT max(seq) FROM chain AS c WHERE c.run_id = run.id AND c.run_end = 1)";

Result<std::string> listing_sql(const Database& db) {
  auto named = has_uuids(db);
  if (!named) return fail(named.error());
  return fmt::format(kListing, *named ? "uuid" : "''");
}

Result<RunListing> read_listing(const Statement& s) {
  RunListing out;
  out.run = s.integer(0);
  out.protocol_name = s.text(1);
  out.specimen_name = s.text(2);
  out.operator_name = s.text(3);
  out.simulated = s.integer(4) != 0;
  out.started_unix_ns = s.integer(5);
  if (!s.is_null(6)) {
    out.exit_status = parse_exit_status(s.text(6));
    if (!out.exit_status) {
      return fail(Errc::garbled, "run {}: ended with an unknown word, `{}`", out.run, s.text(6));
    }
  }
  out.reason = s.text(7);
  out.ended_unix_ns = s.optional_integer(8);
  out.lcr_readings = s.integer(9);
  out.frame_samples = s.integer(10);
  out.levels = s.integer(11);
  out.events = s.integer(12);
  out.uuid = s.text(13);
  return out;
}

Result<> count_rows_so_far(const Database& db, RunListing& open_run) {
  const auto counted = db.first(
      "SELECT lcr_reading_seq, frame_sample_seq, level_seq, event_seq FROM chain WHERE run_id = ?"
      " ORDER BY seq DESC LIMIT 1",
      [&open_run](const Statement& s) {
        open_run.lcr_readings = s.integer(0);
        open_run.frame_samples = s.integer(1);
        open_run.levels = s.integer(2);
        open_run.events = s.integer(3);
        return true;
      },
      open_run.run);
  if (!counted) return fail(counted.error());
  return {};
}

// A run without an end may have ended since its row was read: then the row is read again.
Result<> complete_open_run(const Database& db, RunListing& listing) {
  if (listing.exit_status) return {};
  const auto goes_on = is_being_recorded(db.path(), listing.run);
  if (!goes_on) return fail(goes_on.error());
  listing.goes_on = *goes_on;
  if (!*goes_on) {
    auto sql = listing_sql(db);
    if (!sql) return fail(sql.error());
    auto again = db.first(*sql + " WHERE run.id = ?", read_listing, listing.run);
    if (!again) return fail(again.error());
    if (!*again) return {};
    if (!**again) return fail((*again)->error());
    listing = std::move(***again);
  }
  return listing.exit_status ? Result<>() : count_rows_so_far(db, listing);
}

Error no_run(const Database& db, std::int64_t run) {
  return Error(Errc::invalid_request,
               fmt::format("{}: no run {}; see `lcrig runs`", db.path(), run));
}

std::optional<std::string> optional_text(const Statement& s, int column) {
  if (s.is_null(column)) return std::nullopt;
  return std::string(s.text(column));
}

RunRow read_run(const Statement& s) {
  RunRow r;
  r.protocol_name = s.text(0);
  r.protocol_text = s.text(1);
  r.parameters_json = s.text(2);
  r.specimen_id = s.optional_integer(3);
  r.specimen_name = s.text(4);
  r.specimen_text = s.text(5);
  r.probe_diameter_m = s.optional_real(6);
  r.lcr_identity = s.text(7);
  r.frame_identity = s.text(8);
  r.lcr_settings_json = s.text(9);
  r.frame_capabilities_json = s.text(10);
  r.frame_limits_json = s.text(11);
  r.correction_json = s.text(12);
  r.bench_name = s.text(13);
  r.bench_text = s.text(14);
  r.simulated = s.integer(15) != 0;
  r.seed = s.optional_integer(16);
  r.model_level = optional_text(s, 17);
  r.model_error_json = optional_text(s, 18);
  r.software_version = s.text(19);
  r.operator_name = s.text(20);
  r.note = s.text(21);
  r.started_unix_ns = s.integer(22);
  r.started = MonoTime(Duration(s.integer(23)));
  r.boot_id = s.text(24);
  return r;
}

}  // namespace

std::string_view status_of(const RunListing& listing) {
  return to_string(listing.exit_status, listing.goes_on ? kRunGoesOn : kRunCutOff);
}

Result<std::optional<std::int64_t>> last_run_end_unix_ns(const Database& db) {
  // The rig did nothing for a run that was copied from elsewhere.
  return db.first(
      "SELECT ended_unix_ns FROM run_end WHERE run_id NOT IN (SELECT run_id FROM run_copy)"
      " ORDER BY run_id DESC LIMIT 1",
      [](const Statement& s) { return s.integer(0); });
}

Result<std::vector<RunListing>> list_runs(const Database& db, const RunFilter& filter) {
  // A status without an end is not in the database: the lock tells it, below.
  const std::string end = parse_exit_status(filter.status) ? filter.status : "";
  auto sql = listing_sql(db);
  if (!sql) return fail(sql.error());
  auto tags = get_tags(db);
  if (!tags) return fail(tags.error());
  // An older schema has no tags, and no view of them.
  const std::string tagged =
      tags->empty() ? "?6 = ''" : "(?6 = '' OR run.id IN (SELECT run FROM v_tag WHERE tag = ?6))";
  auto all =
      db.rows(*sql +
                  " WHERE (?1 = '' OR specimen_name = ?1) AND (?2 = '' OR protocol_name = ?2)"
                  " AND (?3 = '' OR run.operator = ?3) AND (?4 = '' OR exit_status = ?4)"
                  " AND (?5 IS NULL OR started_unix_ns >= ?5) AND " +
                  tagged + " ORDER BY run.id DESC",
              read_listing, filter.specimen, filter.protocol, filter.operator_name, end,
              filter.since_unix_ns, filter.tag);
  if (!all) return fail(all.error());
  std::vector<RunListing> out;
  out.reserve(all->size());
  for (auto& listing : *all) {
    if (!listing) return fail(listing.error());
    if (const auto own = tags->find(listing->run); own != tags->end()) listing->tags = own->second;
    if (auto r = complete_open_run(db, *listing); !r) return fail(r.error());
    if (!filter.status.empty() && status_of(*listing) != filter.status) continue;
    out.push_back(std::move(*listing));
  }
  return out;
}

Result<RunListing> get_run_listing(const Database& db, std::int64_t run) {
  auto sql = listing_sql(db);
  if (!sql) return fail(sql.error());
  auto found = db.first(*sql + " WHERE run.id = ?", read_listing, run);
  if (!found) return fail(found.error());
  if (!*found) return fail(no_run(db, run));
  Result<RunListing> listing = std::move(**found);
  if (!listing) return listing;
  if (auto r = complete_open_run(db, *listing); !r) return fail(r.error());
  auto tags = get_tags_of(db, run);
  if (!tags) return fail(tags.error());
  listing->tags = std::move(*tags);
  return listing;
}

Result<RunRow> get_run(const Database& db, std::int64_t run) {
  auto found = db.first(
      "SELECT protocol_name, protocol_text, parameters_json, specimen_id, specimen_name,"
      " specimen_text, probe_diameter_m, lcr_identity, frame_identity, lcr_settings_json,"
      " frame_capabilities_json, frame_limits_json, correction_json, bench_name, bench_text,"
      " simulated, seed, model_level, model_error_json, software_version, operator, note,"
      " started_unix_ns, started_mono_ns, boot_id FROM run WHERE id = ?",
      read_run, run);
  if (!found) return fail(found.error());
  if (!*found) return fail(no_run(db, run));
  auto uuid = get_uuid(db, run);
  if (!uuid) return fail(uuid.error());
  (*found)->uuid = uuid->value_or("");
  auto copied = get_copied_from(db, run);
  if (!copied) return fail(copied.error());
  (*found)->copied_from = std::move(*copied);
  return std::move(**found);
}

Result<std::vector<RunNote>> get_run_notes(const Database& db, std::int64_t run) {
  const auto read = [](const Statement& s) {
    RunNote note;
    note.seq = s.integer(0);
    note.operator_name = s.text(1);
    note.text = s.text(2);
    note.added_unix_ns = s.integer(3);
    return note;
  };
  return db.rows(
      "SELECT seq, operator, text, added_unix_ns FROM run_note WHERE run_id = ? ORDER BY seq", read,
      run);
}

}  // namespace lcrig
