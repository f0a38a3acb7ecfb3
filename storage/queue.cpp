// SPDX-License-Identifier: Apache-2.0
#include "storage/queue.hpp"

#include <algorithm>

#include "base/enum_words.hpp"
#include "base/text.hpp"
#include "storage/queue_rows.hpp"
#include "storage/row_hash.hpp"

namespace lcrig {

namespace {

// Distance between neighbours. About 20 entries fit between two of them before all places are
// renumbered.
constexpr std::int64_t kStep = std::int64_t{1} << 20U;

Result<EntryState> state_of(std::string_view word) {
  if (const auto known = parse_word<EntryState>(word)) return *known;
  return fail(Errc::garbled, "the queue holds an entry in state \"{}\"", printable(word, 40));
}

Error no_entry(std::int64_t entry) {
  return Error(Errc::invalid_request,
               fmt::format("no entry {} is in the queue; see `lcrig queue list`", entry));
}

// The places of the entries before and after a gap; nullopt at either end of the queue.
struct Gap {
  std::optional<std::int64_t> behind, before;
};

// `moved`: the entry that is to be moved, which is ignored here.
Result<Gap> find_gap(const Database& db, QueuePlace to, std::int64_t moved) {
  using Where = QueuePlace::Where;
  using Place = std::int64_t;
  Gap gap;
  Result<std::optional<Place>> at;
  if (to.where == Where::last) {
    at = db.first<Place>("SELECT max(place) FROM queue_entry WHERE id <> ?", moved);
    if (!at) return fail(at.error());
    gap.behind = *at;
    return gap;
  }
  if (to.where == Where::first) {
    at = db.first<Place>(
        "SELECT min(place) FROM queue_entry WHERE id <> ?"
        " AND id NOT IN (SELECT entry_id FROM queue_attempt)",
        moved);
    if (at && !*at) return find_gap(db, QueuePlace(), moved);
  } else {
    at = db.first<Place>("SELECT place FROM queue_entry WHERE id = ?", to.entry);
    if (at && !*at) return fail(no_entry(to.entry));
  }
  if (!at) return fail(at.error());
  const std::int64_t place = **at;
  const bool after = to.where == Where::after;
  auto other =
      db.first<Place>(after ? "SELECT min(place) FROM queue_entry WHERE place > ? AND id <> ?"
                            : "SELECT max(place) FROM queue_entry WHERE place < ? AND id <> ?",
                      place, moved);
  if (!other) return fail(other.error());
  gap.behind = after ? std::optional(place) : *other;
  gap.before = after ? *other : std::optional(place);
  return gap;
}

// Renumbers all entries from beyond the largest place upwards, so that no two share a place at any
// moment.
Result<> number_anew(const Database& db) {
  auto entries =
      db.rows<std::int64_t>("SELECT id FROM queue_entry WHERE place IS NOT NULL ORDER BY place");
  if (!entries) return fail(entries.error());
  auto most = db.integer("SELECT coalesce(max(place), 0) FROM queue_entry");
  if (!most) return fail(most.error());
  std::int64_t place = std::max<std::int64_t>(*most, 0);
  for (const std::int64_t entry : *entries) {
    place += kStep;
    auto moved = db.change("UPDATE queue_entry SET place = ? WHERE id = ?", place, entry);
    if (!moved) return moved;
  }
  return {};
}

// The first of `room` free places in a gap, which are `step` apart.
struct Slot {
  std::int64_t first = 0, step = kStep;
};
Result<Slot> find_slot(const Database& db, QueuePlace to, std::int64_t room, std::int64_t moved) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    auto gap = find_gap(db, to, moved);
    if (!gap) return fail(gap.error());
    Slot slot;
    if (!gap->before) {
      slot.first = gap->behind.value_or(0) + kStep;
      return slot;
    }
    if (!gap->behind) {
      slot.first = *gap->before - room * kStep;
      return slot;
    }
    slot.step = (*gap->before - *gap->behind) / (room + 1);
    if (slot.step > 0) {
      slot.first = *gap->behind + slot.step;
      return slot;
    }
    if (auto r = number_anew(db); !r) return fail(r.error());
  }
  return fail(Errc::invalid_request, "no place for {} entries there: add them last", room);
}

std::string words_of(EntryState state) {
  return fmt::format("{} {}",
                     state == EntryState::interrupted ? "was"
                     : state == EntryState::failed    ? "has"
                                                      : "is",
                     to_string(state));
}

Result<EntryState> state_in_queue(const Database& db, std::int64_t entry) {
  auto state = db.first(
      "SELECT state FROM queue_entry WHERE id = ? AND place IS NOT NULL",
      [](const Statement& s) { return state_of(s.text(0)); }, entry);
  if (!state) return fail(state.error());
  if (!*state) return fail(no_entry(entry));
  return **state;
}

// Errors: invalid_request when the entry has begun. It stays at the head of the queue, even while
// it waits to be repeated.
Result<> has_not_begun(const Database& db, std::int64_t entry, std::string_view so) {
  auto state = state_in_queue(db, entry);
  if (!state) return fail(state.error());
  auto begun = db.holds("SELECT count(*) FROM queue_attempt WHERE entry_id = ?", entry);
  if (!begun) return fail(begun.error());
  if (!*begun) return {};
  return fail(Errc::invalid_request, "entry {} {}: {}", entry,
              *state == EntryState::waiting ? "is about to be begun again" : words_of(*state), so);
}

Result<> can_stand(const Database& db, QueuePlace to) {
  if (to.where != QueuePlace::Where::before) return {};
  return has_not_begun(db, to.entry, "nothing can stand before it");
}

Result<std::int64_t> insert_entry(const Database& db, const QueuedRun& run, std::int64_t place,
                                  const QueueActor& who) {
  auto protocol = store_queue_text(db, run.protocol_text);
  if (!protocol) return fail(protocol.error());
  auto specimen = store_queue_text(db, run.specimen_text);
  if (!specimen) return fail(specimen.error());
  auto stored = db.change(
      "INSERT INTO queue_entry (place, state, protocol_name, protocol_sha256, parameters_json,"
      " specimen_name, specimen_sha256, operator, note, terms_json, plan_json, added_by,"
      " added_uid, added_unix_ns) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
      place, EntryState::waiting, run.protocol_name, *protocol, run.parameters_json,
      run.specimen_name, *specimen, run.operator_name, run.note, run.terms_json, run.plan_json,
      who.user, who.uid.value_or(-1), who.now_unix_ns);
  if (!stored) return fail(stored.error());
  return db.last_insert_id();
}

std::string words_of(QueuePlace place) {
  switch (place.where) {
    case QueuePlace::Where::first: return "first";
    case QueuePlace::Where::last: return "last";
    case QueuePlace::Where::before: return fmt::format("before {}", place.entry);
    case QueuePlace::Where::after: return fmt::format("after {}", place.entry);
  }
  return {};
}

}  // namespace

Result<> append_queue_act(const Database& db, std::string_view act,
                          std::optional<std::int64_t> entry, std::string_view detail,
                          const QueueActor& who) {
  return db.change(
      "INSERT INTO queue_act (at_unix_ns, act, entry_id, user, uid, detail) VALUES (?,?,?,?,?,?)",
      who.now_unix_ns, act, entry, who.user, who.uid, detail);
}

Result<> set_entry_state(const Database& db, std::int64_t entry, EntryState state) {
  const bool leaves =
      state == EntryState::done || state == EntryState::skipped || state == EntryState::removed;
  return db.change(leaves ? "UPDATE queue_entry SET state = ?, place = NULL, resumes_run = NULL "
                            "WHERE id = ?"
                          : "UPDATE queue_entry SET state = ?, resumes_run = NULL WHERE id = ?",
                   state, entry);
}

Result<std::string> store_queue_text(const Database& db, const std::string& text) {
  std::string sha256 = sha256_hex(text);
  auto stored = db.change("INSERT OR IGNORE INTO queue_text (sha256, text) VALUES (?,?)", sha256,
                          std::string_view(text));
  if (!stored) return fail(stored.error());
  return sha256;
}

Result<std::vector<std::int64_t>> insert_into_queue(const Database& db, std::size_t count,
                                                    const QueuedRuns& run_at, QueuePlace place,
                                                    const QueueActor& who, std::string_view why) {
  if (auto r = can_stand(db, place); !r) return fail(r.error());
  auto slot = find_slot(db, place, static_cast<std::int64_t>(count), 0);
  if (!slot) return fail(slot.error());
  // A queue that had finished does not start by itself when an entry is added.
  auto begun_anew = db.change(
      "UPDATE queue_state SET held_cause = ?, held_why = 'nobody has started it'"
      " WHERE going = 0 AND held_cause = ?",
      HoldCause::not_started, HoldCause::empty);
  if (!begun_anew) return fail(begun_anew.error());
  const auto detail = fmt::format("{}{}{}", words_of(place), why.empty() ? "" : ", ", why);
  std::vector<std::int64_t> out;
  out.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    auto entry = insert_entry(db, *run_at(i), slot->first, who);
    if (!entry) return fail(entry.error());
    if (auto r = append_queue_act(db, "add", *entry, detail, who); !r) return fail(r.error());
    out.push_back(*entry);
    slot->first += slot->step;
  }
  return out;
}

Result<std::vector<std::int64_t>> add_to_queue(const Database& db, std::span<const QueuedRun> runs,
                                               QueuePlace place, const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  const auto run_at = [runs](std::size_t i) { return &runs[i]; };
  auto out = insert_into_queue(db, runs.size(), run_at, place, who);
  if (!out) return out;
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return out;
}

Result<> move_in_queue(const Database& db, std::int64_t entry, QueuePlace place,
                       const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  if (auto r = has_not_begun(db, entry, "it stays where it is"); !r) return r;
  if (place.entry == entry) return fail(Errc::invalid_request, "entry {} is there already", entry);
  if (auto r = can_stand(db, place); !r) return r;
  auto slot = find_slot(db, place, 1, entry);
  if (!slot) return fail(slot.error());
  auto moved = db.change("UPDATE queue_entry SET place = ? WHERE id = ?", slot->first, entry);
  if (!moved) return moved;
  if (auto r = append_queue_act(db, "move", entry, words_of(place), who); !r) return r;
  return transaction->commit();
}

Result<> remove_from_queue(const Database& db, std::int64_t entry, const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto state = state_in_queue(db, entry);
  if (!state) return fail(state.error());
  if (*state == EntryState::running) {
    return fail(Errc::invalid_request, "entry {} is running: `lcrig abort` stops its run", entry);
  }
  if (auto r = set_entry_state(db, entry, EntryState::removed); !r) return r;
  if (auto r = append_queue_act(db, "remove", entry, "", who); !r) return r;
  return transaction->commit();
}

Result<std::int64_t> clear_queue(const Database& db, const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto entries = db.rows<std::int64_t>(
      "SELECT id FROM queue_entry WHERE place IS NOT NULL AND state <> ? ORDER BY place",
      EntryState::running);
  if (!entries) return fail(entries.error());
  for (const std::int64_t entry : *entries) {
    if (auto r = set_entry_state(db, entry, EntryState::removed); !r) return fail(r.error());
    if (auto r = append_queue_act(db, "remove", entry, "clear", who); !r) return fail(r.error());
  }
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return static_cast<std::int64_t>(entries->size());
}

Result<> lock_queue(const Database& db, std::string_view why, const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto locked = db.change("UPDATE queue_state SET locked_by = ?, locked_uid = ?, locked_why = ?",
                          who.user, who.uid.value_or(-1), why);
  if (!locked) return locked;
  if (auto r = append_queue_act(db, "lock", std::nullopt, why, who); !r) return r;
  return transaction->commit();
}

Result<> unlock_queue(const Database& db, const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto unlocked =
      db.change("UPDATE queue_state SET locked_by = NULL, locked_uid = NULL, locked_why = NULL");
  if (!unlocked) return unlocked;
  if (auto r = append_queue_act(db, "unlock", std::nullopt, "", who); !r) return r;
  return transaction->commit();
}

Result<> tell_specimen_on_rig(const Database& db, std::string_view specimen, std::int64_t entry,
                              const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  if (auto r = db.change("UPDATE queue_state SET on_rig = ?", specimen); !r) return r;
  if (auto r = append_queue_act(db, "on_rig", entry, specimen, who); !r) return r;
  return transaction->commit();
}

}  // namespace lcrig
