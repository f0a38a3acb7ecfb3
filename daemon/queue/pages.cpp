// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/pages.hpp"

#include <utility>

#include "daemon/control/queue_messages.hpp"
#include "daemon/queue/decide.hpp"
#include "storage/batches.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kPageBytes = 400'000;  // of texts; an answer has at most 1 MiB

// The planned time of each entry, one after the other. It includes rests and waits for a time of
// day, but not the unknown time that people take at gates.
class PlannedClock {
 public:
  // `left_s`: time left of the current run.
  PlannedClock(std::int64_t now_unix_ns, double left_s, std::optional<std::int64_t> last_end_ns)
      : left_s_(left_s), at_ns_(now_unix_ns), last_end_ns_(last_end_ns) {}

  PlannedTime take(const QueueListing& entry, const EntryPlan& plan) {
    PlannedTime out;
    const bool runs = entry.state == EntryState::running;
    if (!runs) wait_for(entry.terms_json);
    if (known_) out.begin_unix_ns = at_ns_;
    known_ = known_ && (runs || plan.duration_s);
    at_ns_ += from_seconds(runs ? left_s_ : plan.duration_s.value_or(0)).count();
    last_end_ns_ = at_ns_;
    if (known_) out.end_unix_ns = at_ns_;
    return out;
  }

 private:
  void wait_for(const std::string& terms_json) {
    if (terms_json != terms_json_) {  // entries of a batch usually have equal terms
      terms_ = parse_terms(terms_json).value_or(QueueTerms());
      terms_json_ = terms_json;
    }
    const std::int64_t now_s = at_ns_ / kSecond_ns;
    std::optional<std::int64_t> last_end_s;
    if (last_end_ns_) last_end_s = *last_end_ns_ / kSecond_ns;
    const BeginTime begin = begin_time(terms_, now_s, last_end_s);
    if (!begin.why.empty()) at_ns_ = begin.unix_s * kSecond_ns;
  }

  double left_s_;
  std::int64_t at_ns_;
  std::optional<std::int64_t> last_end_ns_;
  bool known_ = true;
  std::string terms_json_;
  QueueTerms terms_;
};

// The clock after the first `skip` entries.
Result<PlannedClock> clock_behind(const Database& db, std::int64_t now_unix_ns, double left_s,
                                  std::int64_t skip) {
  auto last_end = last_run_end_unix_ns(db);
  if (!last_end) return fail(last_end.error());
  PlannedClock out(now_unix_ns, left_s, *last_end);
  auto before = list_queue(db, 0, skip);
  if (!before) return fail(before.error());
  for (const QueueListing& entry : *before) out.take(entry, parse_entry_plan(entry.plan_json));
  return out;
}

ListedEntry listed(QueueListing listing, PlannedClock& time) {
  ListedEntry out;
  out.plan = parse_entry_plan(listing.plan_json);
  out.planned = time.take(listing, out.plan);
  out.listing = std::move(listing);
  return out;
}

}  // namespace

Result<QueuePage> read_queue_page(const Database& db, std::int64_t now_unix_ns, double left_s,
                                  std::int64_t skip, std::int64_t most) {
  QueuePage page;
  if (auto r = keep(count_queue(db), page.count); !r) return fail(r.error());
  auto time = clock_behind(db, now_unix_ns, left_s, skip);
  if (!time) return fail(time.error());
  auto entries = list_queue(db, skip, most);
  if (!entries) return fail(entries.error());
  std::size_t bytes = 0;
  page.entries.reserve(entries->size());
  for (QueueListing& entry : *entries) {
    bytes += entry.note.size() + entry.parameters_json.size() + entry.plan_json.size();
    if (bytes > kPageBytes && !page.entries.empty()) break;
    page.entries.push_back(listed(std::move(entry), *time));
  }
  return page;
}

Result<ListedEntry> read_listed_entry(const Database& db, std::int64_t now_unix_ns, double left_s,
                                      std::int64_t entry) {
  auto found = get_queue_entry(db, entry);
  if (!found) return fail(found.error());
  auto ahead = count_before(db, entry);
  if (!ahead) return fail(ahead.error());
  auto time = clock_behind(db, now_unix_ns, left_s, *ahead);
  if (!time) return fail(time.error());
  ListedEntry out = listed(std::move(*found), *time);
  if (auto r = keep(batch_of_entry(db, entry), out.batch); !r) return fail(r.error());
  if (out.listing.state == EntryState::done || out.listing.state == EntryState::skipped ||
      out.listing.state == EntryState::removed) {
    out.planned = PlannedTime();
  }
  return out;
}

Result<QueueStatus> read_queue_at_rest(const Database& db) {
  QueueStatus out;
  auto state = get_queue_state(db);
  if (!state) return fail(state.error());
  if (auto r = keep(count_queue(db), out.count); !r) return fail(r.error());
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  if (*head) out.entry = (*head)->entry;
  out.cause = state->going ? HoldCause::restart : state->held;
  out.why = state->going ? "lcrigd does not run" : state->held_why;
  if (state->lock) out.locked_by = state->lock->user;
  return out;
}

}  // namespace lcrig
