// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/runner.hpp"

#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.hpp"
#include "daemon/control/params.hpp"
#include "daemon/control/queue_messages.hpp"
#include "daemon/run_words.hpp"
#include "storage/runs.hpp"

namespace lcrig {

using namespace std::chrono_literals;
using nlohmann::json;

namespace {

constexpr Duration kLongestLook = 10s;  // a waited-for time may come sooner when the clock is set
constexpr Duration kPresence = 15min;  // after which a person who acted may be gone
constexpr Duration kBetweenTries = 10s;  // between repeated attempts

std::int64_t wall_offset_ns(const Clock& clock) {
  return clock.unix_ns() - clock.now().time_since_epoch().count();
}

Result<RunRequest> request_of(const QueuedRun& stored) {
  RunRequest out;
  out.protocol_name = stored.protocol_name;
  out.protocol_text = stored.protocol_text;
  out.specimen_name = stored.specimen_name;
  out.specimen_text = stored.specimen_text;
  out.operator_name = stored.operator_name;
  out.note = stored.note;
  const json object{{"parameters", json::parse(stored.parameters_json, nullptr, false)}};
  ParamsReader in(object, "entry");
  in.numbers("parameters", out.parameters);
  if (auto ok = in.finish(); !ok) return fail(ok.error());
  return out;
}

EntryOutcome outcome_of(const TurnEnd& end, const QueueListing& entry) {
  EntryOutcome out;
  out.begun = end.outcome.has_value();
  out.resumes = entry.resumes_run.has_value();
  out.hazard = end.hazard;
  if (out.begun) {
    out.status = end.outcome->exit_status;
    out.code = end.outcome->code;
    out.reason = end.outcome->reason;
  } else {
    out.code = end.outcome.error().code;
    out.reason = end.outcome.error().what;
  }
  return out;
}

// Stores the consequences of an outcome. nullopt: somebody held the queue before the entry began.
Result<std::optional<EntryEnd>> settle_turn(const Database& db, std::int64_t entry,
                                            const TurnEnd& end, const QueueActor& who) {
  auto listing = get_queue_entry(db, entry);
  if (!listing) return fail(listing.error());
  auto state = get_queue_state(db);
  if (!state) return fail(state.error());
  auto terms = parse_terms(listing->terms_json);
  if (!terms) return fail(terms.error());
  const EntryOutcome outcome = outcome_of(end, *listing);
  if (!outcome.begun && !state->going && !outcome.hazard && !outcome.resumes) {
    return std::optional<EntryEnd>();
  }
  auto after = aftermath_of(outcome, *terms, listing->attempts, state->failures_in_row);
  if (auto r = end_queue_entry(db, entry, after, who); !r) return fail(r.error());
  return std::optional(std::move(after));
}

}  // namespace

QueueRunner::QueueRunner(asio::any_io_executor executor, Clock& clock, QueueHost& host,
                         std::string database, std::string vfs)
    : clock_(clock),
      host_(host),
      store_(std::move(executor), clock, std::move(database), std::move(vfs)),
      changed_(clock) {}

void QueueRunner::wake() {
  ++wakes_;
  changed_.notify_all();
}

void QueueRunner::end() {
  ending_ = true;
  wake();
}

Task<> QueueRunner::run() {
  while (!ending_) co_await step();
  co_await store_.settle();
  over_ = true;
  wake();
}

Result<QueueRunner::Look> QueueRunner::look_at(const Database& db) {
  Look out;
  auto read = keep(get_queue_state(db), out.state);
  if (read) read = keep(count_queue(db), out.count);
  if (read) read = keep(queue_head(db), out.head);
  if (read) read = keep(last_run_end_unix_ns(db), out.last_end_unix_ns);
  if (!read) return fail(read.error());
  return out;
}

QueueFacts QueueRunner::facts_of(const Look& look) const {
  QueueFacts out;
  out.going = look.state.going;
  out.run_goes_on = host_.is_running();
  out.on_rig = look.state.on_rig;
  out.person_there = person_seen_ && clock_.now() - *person_seen_ <= kPresence;
  out.probe = probe_;
  out.fixture = fixture_;
  out.now_unix_s = clock_.unix_ns() / kSecond_ns;
  if (look.last_end_unix_ns) out.last_end_unix_s = *look.last_end_unix_ns / kSecond_ns;
  if (!look.head) return out;
  HeadFacts head;
  head.entry = look.head->entry;
  if (stranger_ && stranger_->first == head.entry) out.stranger = stranger_->second;
  head.state = look.head->state;
  head.protocol = look.head->protocol_name;
  head.specimen = look.head->specimen_name;
  head.moves = parse_entry_plan(look.head->plan_json).moves;
  // If the terms do not parse, the strictest apply.
  if (const auto terms = parse_terms(look.head->terms_json)) head.terms = *terms;
  out.head = std::move(head);
  return out;
}

Result<bool> QueueRunner::open(const Database& db) {
  auto was_going = settle_queue(db, clock_.unix_ns());
  if (!was_going) return was_going;
  auto look = look_at(db);
  if (!look) return fail(look.error());
  show_look(*look, next_act(facts_of(*look)));
  return was_going;
}

Task<Result<NextAct>> QueueRunner::look() {
  const auto job = [](const Database& db) { return look_at(db); };
  auto look = co_await store_.with(job);
  if (!look) {
    spdlog::warn("the queue cannot be read: {}", printable(look.error().what, kLongestReason));
    co_return fail(look.error());
  }
  NextAct next = next_act(facts_of(*look));
  show_look(*look, next);
  // The clock is watched from the moment when clients can see that the queue waits for a time.
  if (std::holds_alternative<WaitUntil>(next) && !waiting_offset_ns_) {
    waiting_offset_ns_ = wall_offset_ns(clock_);
  }
  co_return next;
}

// Looks at the queue, and does one thing or waits for a change.
Task<> QueueRunner::step() {
  const std::uint64_t seen = wakes_;
  auto next = co_await look();
  if (ending_) co_return;
  const auto step_s = next ? clock_step_s(*next) : std::nullopt;
  const bool stays = next && std::holds_alternative<Stay>(*next);
  const Duration patience = stays ? Duration(24h) : kLongestLook;
  if (!next) {
    co_await wait_for_change(seen, kBetweenTries);
  } else if (step_s) {
    auto why = fmt::format(
        "somebody set the clock by {:.0f} s while the queue waited for a time: nothing begins "
        "before a person says so",
        *step_s);
    co_await hold_by_itself(HoldCause::clock_step, std::move(why));
  } else if (const Begin* begin = std::get_if<Begin>(&*next)) {
    co_await take_turn(begin->entry);
  } else if (std::holds_alternative<Finished>(*next)) {
    co_await finish();
  } else if (const TooLate* late = std::get_if<TooLate>(&*next)) {
    co_await refuse_late(*late);
  } else {
    co_await wait_for_change(seen, patience);
  }
}

// How far the clock was set. A person who sets it by hours may not know that a run waits for a
// time.
std::optional<double> QueueRunner::clock_step_s(const NextAct& next) {
  constexpr std::int64_t kStep_ns = 2 * kSecond_ns;
  const std::int64_t offset_ns = wall_offset_ns(clock_);
  const auto before = waiting_offset_ns_;
  waiting_offset_ns_.reset();
  if (before && std::abs(offset_ns - *before) > kStep_ns && !std::holds_alternative<Stay>(next)) {
    return static_cast<double>(offset_ns - *before) / 1e9;
  }
  if (std::holds_alternative<WaitUntil>(next)) waiting_offset_ns_ = offset_ns;
  return std::nullopt;
}

Task<> QueueRunner::refuse_late(TooLate late) {
  TurnEnd end;
  end.outcome = fail(Errc::invalid_request, "{}", late.why);
  co_await store_end(late.entry, std::move(end));
}

Task<> QueueRunner::wait_for_change(std::uint64_t seen, Duration patience) {
  const MonoTime limit = clock_.now() + patience;
  const auto changed = [this, seen] { return wakes_ != seen || ending_; };
  co_await changed_.wait(changed, limit);
}

// Updates the status that clients see. Logs a gate when it first appears.
void QueueRunner::show_look(const Look& look, const NextAct& next) {
  const Gate* gate = std::get_if<Gate>(&next);
  const std::string before = status_.prompt;
  QueueStatus now;
  now.going = look.state.going;
  now.cause = look.state.held;
  now.why = look.state.held_why;
  now.count = look.count;
  if (look.head) now.entry = look.head->entry;
  if (look.state.lock) now.locked_by = look.state.lock->user;
  gate_.reset();
  if (gate != nullptr && !answering_) {
    gate_ = *gate;
    now.gate = gate->kind;
    now.prompt = gate->prompt;
  }
  if (const WaitUntil* wait = std::get_if<WaitUntil>(&next)) {
    now.gate = QueueGate::time;
    now.prompt = wait->why;
  }
  status_ = std::move(now);
  if (!status_.prompt.empty() && status_.prompt != before) {
    spdlog::info("the queue waits: {}", printable(status_.prompt, kLongestReason));
  }
  host_.queue_changed(status_);
}

Task<> QueueRunner::finish() {
  spdlog::info("the queue is done");
  std::string why("nothing is left in it");
  co_await hold_by_itself(HoldCause::empty, std::move(why));
}

Task<> QueueRunner::hold_by_itself(HoldCause cause, std::string why) {
  if (cause != HoldCause::empty) {
    spdlog::warn("the queue holds ({}): {}", to_string(cause), printable(why, kLongestReason));
  }
  const QueueActor who = QueueActor::itself(clock_.unix_ns());
  const auto job = [cause, why, who](const Database& db) {
    return hold_queue(db, cause, why, who);
  };
  auto held = co_await store_.with(job);
  const std::uint64_t seen = wakes_;
  if (!held) co_await wait_for_change(seen, kBetweenTries);
}

// The entry with its texts, checked for the disk space that it needs.
Task<Result<TurnOfQueue>> QueueRunner::turn_of(std::int64_t entry) {
  const auto job = [this, entry](const Database& db) -> Result<TurnOfQueue> {
    auto stored = get_queued_run(db, entry);
    if (!stored) return fail(stored.error());
    auto listing = get_queue_entry(db, entry);
    if (!listing) return fail(listing.error());
    if (auto room = store_.check_room(parse_entry_plan(stored->plan_json).bytes); !room) {
      return fail(room.error());
    }
    auto run = request_of(*stored);
    if (!run) return fail(run.error());
    TurnOfQueue out;
    out.entry = entry;
    out.run = std::move(*run);
    out.resumes_run = listing->resumes_run;
    return out;
  };
  co_return co_await store_.with(job);
}

Task<> QueueRunner::take_turn(std::int64_t entry) {
  const std::uint64_t seen = wakes_;
  const auto seen_before = std::exchange(person_seen_, std::nullopt);
  TurnEnd end;
  auto turn = co_await turn_of(entry);
  if (turn) {
    turn->compares = vouched_ != entry;
    end = co_await host_.take_turn(std::move(*turn));
  } else {
    end.outcome = fail(turn.error());
  }
  if (!end.outcome) person_seen_ = seen_before;  // nothing moved
  if (end.stranger) {
    stranger_.emplace(entry, *end.stranger);
    co_return;
  }
  // Somebody else was quicker; this entry begins after that run.
  if (!end.outcome && end.outcome.error().code == Errc::busy) {
    co_await wait_for_change(seen, kBetweenTries);
    co_return;
  }
  co_await store_end(entry, std::move(end));
}

// Tries until the end is stored. Until then the entry stays at the head and nothing else begins.
Task<> QueueRunner::store_end(std::int64_t entry, TurnEnd end) {
  for (;;) {
    const QueueActor who = QueueActor::itself(clock_.unix_ns());
    const auto job = [entry, &end, &who](const Database& db) {
      return settle_turn(db, entry, end, who);
    };
    auto after = co_await store_.with(job);
    const std::uint64_t seen = wakes_;
    if (!after) {
      spdlog::error("how entry {} of the queue ended is not stored: {}", entry,
                    printable(after.error().what, kLongestReason));
      if (ending_) co_return;  // the next start finds the end in the run
      co_await wait_for_change(seen, kBetweenTries);
      continue;
    }
    if (!*after) co_return;
    if ((*after)->hold) {
      person_seen_.reset();
      spdlog::warn("the queue holds ({}): {}", to_string(*(*after)->hold),
                   printable((*after)->why, kLongestReason));
    } else if ((*after)->state == EntryState::waiting) {
      co_await wait_for_change(seen, kBetweenTries);
    }
    co_return;
  }
}

}  // namespace lcrig
