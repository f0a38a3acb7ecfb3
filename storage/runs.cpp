// SPDX-License-Identifier: Apache-2.0
#include "storage/runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/number.hpp"
#include "base/text.hpp"
#include "storage/anchor.hpp"
#include "storage/chain.hpp"
#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/queue_run.hpp"
#include "storage/uuid.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

Result<std::string> correction_text(const Database& db, const RunRow& row) {
  if (!row.corrections) return row.correction_json;
  MeterCorrections meter = *row.corrections;
  if (auto found = look_up_corrections(db, meter); !found) return fail(found.error());
  return to_json(meter).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Result<> write_run(const Database& db, std::int64_t id, const RunRow& r, RowHash& hash) {
  auto writer = RowWriter::prepare(db, "run");
  if (!writer) return fail(writer.error());
  const auto correction = correction_text(db, r);
  if (!correction) return fail(correction.error());
  const std::string sha256 = sha256_hex(r.protocol_text);
  const std::string uuid = r.uuid.empty() ? random_uuid() : r.uuid;
  writer->begin(hash).add(id, r.protocol_name, r.protocol_text, sha256, r.parameters_json);
  writer->add(r.specimen_id, r.specimen_name, r.specimen_text, r.probe_diameter_m);
  writer->add(r.lcr_identity, r.frame_identity, r.lcr_settings_json, r.frame_capabilities_json);
  writer->add(r.frame_limits_json, *correction, r.bench_name, r.bench_text, r.simulated, r.seed);
  writer->add(r.model_level, r.model_error_json, r.software_version, r.operator_name, r.note);
  writer->add(r.started_unix_ns, r.started, r.boot_id, uuid);
  return writer->insert();
}

// Adds a row to a run in one transaction. Its first column is the run; `write(writer, head)` fills
// the others. A new link covers it.
template <class Write>
Result<> append_row(const Database& db, std::int64_t run, std::string_view table, Write write) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto writer = RowWriter::prepare(db, table);
  if (!writer) return fail(writer.error());
  auto chain = ChainWriter::prepare(db);
  if (!chain) return fail(chain.error());
  auto head = chain->head(run);
  if (!head) return fail(head.error());
  if (head->seq == 0) return fail(no_such_run(db, run));
  auto copied = get_copied_from(db, run);
  if (!copied) return fail(copied.error());
  RowHash hash;
  hash.start(head->hash);
  const bool ended = head->ended;
  write(writer->begin(hash).add_number(run, *copied ? (*copied)->run : run), *head);
  if (auto r = writer->insert(); !r) return r;
  if (auto r = chain->append(*head, hash); !r) return r;
  if (head->ended && !ended) {
    if (auto r = chain->anchor(*head); !r) return r;
  }
  return transaction->commit();
}

constexpr std::string_view kReplay = "replay:";

// Rounded to a millinewton, without "-0.000".
std::string rounded_N(double force_N) {
  return fmt::format("{:.3f}", std::round(force_N * 1e3) / 1e3 + 0.0);
}

// Tells a person who finds the rig after a crash in which state it was left.
Result<std::string> reason_of_orphan(const Database& db, std::int64_t run) {
  std::string reason = "the daemon ended without closing the run; found at the next start";
  auto ended = get_anchor(db, run);
  if (!ended) return fail(ended.error());
  if (*ended) {
    reason = fmt::format(
        "the run had ended with {} links, and its end was deleted from the database; found at the "
        "next start",
        (*ended)->links);
  }
  auto force_N = db.first<double>(
      "SELECT force_N FROM frame_sample WHERE run_id=? AND force_N IS NOT NULL "
      "ORDER BY seq DESC LIMIT 1",
      run);
  if (!force_N) return fail(force_N.error());
  if (*force_N) {
    reason += fmt::format(
        "; the last force stored is {} N: look at the rig, the specimen may still be loaded",
        rounded_N(**force_N));
  }
  return reason;
}

Result<std::int64_t> find_by_uuid(const Database& db, std::string_view beginning) {
  auto known = has_uuids(db);
  if (!known) return fail(known.error());
  if (!*known) return fail(no_such_run(db, beginning));
  std::string first(beginning);
  std::ranges::transform(first, first.begin(), [](char c) {
    return c >= 'A' && c <= 'F' ? static_cast<char>(c + 32) : c;
  });
  const std::string after_last = first + "g";  // sorts after every hex digit
  auto found = db.rows<std::int64_t>(
      "SELECT id FROM run WHERE uuid >= ? AND uuid < ? ORDER BY id LIMIT 2", first, after_last);
  if (!found) return fail(found.error());
  if (found->empty()) return fail(no_such_run(db, beginning));
  if (found->size() == 1) return found->front();
  return fail(Errc::invalid_request,
              "{}: the uuids of several runs begin with {}, among them those of runs {} and {}; "
              "give more of it",
              db.path(), beginning, found->front(), found->back());
}

}  // namespace

std::optional<double> RunRow::probe_area_m2() const {
  if (!probe_diameter_m) return std::nullopt;
  return std::numbers::pi / 4 * *probe_diameter_m * *probe_diameter_m;
}

std::string replay_bench(std::string_view directory) {
  return std::string(kReplay).append(directory);
}

std::optional<std::string> replay_directory(std::string_view bench) {
  if (!bench.starts_with(kReplay)) return std::nullopt;
  return std::string(bench.substr(kReplay.size()));
}

std::string_view stand_in_word(std::string_view bench) {
  return bench.starts_with(kReplay) ? "replayed" : "simulated";
}

std::string read_boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(file, id);
  return id;
}

// The number that AUTOINCREMENT would choose.
Result<std::int64_t> next_run_number(const Database& db) {
  return db.integer("SELECT coalesce((SELECT seq FROM sqlite_sequence WHERE name='run'), 0) + 1");
}

Result<std::int64_t> insert_run(const Database& db, const RunRow& row) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto id = next_run_number(db);  // the hash needs it before the row exists
  if (!id) return fail(id.error());
  RowHash hash;
  hash.start(Sha256{});
  if (auto r = write_run(db, *id, row, hash); !r) return fail(r.error());
  auto chain = ChainWriter::prepare(db);
  if (!chain) return fail(chain.error());
  ChainHead head;
  head.run = *id;
  if (auto r = chain->append(head, hash); !r) return fail(r.error());
  if (row.made_unix_ns) {
    auto r = db.change("INSERT INTO run_made VALUES (?,?)", *id, *row.made_unix_ns);
    if (!r) return fail(r.error());
  }
  if (auto r = note_specimen_of_run(db, row.specimen_name); !r) return fail(r.error());
  if (row.queue_entry) {
    auto claimed = claim_queue_entry(db, *row.queue_entry, *id, row.started_unix_ns);
    if (!claimed) return fail(claimed.error());
  }
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return *id;
}

Result<> insert_run_end(const Database& db, std::int64_t run, const RunEnd& end) {
  return append_row(db, run, "run_end", [&](RowWriter& row, ChainHead& head) {
    head.ended = true;
    row.add(to_string(end.status), end.reason, end.ended, end.ended_unix_ns);
  });
}

Result<> add_run_note(const Database& db, std::int64_t run, std::string_view operator_name,
                      std::string_view text, std::int64_t now_unix_ns) {
  if (text.empty()) return fail(Errc::invalid_request, "a note needs a text");
  if (auto good = check_text("note", text, kNoteMax); !good) return good;
  if (auto good = check_text("operator", operator_name, kNameMax); !good) return good;
  auto open = db.holds(
      "SELECT count(*) FROM run WHERE id = ?1 AND ?1 NOT IN (SELECT run_id FROM run_end)", run);
  if (!open) return fail(open.error());
  if (*open) {
    return fail(Errc::invalid_request, "run {} {}: add the note when it has ended", run,
                is_being_recorded(db.path(), run).value_or(true)
                    ? "is still going on"
                    : "was cut off, and lcrigd closes it at its next start");
  }
  return append_row(db, run, "run_note", [&](RowWriter& row, ChainHead& head) {
    row.add(++head.last_of(RunTable::run_note), operator_name, text, now_unix_ns);
  });
}

Result<std::vector<std::int64_t>> unfinished_runs(const Database& db) {
  return db.rows<std::int64_t>("SELECT id FROM run WHERE id NOT IN (SELECT run_id FROM run_end)");
}

Result<std::vector<std::int64_t>> close_orphaned_runs(const Database& db,
                                                      std::int64_t now_unix_ns) {
  auto orphans = unfinished_runs(db);
  if (!orphans) return orphans;
  RunEnd end;
  end.status = ExitStatus::interrupted;
  end.ended_unix_ns = now_unix_ns;
  for (const std::int64_t run : *orphans) {
    if (auto r = keep(reason_of_orphan(db, run), end.reason); !r) return fail(r.error());
    if (auto r = insert_run_end(db, run, end); !r) return fail(r.error());
  }
  return orphans;
}

Result<std::int64_t> find_run(const Database& db, std::string_view text) {
  if (text == "last") {
    auto last = db.integer("SELECT coalesce(max(id), 0) FROM run");
    if (!last) return fail(last.error());
    if (*last == 0) return fail(Errc::invalid_request, "{}: holds no run yet", db.path());
    return *last;
  }
  if (is_beginning_of_uuid(text)) return find_by_uuid(db, text);
  const auto number = number_from<std::int64_t>(text);
  if (!number) {
    return fail(Errc::invalid_request,
                "\"{}\": a run is a number, the beginning of its uuid, or `last`; see `lcrig runs`",
                text);
  }
  auto found = db.holds("SELECT count(*) FROM run WHERE id = ?", *number);
  if (!found) return fail(found.error());
  if (!*found) return fail(no_such_run(db, text));
  return *number;
}

}  // namespace lcrig
