// SPDX-License-Identifier: Apache-2.0
// Requests of clients to the queue, and their answers at a gate.
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.hpp"
#include "daemon/control/queue_messages.hpp"
#include "daemon/queue/pages.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/queue/runner_batch.hpp"

namespace lcrig {

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

Result<> QueueRunner::may_add(const Database& db, const QueueActor& who, std::int64_t bytes) const {
  if (auto free = not_locked(db, who); !free) return free;
  auto waiting = planned_bytes(db);
  return waiting ? store_.check_room(*waiting + bytes) : fail(waiting.error());
}

QueuedRun stored_form(const RunRequest& run, const QueueTerms& terms, const EntryPlan& plan) {
  QueuedRun out;
  out.protocol_name = run.protocol_name;
  out.protocol_text = run.protocol_text;
  out.parameters_json = to_json(run)["parameters"].dump();
  out.specimen_name = run.specimen_name;
  out.specimen_text = run.specimen_text;
  out.operator_name = run.operator_name;
  out.note = run.note;
  out.terms_json = to_json(terms).dump();
  out.plan_json = to_json(plan).dump();
  return out;
}

Task<> QueueRunner::tell_change() {
  auto next = co_await look();
  static_cast<void>(next);  // only updates the status; `run` acts
  wake();
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
  if (auto can = check_begin(wanted.terms, clock_.unix_ns() / kSecond_ns); !can) {
    co_return fail(can.error());
  }
  if (wanted.run.operator_name.empty()) wanted.run.operator_name = who.user;
  auto plan = co_await host_.plan_entry(wanted.run, PlanOn::rig);
  if (!plan) co_return fail(plan.error());
  QueueAdded out;
  out.plan = std::move(*plan);
  const std::vector<QueuedRun> runs(1, stored_form(wanted.run, wanted.terms, out.plan));
  const auto job = [&](const Database& db) -> Result<std::vector<std::int64_t>> {
    if (auto may = may_add(db, who, out.plan.bytes); !may) return fail(may.error());
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
    return keep(clear_queue(db, who), removed);
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
                        look->state.held == HoldCause::look;
    const bool repeats = looked && choice == HeadChoice::none;
    return start_queue(db, repeats ? HeadChoice::repeat : choice, who);
  };
  auto started = co_await change(job, std::move(peer));
  if (!started) co_return started;
  person_seen_ = clock_.now();
  stranger_.reset();
  host_.forget_identities();
  co_await tell_change();
  co_return started;
}

Task<Result<>> QueueRunner::hold(std::string why, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  const std::string words = why.empty() ? "by " + who.user : why + " (by " + who.user + ")";
  person_seen_.reset();
  const auto job = [&words, &who](const Database& db) {
    return hold_queue(db, HoldCause::person, words, who);
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
  // An answer that comes meanwhile finds no gate.
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
    if (gate.kind == QueueGate::specimen) {
      return tell_specimen_on_rig(db, gate.expected, gate.entry, who);
    }
    return append_queue_act(db, "answer", gate.entry, gate.expected, who);
  };
  auto stored = co_await store_.with(job);
  if (!stored) co_return stored;
  person_seen_ = clock_.now();
  if (gate.kind == QueueGate::probe) probe_ = gate.expected;
  if (gate.kind == QueueGate::fixture) fixture_ = gate.expected;
  if (gate.kind == QueueGate::specimen) stranger_.reset();  // another specimen is on the rig now
  if (gate.kind == QueueGate::stranger) {
    stranger_.reset();
    vouched_ = gate.entry;
  }
  co_return stored;
}

Task<Result<QueuePage>> QueueRunner::list(std::int64_t skip, std::int64_t most) {
  const std::int64_t now = clock_.unix_ns();
  const double left_s = host_.left_s();
  const auto job = [=](const Database& db) { return read_queue_page(db, now, left_s, skip, most); };
  co_return co_await store_.with(job);
}

Task<Result<ListedEntry>> QueueRunner::show(std::int64_t entry) {
  const std::int64_t now = clock_.unix_ns();
  const double left_s = host_.left_s();
  const auto job = [=](const Database& db) { return read_listed_entry(db, now, left_s, entry); };
  co_return co_await store_.with(job);
}

Task<Result<std::vector<QueueAct>>> QueueRunner::history(std::optional<std::int64_t> entry,
                                                         std::int64_t before, std::int64_t most) {
  const auto job = [=](const Database& db) { return queue_history(db, entry, before, most); };
  co_return co_await store_.with(job);
}

}  // namespace lcrig
