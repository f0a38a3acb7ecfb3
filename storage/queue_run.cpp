// SPDX-License-Identifier: Apache-2.0
#include "storage/queue_run.hpp"

#include "base/exit_status.hpp"
#include "storage/queue_rows.hpp"

namespace lcrig {

namespace {

Result<> set_held(const Database& db, HoldCause cause, std::string_view why) {
  return db.change("UPDATE queue_state SET going = 0, held_cause = ?, held_why = ?", cause, why);
}

Result<> refuse_choice(HeadChoice choice, const std::optional<QueueListing>& head,
                       const QueueState& queue) {
  if (!head) return fail(Errc::invalid_request, "nothing is queued: `lcrig queue add` first");
  if (queue.going) return fail(Errc::invalid_request, "the queue goes already");
  const bool chosen = choice != HeadChoice::none;
  if (head->state == EntryState::waiting) {
    if (!chosen) return {};
    return fail(
        Errc::invalid_request,
        "entry {} has neither failed nor been interrupted: `lcrig queue start` without --{}",
        head->entry, to_string(choice));
  }
  if (head->state == EntryState::running) {
    // A queue that was held during this run may be started again.
    if (!chosen) return {};
    return fail(Errc::invalid_request, "entry {} is running: wait for its end", head->entry);
  }
  const std::string run = head->last_run ? fmt::format(" (run {})", *head->last_run) : "";
  if (head->state == EntryState::interrupted && !chosen) {
    return fail(Errc::invalid_request,
                "entry {}{} was interrupted: look at the rig, then `lcrig queue start --resume`, "
                "--repeat or --skip",
                head->entry, run);
  }
  if (head->state == EntryState::failed && (!chosen || choice == HeadChoice::resume)) {
    return fail(Errc::invalid_request,
                "entry {}{} failed: look at the rig, then `lcrig queue start --repeat` or --skip",
                head->entry, run);
  }
  return {};
}

Result<> apply_choice(const Database& db, HeadChoice choice, const QueueListing& head) {
  switch (choice) {
    case HeadChoice::none: return {};
    case HeadChoice::repeat: return set_entry_state(db, head.entry, EntryState::waiting);
    case HeadChoice::skip: return set_entry_state(db, head.entry, EntryState::skipped);
    case HeadChoice::resume:
      return db.change("UPDATE queue_entry SET state = ?, resumes_run = ? WHERE id = ?",
                       EntryState::waiting, head.last_run, head.entry);
  }
  return {};
}

// How the last attempt of an entry ended, judged by its run.
Result<EntryState> settled_state(const Database& db, std::int64_t run) {
  auto end = db.first<ExitStatus>("SELECT exit_status FROM run_end WHERE run_id = ?", run);
  if (!end) return fail(end.error());
  if (!*end || **end == ExitStatus::interrupted) return EntryState::interrupted;
  return **end == ExitStatus::success ? EntryState::done : EntryState::failed;
}

Result<> settle_head(const Database& db, const QueueListing& head, const QueueActor& who) {
  EntryState state = EntryState::interrupted;
  if (head.last_run) {
    if (auto r = keep(settled_state(db, *head.last_run), state); !r) return r;
  }
  if (auto r = set_entry_state(db, head.entry, state); !r) return r;
  return append_queue_act(db, "settle", head.entry,
                          fmt::format("found {} when lcrigd started", to_string(state)), who);
}

}  // namespace

Result<> claim_queue_entry(const Database& db, std::int64_t entry, std::int64_t run,
                           std::int64_t now_unix_ns) {
  auto queue = get_queue_state(db);
  if (!queue) return fail(queue.error());
  if (!queue->going) {
    return fail(Errc::aborted, "the queue was held before entry {} began ({})", entry,
                queue->held_why);
  }
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  if (!*head || (*head)->entry != entry || (*head)->state != EntryState::waiting) {
    return fail(Errc::aborted, "entry {} is not the next one any more", entry);
  }
  if (auto r = set_entry_state(db, entry, EntryState::running); !r) return r;
  const std::int64_t attempt = (*head)->attempts + 1;
  auto stored = db.change("INSERT INTO queue_attempt (entry_id, attempt, run_id) VALUES (?,?,?)",
                          entry, attempt, run);
  if (!stored) return stored;
  return append_queue_act(db, "begin", entry, fmt::format("run {}", run),
                          QueueActor::itself(now_unix_ns));
}

Result<> note_specimen_of_run(const Database& db, std::string_view specimen) {
  return db.change("UPDATE queue_state SET on_rig = ?", specimen);
}

Result<> end_queue_entry(const Database& db, std::int64_t entry, const EntryEnd& end,
                         const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  if (auto r = set_entry_state(db, entry, end.state); !r) return r;
  auto counted = db.change("UPDATE queue_state SET failures_in_row = ?", end.failures_in_row);
  if (!counted) return counted;
  if (end.hold) {
    if (auto r = set_held(db, *end.hold, end.why); !r) return r;
  }
  const auto words =
      fmt::format("{}{}{}", to_string(end.state), end.detail.empty() ? "" : ": ", end.detail);
  if (auto r = append_queue_act(db, "end", entry, words, who); !r) return r;
  if (end.hold) {
    if (auto r = append_queue_act(db, "hold", entry, end.why, who); !r) return r;
  }
  return transaction->commit();
}

Result<> start_queue(const Database& db, HeadChoice choice, const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  auto queue = get_queue_state(db);
  if (!queue) return fail(queue.error());
  if (auto r = refuse_choice(choice, *head, *queue); !r) return r;
  if (auto r = apply_choice(db, choice, **head); !r) return r;
  auto going = db.change(
      "UPDATE queue_state SET going = 1, held_cause = '', held_why = '', failures_in_row = 0");
  if (!going) return going;
  const auto words = choice == HeadChoice::none ? std::string_view() : to_string(choice);
  if (auto r = append_queue_act(db, "start", (*head)->entry, words, who); !r) return r;
  return transaction->commit();
}

Result<> hold_queue(const Database& db, HoldCause cause, std::string_view why,
                    const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto queue = get_queue_state(db);
  if (!queue) return fail(queue.error());
  if (!queue->going) return {};
  if (auto r = set_held(db, cause, why); !r) return r;
  if (auto r = append_queue_act(db, "hold", std::nullopt, why, who); !r) return r;
  return transaction->commit();
}

Result<bool> settle_queue(const Database& db, std::int64_t now_unix_ns) {
  const QueueActor who = QueueActor::itself(now_unix_ns);
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto queue = get_queue_state(db);
  if (!queue) return fail(queue.error());
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  // Includes a begun entry that waits to be repeated, because nobody knows what happened meanwhile.
  const bool cut_off = *head && ((*head)->state == EntryState::running ||
                                 ((*head)->state == EntryState::waiting && (*head)->attempts > 0));
  if (cut_off) {
    if (auto r = settle_head(db, **head, who); !r) return fail(r.error());
  }
  if (queue->going) {
    constexpr std::string_view kWhy = "lcrigd was restarted: nothing starts by itself";
    if (auto r = set_held(db, HoldCause::restart, kWhy); !r) return fail(r.error());
    if (auto r = append_queue_act(db, "hold", std::nullopt, kWhy, who); !r) return fail(r.error());
  }
  // The person who restarted the daemon may have changed the specimen, too.
  auto unknown = db.change("UPDATE queue_state SET on_rig = NULL");
  if (!unknown) return fail(unknown.error());
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return queue->going || cut_off;
}

}  // namespace lcrig
