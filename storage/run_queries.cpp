// SPDX-License-Identifier: Apache-2.0
#include "storage/runs.hpp"

#include <algorithm>

#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/proof.hpp"
#include "storage/tags.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

// The counts of rows come from the last link of the chain, so that listing a long run needs no
// counting. For an ended run the index chain_at_end gives that link. A run whose links somebody
// deleted is listed without counts; `verify` reports what is missing.
constexpr std::string_view kListing =
    "SELECT run.id, protocol_name, specimen_name, run.operator, simulated,"
    " coalesce(bench_name, ''), started_unix_ns,"
    " exit_status, coalesce(reason, ''), ended_unix_ns, coalesce(lcr_reading_seq, 0),"
    " coalesce(frame_sample_seq, 0), coalesce(level_seq, 0), coalesce(event_seq, 0), {}, {}, {}"
    " FROM run LEFT JOIN run_end ON run_end.run_id = run.id {}"
    " LEFT JOIN chain ON chain.run_id = run.id AND chain.run_end = 1 AND chain.seq ="
    " (SELECT max(seq) FROM chain AS c WHERE c.run_id = run.id AND c.run_end = 1)";

Result<std::string> listing_sql(const Database& db) {
  auto named = has_uuids(db);
  if (!named) return fail(named.error());
  auto unproven = may_be_unproven_sql(db);
  if (!unproven) return fail(unproven.error());
  auto dated = has_table(db, "run_made");
  if (!dated) return fail(dated.error());
  return fmt::format(kListing, *named ? "uuid" : "''", *unproven, *dated ? "made_unix_ns" : "NULL",
                     *dated ? "LEFT JOIN run_made ON run_made.run_id = run.id" : "");
}

struct ReadListing {
  const Database& db;
  Result<RunListing> operator()(const Statement& s) const;
};

Result<RunListing> ReadListing::operator()(const Statement& s) const {
  RunListing out;
  bool may_be_unproven = false;
  std::optional<std::string> end;
  s.read(out.run, out.protocol_name, out.specimen_name, out.operator_name, out.simulated,
         out.bench_name, out.started_unix_ns, end, out.reason, out.ended_unix_ns, out.lcr_readings,
         out.frame_samples, out.levels, out.events, out.uuid, may_be_unproven, out.made_unix_ns);
  if (may_be_unproven) {
    auto counted = keep(count_unproven(db, out.run), out.unproven_readings);
    if (!counted) return fail(counted.error());
    // A run without links is listed without counts.
    out.lcr_readings = std::max<std::int64_t>(0, out.lcr_readings - out.unproven_readings);
  }
  if (end) out.exit_status = parse_word<ExitStatus>(*end);
  if (!end || out.exit_status) return out;
  return fail(Errc::garbled, "run {}: ended with an unknown word, `{}`", out.run, *end);
}

Result<> count_rows_so_far(const Database& db, RunListing& open_run) {
  return db.each(
      "SELECT lcr_reading_seq, frame_sample_seq, level_seq, event_seq FROM chain WHERE run_id = ?"
      " ORDER BY seq DESC LIMIT 1",
      [&r = open_run](const Statement& s) {
        s.read(r.lcr_readings, r.frame_samples, r.levels, r.events);
      },
      open_run.run);
}

// A run without an end may have ended after its row was read, so the row is read again.
Result<> complete_open_run(const Database& db, RunListing& listing) {
  if (listing.exit_status) return {};
  auto asked = keep(is_being_recorded(db.path(), listing.run), listing.goes_on);
  if (!asked) return asked;
  if (!listing.goes_on) {
    auto sql = listing_sql(db);
    if (!sql) return fail(sql.error());
    auto again = db.first(*sql + " WHERE run.id = ?", ReadListing{db}, listing.run);
    if (!again) return fail(again.error());
    if (!*again) return {};
    if (!**again) return fail((*again)->error());
    listing = std::move(***again);
  }
  return listing.exit_status ? Result<>() : count_rows_so_far(db, listing);
}

RunRow read_run(const Statement& s) {
  RunRow r;
  std::int64_t started_ns = 0;
  s.read(r.protocol_name, r.protocol_text, r.parameters_json, r.specimen_id, r.specimen_name,
         r.specimen_text, r.probe_diameter_m, r.lcr_identity, r.frame_identity, r.lcr_settings_json,
         r.frame_capabilities_json, r.frame_limits_json, r.correction_json, r.bench_name,
         r.bench_text, r.simulated, r.seed, r.model_level, r.model_error_json, r.software_version,
         r.operator_name, r.note, r.started_unix_ns, started_ns, r.boot_id);
  r.started = MonoTime(Duration(started_ns));
  return r;
}

Result<std::optional<std::int64_t>> time_of_making(const Database& db, std::int64_t run) {
  return read_if(has_table(db, "run_made"), [&] {
    return db.first<std::int64_t>("SELECT made_unix_ns FROM run_made WHERE run_id = ?", run);
  });
}

}  // namespace

std::string_view status_of(const RunListing& listing) {
  return to_string(listing.exit_status, listing.goes_on ? kRunGoesOn : kRunCutOff);
}

Result<std::optional<std::int64_t>> last_run_end_unix_ns(const Database& db) {
  // A run that was copied from elsewhere says nothing about this rig.
  return db.first<std::int64_t>(
      "SELECT ended_unix_ns FROM run_end WHERE run_id NOT IN (SELECT run_id FROM run_copy)"
      " ORDER BY run_id DESC LIMIT 1");
}

Result<std::vector<RunListing>> list_runs(const Database& db, const RunFilter& filter) {
  // Statuses of a run without an end are not in the database; the writer's lock below gives them.
  const std::string end = parse_word<ExitStatus>(filter.status) ? filter.status : "";
  auto sql = listing_sql(db);
  if (!sql) return fail(sql.error());
  auto tags = get_tags(db);
  if (!tags) return fail(tags.error());
  // An older schema has neither tags nor their view.
  const std::string tagged =
      tags->empty() ? "?6 = ''" : "(?6 = '' OR run.id IN (SELECT run FROM v_tag WHERE tag = ?6))";
  auto dated = has_table(db, "run_made");
  if (!dated) return fail(dated.error());
  const std::string made = *dated ? "made_unix_ns" : "NULL";
  auto all =
      db.rows(*sql +
                  " WHERE (?1 = '' OR specimen_name = ?1) AND (?2 = '' OR protocol_name = ?2)"
                  " AND (?3 = '' OR run.operator = ?3) AND (?4 = '' OR exit_status = ?4)"
                  " AND (?5 IS NULL OR coalesce(" +
                  made + ", started_unix_ns) >= ?5) AND " + tagged + " ORDER BY run.id DESC",
              ReadListing{db}, filter.specimen, filter.protocol, filter.operator_name, end,
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
  auto found = db.first(*sql + " WHERE run.id = ?", ReadListing{db}, run);
  if (!found) return fail(found.error());
  if (!*found) return fail(no_such_run(db, run));
  Result<RunListing> listing = std::move(**found);
  if (!listing) return listing;
  if (auto r = complete_open_run(db, *listing); !r) return fail(r.error());
  if (auto r = keep(get_tags_of(db, run), listing->tags); !r) return fail(r.error());
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
  if (!*found) return fail(no_such_run(db, run));
  RunRow& row = **found;
  auto uuid = get_uuid(db, run);
  if (!uuid) return fail(uuid.error());
  row.uuid = uuid->value_or("");
  if (auto made = keep(time_of_making(db, run), row.made_unix_ns); !made) return fail(made.error());
  auto copied = keep(get_copied_from(db, run), row.copied_from);
  if (!copied) return fail(copied.error());
  return std::move(row);
}

Result<std::vector<RunNote>> get_run_notes(const Database& db, std::int64_t run) {
  const auto read = [](const Statement& s) {
    RunNote note;
    s.read(note.seq, note.operator_name, note.text, note.added_unix_ns);
    return note;
  };
  return db.rows(
      "SELECT seq, operator, text, added_unix_ns FROM run_note WHERE run_id = ? ORDER BY seq", read,
      run);
}

}  // namespace lcrig
