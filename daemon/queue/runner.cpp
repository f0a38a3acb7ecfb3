// SPDX-License-Identifier: Apache-2.0
#include "daemon/queue/runner.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.hpp"
#include "daemon/control/params.hpp"
#include "daemon/control/queue_messages.hpp"

namespace lcrig {

using namespace std::chrono_literals;
using nlohmann::json;

namespace {

constexpr Duration kBetweenTries = 10s;  // of what is repeated by itself
constexpr std::size_t kLongestReason = 500;  // characters in the journal

QueueActor itself(const Clock& clock) {
  QueueActor out;
  out.now_unix_ns = clock.unix_ns();
  return out;
}

// Of a run that is about to begin; the recorder checks again.
Result<> check_room(const std::string& database, std::int64_t bytes) {
  std::error_code unknown;
  const auto folder = std::filesystem::absolute(database).parent_path();
  const auto space = std::filesystem::space(folder, unknown);
  if (unknown || space.available >= static_cast<std::uintmax_t>(bytes)) return {};
  return fail(Errc::io, "{}: {:.1f} MB are free, and the runs that wait need {:.1f} MB: free some",
              folder.string(), static_cast<double>(space.available) / 1e6,
              static_cast<double>(bytes) / 1e6);
}

Result<> not_locked(const Database& db, const QueueActor& who) {
  auto state = get_queue_state(db);
  if (!state) return fail(state.error());
  if (!state->lock || state->lock->uid == who.uid) return {};
  const auto& lock = *state->lock;
  return fail(Errc::busy,
              "the queue is locked by {}{}: nobody else changes it; `lcrig queue unlock --force` "
              "unlocks it all the same",
              lock.user, lock.why.empty() ? "" : " (" + printable(lock.why, 200) + ")");
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

QueuedRun stored_form(const QueueAdd& wanted, const EntryPlan& plan) {
  QueuedRun out;
  out.protocol_name = wanted.run.protocol_name;
  out.protocol_text = wanted.run.protocol_text;
  out.parameters_json = to_json(wanted.run)["parameters"].dump();
  out.specimen_name = wanted.run.specimen_name;
  out.specimen_text = wanted.run.specimen_text;
  out.operator_name = wanted.run.operator_name;
  out.note = wanted.run.note;
  out.terms_json = to_json_text(wanted.terms);
  out.plan_json = to_json(plan).dump();
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

// Stores what follows from an outcome. nullopt: somebody held the queue before the entry began.
Result<std::optional<Aftermath>> settle_turn(const Database& db, std::int64_t entry,
                                             const TurnEnd& end, const QueueActor& who) {
  auto listing = get_queue_entry(db, entry);
  if (!listing) return fail(listing.error());
  auto state = get_queue_state(db);
  if (!state) return fail(state.error());
  auto terms = parse_terms(listing->terms_json);
  if (!terms) return fail(terms.error());
  const EntryOutcome outcome = outcome_of(end, *listing);
  if (!outcome.begun && !state->going && !outcome.hazard && !outcome.resumes) {
    return std::optional<Aftermath>();
  }
  auto after = aftermath_of(outcome, *terms, listing->attempts, state->failures_in_row);
  EntryEnd stored;
  stored.state = after.entry;
  stored.goes_on = !after.hold;
  if (after.hold) stored.cause = to_string(*after.hold);
  stored.why = after.why;
  stored.failures_in_row = after.failures_in_row;
  stored.detail = outcome.reason;
  if (auto r = end_queue_entry(db, entry, stored, who); !r) return fail(r.error());
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
  auto state = get_queue_state(db);
  if (!state) return fail(state.error());
  out.state = std::move(*state);
  auto count = count_queue(db);
  if (!count) return fail(count.error());
  out.count = *count;
  auto head = queue_head(db);
  if (!head) return fail(head.error());
  out.head = std::move(*head);
  return out;
}

QueueFacts QueueRunner::facts_of(const Look& look) const {
  QueueFacts out;
  out.going = look.state.going;
  out.run_goes_on = host_.is_running();
  out.on_rig = look.state.on_rig;
  out.person_there = person_there_;
  if (!look.head) return out;
  HeadFacts head;
  head.entry = look.head->entry;
  head.state = look.head->state;
  head.protocol = look.head->protocol_name;
  head.specimen = look.head->specimen_name;
  head.moves = parse_entry_plan(look.head->plan_json).moves;
  // Terms that do not parse are the strictest.
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
  co_return next;
}

Task<> QueueRunner::tell_change() {
  auto next = co_await look();
  static_cast<void>(next);  // `run` looks, too, and does it
  wake();
}

// Looks, and does one thing or waits until something changed.
Task<> QueueRunner::step() {
  const std::uint64_t seen = wakes_;
  auto next = co_await look();
  if (ending_) co_return;
  if (!next) {
    co_await wait_for_change(seen, kBetweenTries);
  } else if (const Begin* begin = std::get_if<Begin>(&*next)) {
    co_await take_turn(begin->entry);
  } else if (std::holds_alternative<Finished>(*next)) {
    co_await finish();
  } else {
    co_await wait_for_change(seen, 24h);
  }
}

Task<> QueueRunner::wait_for_change(std::uint64_t seen, Duration patience) {
  const MonoTime limit = clock_.now() + patience;
  const auto changed = [this, seen] { return wakes_ != seen || ending_; };
  co_await changed_.wait(changed, limit);
}

// Whoever looks sees what the queue waits for; a gate is told once.
void QueueRunner::show_look(const Look& look, const NextAct& next) {
  const Gate* gate = std::get_if<Gate>(&next);
  const std::string before = status_.prompt;
  QueueStatus now;
  now.going = look.state.going;
  now.cause = look.state.held_cause;
  now.why = look.state.held_why;
  now.count = look.count;
  if (look.head) now.entry = look.head->entry;
  if (look.state.lock) now.locked_by = look.state.lock->user;
  gate_.reset();
  if (gate != nullptr && !answering_) {
    gate_ = *gate;
    now.gate = to_string(gate->kind);
    now.prompt = gate->prompt;
  }
  status_ = std::move(now);
  if (!status_.prompt.empty() && status_.prompt != before) {
    spdlog::info("the queue waits: {}", printable(status_.prompt, kLongestReason));
  }
  host_.queue_changed(status_);
}

Task<> QueueRunner::finish() {
  const QueueActor who = itself(clock_);
  const auto job = [who](const Database& db) {
    return hold_queue(db, to_string(HoldCause::empty), "nothing is left in it", who);
  };
  auto held = co_await store_.with(job);
  if (held) {
    spdlog::info("the queue is done");
  } else {
    const std::uint64_t seen = wakes_;
    co_await wait_for_change(seen, kBetweenTries);
  }
}

// The entry with its texts; what it needs is there.
Task<Result<TurnOfQueue>> QueueRunner::turn_of(std::int64_t entry) {
  const auto job = [entry, path = store_.path()](const Database& db) -> Result<TurnOfQueue> {
    auto stored = get_queued_run(db, entry);
    if (!stored) return fail(stored.error());
    auto listing = get_queue_entry(db, entry);
    if (!listing) return fail(listing.error());
    if (auto room = check_room(path, parse_entry_plan(stored->plan_json).bytes); !room) {
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
  const bool was_there = std::exchange(person_there_, false);
  TurnEnd end;
  auto turn = co_await turn_of(entry);
  if (turn) {
    end = co_await host_.take_turn(std::move(*turn));
  } else {
    end.outcome = fail(turn.error());
  }
  if (!end.outcome) person_there_ = was_there;  // nothing moved
  // Somebody else was quicker, and it is the turn of this entry afterwards.
  if (!end.outcome && end.outcome.error().code == Errc::busy) {
    co_await wait_for_change(seen, kBetweenTries);
    co_return;
  }
  co_await store_end(entry, std::move(end));
}

// Until it is stored, the entry is at the head and nothing else begins.
Task<> QueueRunner::store_end(std::int64_t entry, TurnEnd end) {
  for (;;) {
    const QueueActor who = itself(clock_);
    const auto job = [entry, &end, &who](const Database& db) {
      return settle_turn(db, entry, end, who);
    };
    auto after = co_await store_.with(job);
    const std::uint64_t seen = wakes_;
    if (!after) {
      spdlog::error("how entry {} of the queue ended is not stored: {}", entry,
                    printable(after.error().what, kLongestReason));
      if (ending_) co_return;  // the next start finds out from the run
      co_await wait_for_change(seen, kBetweenTries);
      continue;
    }
    if (!*after) co_return;
    if ((*after)->hold) {
      person_there_ = false;
      spdlog::warn("the queue holds ({}): {}", to_string(*(*after)->hold),
                   printable((*after)->why, kLongestReason));
    } else if ((*after)->entry == EntryState::waiting) {
      co_await wait_for_change(seen, kBetweenTries);
    }
    co_return;
  }
}

Task<QueueActor> QueueRunner::actor(PeerCredentials peer) {
  QueueActor who;
  who.uid = peer.uid;
  who.user = co_await host_.name_of(peer);
  who.now_unix_ns = clock_.unix_ns();
  co_return who;
}

template <class Job>
Task<Result<>> QueueRunner::change(Job job, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  const auto guarded = [&job, &who](const Database& db) -> Result<> {
    if (auto free = not_locked(db, who); !free) return free;
    return job(db, who);
  };
  auto done = co_await store_.with(guarded);
  co_return done;
}

Task<Result<QueueAdded>> QueueRunner::add(QueueAdd wanted, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  if (wanted.run.operator_name.empty()) wanted.run.operator_name = who.user;
  auto plan = co_await host_.plan_entry(wanted.run);
  if (!plan) co_return fail(plan.error());
  QueueAdded out;
  out.plan = std::move(*plan);
  const std::vector<QueuedRun> runs(1, stored_form(wanted, out.plan));
  const auto job = [&](const Database& db) -> Result<std::vector<std::int64_t>> {
    if (auto free = not_locked(db, who); !free) return fail(free.error());
    auto waiting = sum_of_plans(db, -1);
    if (!waiting) return fail(waiting.error());
    if (auto room = check_room(store_.path(), waiting->bytes + out.plan.bytes); !room) {
      return fail(room.error());
    }
    return add_to_queue(db, runs, wanted.place, who);
  };
  auto entries = co_await store_.with(job);
  if (!entries) co_return fail(entries.error());
  out.entry = entries->front();
  co_await tell_change();
  co_return out;
}

Task<Result<>> QueueRunner::move(std::int64_t entry, QueuePlace place, PeerCredentials peer) {
  const auto job = [entry, place](const Database& db, const QueueActor& who) {
    return move_in_queue(db, entry, place, who);
  };
  auto done = co_await change(job, std::move(peer));
  co_await tell_change();
  co_return done;
}

Task<Result<>> QueueRunner::remove(std::int64_t entry, PeerCredentials peer) {
  const auto job = [entry](const Database& db, const QueueActor& who) {
    return remove_from_queue(db, entry, who);
  };
  auto done = co_await change(job, std::move(peer));
  co_await tell_change();
  co_return done;
}

Task<Result<std::int64_t>> QueueRunner::clear(PeerCredentials peer) {
  std::int64_t removed = 0;
  const auto job = [&removed](const Database& db, const QueueActor& who) -> Result<> {
    auto count = clear_queue(db, who);
    if (!count) return fail(count.error());
    removed = *count;
    return {};
  };
  auto done = co_await change(job, std::move(peer));
  co_await tell_change();
  if (!done) co_return fail(done.error());
  co_return removed;
}

Task<Result<>> QueueRunner::start(HeadChoice choice, PeerCredentials peer) {
  const auto job = [choice](const Database& db, const QueueActor& who) -> Result<> {
    auto look = look_at(db);
    if (!look) return fail(look.error());
    const bool looked = look->head && look->head->state == EntryState::failed &&
                        look->state.held_cause == to_string(HoldCause::look);
    const bool repeats = looked && choice == HeadChoice::none;
    return start_queue(db, repeats ? HeadChoice::repeat : choice, who);
  };
  auto started = co_await change(job, std::move(peer));
  if (!started) co_return started;
  person_there_ = true;
  host_.forget_identities();
  co_await tell_change();
  co_return started;
}

Task<Result<>> QueueRunner::hold(std::string why, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  const std::string words = why.empty() ? "by " + who.user : why + " (by " + who.user + ")";
  person_there_ = false;
  const auto job = [&words, &who](const Database& db) {
    return hold_queue(db, to_string(HoldCause::person), words, who);
  };
  auto held = co_await store_.with(job);
  co_await tell_change();
  co_return held;
}

Task<Result<>> QueueRunner::lock(std::string why, PeerCredentials peer) {
  const auto job = [&why](const Database& db, const QueueActor& who) {
    return lock_queue(db, why, who);
  };
  auto done = co_await change(job, std::move(peer));
  co_await tell_change();
  co_return done;
}

Task<Result<>> QueueRunner::unlock(bool force, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  const auto job = [force, &who](const Database& db) -> Result<> {
    if (!force) {
      if (auto free = not_locked(db, who); !free) return free;
    }
    return unlock_queue(db, who);
  };
  auto unlocked = co_await store_.with(job);
  co_await tell_change();
  co_return unlocked;
}

Task<Result<>> QueueRunner::answer(std::string text, std::optional<std::int64_t> entry,
                                   PeerCredentials peer) {
  if (!gate_) {
    co_return fail(Errc::invalid_request,
                   "the queue waits for no answer: it was given, or the queue is held");
  }
  if (entry && *entry != gate_->entry) {
    co_return fail(Errc::invalid_request, "entry {} is not at the gate: entry {} is; nothing moves",
                   *entry, gate_->entry);
  }
  if (auto right = check_answer(*gate_, text); !right) {
    spdlog::warn("a gate of the queue stays shut: {}", printable(right.error().what));
    co_return right;
  }
  // A second answer that comes meanwhile finds no gate.
  Gate gate = *std::exchange(gate_, std::nullopt);
  answering_ = true;
  auto stored = co_await store_answer(std::move(gate), std::move(peer));
  answering_ = false;
  co_await tell_change();
  co_return stored;
}

Task<Result<>> QueueRunner::store_answer(Gate gate, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  const auto job = [&gate, &who](const Database& db) -> Result<> {
    if (gate.kind == Gate::Kind::specimen) {
      return tell_specimen_on_rig(db, gate.expected, gate.entry, who);
    }
    return append_queue_act(db, "answer", gate.entry, gate.expected, who);
  };
  auto stored = co_await store_.with(job);
  if (stored) person_there_ = true;
  co_return stored;
}

}  // namespace lcrig
