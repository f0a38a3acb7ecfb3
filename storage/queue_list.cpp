// SPDX-License-Identifier: Apache-2.0
// Reads the stored queue: the questions that queue.hpp declares.
#include <algorithm>
#include <limits>

#include "storage/queue.hpp"
#include "storage/queue_rows.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kQueueListing =
    "SELECT e.id, e.state, e.protocol_name, e.parameters_json, e.specimen_name, e.operator, e.note,"
    " e.terms_json, e.plan_json, e.added_by, e.added_unix_ns, e.resumes_run,"
    " (SELECT count(*) FROM queue_attempt WHERE entry_id = e.id),"
    " (SELECT max(run_id) FROM queue_attempt WHERE entry_id = e.id) FROM queue_entry AS e";

QueueListing read_queue_listing(const Statement& s) {
  QueueListing out;
  s.read(out.entry, out.state, out.protocol_name, out.parameters_json, out.specimen_name,
         out.operator_name, out.note, out.terms_json, out.plan_json, out.added_by,
         out.added_unix_ns, out.resumes_run, out.attempts, out.last_run);
  return out;
}

QueueAct read_queue_act(const Statement& s) {
  QueueAct out;
  s.read(out.seq, out.at_unix_ns, out.act, out.entry, out.user, out.uid, out.detail);
  return out;
}

QueueState read_queue_state(const Statement& s) {
  QueueState out;
  std::optional<std::string> locked_by;
  QueueLock lock;
  s.read(out.going, out.held, out.held_why, out.failures_in_row, out.on_rig, locked_by, lock.uid,
         lock.why);
  if (!locked_by) return out;
  lock.user = std::move(*locked_by);
  out.lock = std::move(lock);
  return out;
}

QueuedRun read_queued_run(const Statement& s) {
  QueuedRun out;
  s.read(out.protocol_name, out.protocol_text, out.parameters_json, out.specimen_name,
         out.specimen_text, out.operator_name, out.note, out.terms_json, out.plan_json);
  return out;
}

Error no_such_entry(std::int64_t entry) {
  return Error(Errc::invalid_request,
               fmt::format("there was never an entry {}; see `lcrig queue list`", entry));
}

}  // namespace

Result<QueueState> get_queue_state(const Database& db) {
  auto state = db.first(
      "SELECT going, held_cause, held_why, failures_in_row, on_rig, locked_by, locked_uid,"
      " locked_why FROM queue_state",
      read_queue_state);
  if (!state) return fail(state.error());
  if (!*state) return fail(Errc::garbled, "{}: the state of the queue is missing", db.path());
  return std::move(**state);
}

Result<std::vector<QueueListing>> list_queue(const Database& db, std::int64_t skip,
                                             std::int64_t most) {
  return db.rows(
      fmt::format("{} WHERE e.place IS NOT NULL ORDER BY e.place LIMIT ? OFFSET ?", kQueueListing),
      read_queue_listing, most, skip);
}

Result<std::int64_t> count_queue(const Database& db) {
  return db.integer("SELECT count(*) FROM queue_entry WHERE place IS NOT NULL");
}

Result<std::int64_t> planned_bytes(const Database& db) {
  return db.integer(
      "SELECT coalesce(sum(plan_json ->> '$.bytes'), 0) FROM queue_entry"
      " WHERE place IS NOT NULL AND state <> ?",
      EntryState::running);
}

Result<std::int64_t> count_before(const Database& db, std::int64_t entry) {
  return db.integer(
      "SELECT count(*) FROM queue_entry WHERE place <"
      " (SELECT place FROM queue_entry WHERE id = ?)",
      entry);
}

Result<std::optional<QueueListing>> queue_head(const Database& db) {
  auto head = list_queue(db, 0, 1);
  if (!head) return fail(head.error());
  if (head->empty()) return std::optional<QueueListing>();
  return std::optional(std::move(head->front()));
}

Result<QueueListing> get_queue_entry(const Database& db, std::int64_t entry) {
  auto found = db.first(fmt::format("{} WHERE e.id = ?", kQueueListing), read_queue_listing, entry);
  if (!found) return fail(found.error());
  if (!*found) return fail(no_such_entry(entry));
  return std::move(**found);
}

Result<QueuedRun> get_queued_run(const Database& db, std::int64_t entry) {
  auto found = db.first(
      "SELECT e.protocol_name, p.text, e.parameters_json, e.specimen_name, s.text, e.operator,"
      " e.note, e.terms_json, e.plan_json FROM queue_entry AS e"
      " JOIN queue_text AS p ON p.sha256 = e.protocol_sha256"
      " JOIN queue_text AS s ON s.sha256 = e.specimen_sha256 WHERE e.id = ?",
      read_queued_run, entry);
  if (!found) return fail(found.error());
  if (!*found) return fail(no_such_entry(entry));
  return std::move(**found);
}

Result<std::vector<QueueAct>> queue_history(const Database& db, std::optional<std::int64_t> entry,
                                            std::int64_t before, std::int64_t most) {
  if (before <= 0) before = std::numeric_limits<std::int64_t>::max();
  return db.rows(
      "SELECT seq, at_unix_ns, act, entry_id, user, uid, detail FROM queue_act"
      " WHERE (?1 IS NULL OR entry_id = ?1) AND seq < ?2 ORDER BY seq DESC LIMIT ?3",
      read_queue_act, entry, before, most);
}

}  // namespace lcrig
