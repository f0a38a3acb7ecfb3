// SPDX-License-Identifier: Apache-2.0
// The stored queue of runs: its entries, their order, and the history of all actions with their
// users. Each writer is one transaction, so the queue survives a crash of the daemon. queue_run.hpp
// begins and ends entries; the daemon decides who may do what, and when. Used by the daemon's queue
// and by `lcrig queue`.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/queue_words.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// A run to be queued, with copies of its texts.
struct QueuedRun {
  std::string protocol_name, protocol_text;
  std::string parameters_json = "{}";  // names to numbers, or to texts as typed
  std::string specimen_name, specimen_text;
  std::string operator_name, note;
  std::string terms_json = "{}", plan_json = "null";
};

// The user who acts, and when. No uid: lcrigd itself acts.
struct QueueActor {
  std::string user = "lcrigd";
  std::optional<std::int64_t> uid;
  std::int64_t now_unix_ns = 0;

  static QueueActor itself(std::int64_t now_unix_ns) {
    QueueActor out;
    out.now_unix_ns = now_unix_ns;
    return out;
  }
};

// An entry without its texts.
struct QueueListing {
  std::int64_t entry = 0;
  EntryState state = EntryState::waiting;
  std::string protocol_name, parameters_json, specimen_name, operator_name, note;
  std::string terms_json, plan_json;
  std::string added_by;
  std::int64_t added_unix_ns = 0;
  std::int64_t attempts = 0;
  std::optional<std::int64_t> last_run;  // the run of its last attempt
  std::optional<std::int64_t> resumes_run;
};

struct QueueLock {
  std::string user, why;
  std::int64_t uid = 0;
};
struct QueueState {
  bool going = false;
  std::optional<HoldCause> held;  // set when the queue does not go
  std::string held_why;
  std::int64_t failures_in_row = 0;
  std::optional<std::string> on_rig;  // name of the specimen; nullopt: unknown
  std::optional<QueueLock> lock;
};

struct QueueAct {
  std::int64_t seq = 0, at_unix_ns = 0;
  std::string act, user, detail;
  std::optional<std::int64_t> entry, uid;
};

// Where to insert an entry. `first`: before all waiting entries, but after one that has begun.
struct QueuePlace {
  enum class Where { first, last, before, after };
  Where where = Where::last;
  std::int64_t entry = 0;  // for before and after
};

// Appends or inserts runs, all or none. Returns the numbers of the new entries, in the order of
// `runs`. Errors: as for move_in_queue.
Result<std::vector<std::int64_t>> add_to_queue(const Database& db, std::span<const QueuedRun> runs,
                                               QueuePlace place, const QueueActor& who);
// Errors: invalid_request when there is no such entry, or one of the two is no longer waiting.
Result<> move_in_queue(const Database& db, std::int64_t entry, QueuePlace place,
                       const QueueActor& who);
// Removes an entry that is not running. Errors: as for move_in_queue.
Result<> remove_from_queue(const Database& db, std::int64_t entry, const QueueActor& who);
// Removes all entries that are not running. Returns their number.
Result<std::int64_t> clear_queue(const Database& db, const QueueActor& who);

Result<> lock_queue(const Database& db, std::string_view why, const QueueActor& who);
Result<> unlock_queue(const Database& db, const QueueActor& who);
// Stores which specimen is on the rig, as a person reported.
Result<> tell_specimen_on_rig(const Database& db, std::string_view specimen, std::int64_t entry,
                              const QueueActor& who);

Result<QueueState> get_queue_state(const Database& db);
// Entries in their order, without the first `skip`. Errors: an unreadable database.
Result<std::vector<QueueListing>> list_queue(const Database& db, std::int64_t skip,
                                             std::int64_t most);
Result<std::int64_t> count_queue(const Database& db);
// Bytes that the plans of all waiting entries add up to.
Result<std::int64_t> planned_bytes(const Database& db);
Result<std::int64_t> count_before(const Database& db, std::int64_t entry);
Result<std::optional<QueueListing>> queue_head(const Database& db);
Result<QueueListing> get_queue_entry(const Database& db, std::int64_t entry);
Result<QueuedRun> get_queued_run(const Database& db, std::int64_t entry);
// Newest first, from before `before` (0: all). `entry`: only those of this entry.
Result<std::vector<QueueAct>> queue_history(const Database& db, std::optional<std::int64_t> entry,
                                            std::int64_t before, std::int64_t most);

// For queue_run.cpp: adds a row to the history, in the transaction of the action itself.
Result<> append_queue_act(const Database& db, std::string_view act,
                          std::optional<std::int64_t> entry, std::string_view detail,
                          const QueueActor& who);

}  // namespace lcrig
