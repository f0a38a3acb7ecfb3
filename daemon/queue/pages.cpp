// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/pages.hpp"

#include <utility>

#include "daemon/control/queue_messages.hpp"
#include "storage/batches.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kPageBytes = 400'000;  // of texts; an answer has at most 1 MiB

// Where the machine will be in its plan, entry by entry.
class PlannedClock {
 public:
  PlannedClock(std::int64_t now_unix_ns, const PlannedSum& before) : at_s_(before.duration_s) {
    now_ = now_unix_ns;
    known_ = before.unknown == 0;
  }
  PlannedTime take(const EntryPlan& plan) {
    PlannedTime out;
    if (known_) out.begin_unix_ns = unix_ns();
    known_ = known_ && plan.duration_s;
    at_s_ += plan.duration_s.value_or(0);
    if (known_) out.end_unix_ns = unix_ns();
    return out;
  }

 private:
  std::int64_t unix_ns() const { return now_ + from_seconds(at_s_).count(); }
  std::int64_t now_ = 0;
  double at_s_ = 0;
  bool known_ = true;
};

ListedEntry listed(QueueListing listing, PlannedClock& time, double left_s) {
  ListedEntry out;
  out.plan = parse_entry_plan(listing.plan_json);
  EntryPlan left = out.plan;
  if (listing.state == EntryState::running) left.duration_s = left_s;
  out.planned = time.take(left);
  out.listing = std::move(listing);
  return out;
}

}  // namespace

Result<QueuePage> read_queue_page(const Database& db, std::int64_t now_unix_ns, double left_s,
                                  std::int64_t skip, std::int64_t most) {
  QueuePage page;
  auto count = count_queue(db);
  if (!count) return fail(count.error());
  page.count = *count;
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  const bool runs = *head && (*head)->state == EntryState::running && skip > 0;
  auto before = sum_of_plans(db, runs ? skip - 1 : skip);
  if (!before) return fail(before.error());
  if (runs) before->duration_s += left_s;
  auto entries = list_queue(db, skip, most);
  if (!entries) return fail(entries.error());
  PlannedClock time(now_unix_ns, *before);
  std::size_t bytes = 0;
  page.entries.reserve(entries->size());
  for (QueueListing& entry : *entries) {
    bytes += entry.note.size() + entry.parameters_json.size() + entry.plan_json.size();
    if (bytes > kPageBytes && !page.entries.empty()) break;
    page.entries.push_back(listed(std::move(entry), time, left_s));
  }
  return page;
}

Result<ListedEntry> read_listed_entry(const Database& db, std::int64_t now_unix_ns, double left_s,
                                      std::int64_t entry) {
  auto found = get_queue_entry(db, entry);
  if (!found) return fail(found.error());
  auto ahead = count_before(db, entry);
  if (!ahead) return fail(ahead.error());
  auto before = sum_of_plans(db, *ahead);
  if (!before) return fail(before.error());
  if (found->state != EntryState::running) before->duration_s += left_s;
  PlannedClock time(now_unix_ns, *before);
  ListedEntry out = listed(std::move(*found), time, left_s);
  auto batch = batch_of_entry(db, entry);
  if (!batch) return fail(batch.error());
  out.batch = std::move(*batch);
  if (out.listing.state == EntryState::done || out.listing.state == EntryState::skipped ||
      out.listing.state == EntryState::removed) {
    out.planned = PlannedTime();
  }
  return out;
}

Result<QueueStatus> read_queue_at_rest(const Database& db) {
  auto state = get_queue_state(db);
  if (!state) return fail(state.error());
  auto count = count_queue(db);
  if (!count) return fail(count.error());
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  QueueStatus out;
  out.count = *count;
  if (*head) out.entry = (*head)->entry;
  out.cause = state->going ? "restart" : state->held_cause;
  out.why = state->going ? "lcrigd does not run" : state->held_why;
  if (state->lock) out.locked_by = state->lock->user;
  return out;
}

}  // namespace lcrig
