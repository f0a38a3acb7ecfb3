// SPDX-License-Identifier: Apache-2.0
#include "daemon/rehearse_batch.hpp"

#include <utility>

#include "daemon/rehearsal.hpp"
#include "daemon/rig/sim.hpp"
#include "protocols/plan/planned_rig.hpp"
#include "storage/batches.hpp"
#include "storage/database.hpp"
#include "storage/run_summary.hpp"
#include "storage/runs.hpp"

namespace lcrig {

namespace {

using namespace std::chrono_literals;

constexpr const char* kRehearser = "rehearsal";

class BatchRehearsal final : public Rehearsal {
 public:
  explicit BatchRehearsal(const RehearseBatchRequest& request)
      : Rehearsal(request.progress, VirtualClock(request.begin_unix_ns)), request_(request) {
    person_.user = kRehearser;
    out_.db_path = request.db_path;
  }

  Result<RehearseBatchResult> run() {
    const MonoTime begin = wall_.now();
    if (auto made = make_app(); !made) return fail(made.error());
    if (auto played = play(); !played) return fail(played.error());
    if (failure_) return fail(*failure_);
    if (auto summed = sum_up(); !summed) return fail(summed.error());
    out_.wall_s = to_seconds(wall_.now() - begin);
    return std::move(out_);
  }

 private:
  Result<> make_app() {
    // A mistake in the bench file leaves no database behind.
    if (const auto bench = bench_of(request_); !bench) return fail(bench.error());
    Config config;
    config.database = request_.db_path;
    AppParts parts;
    parts.rig = std::make_unique<RehearsalRig>(
        [this](const InstrumentsRequest& wanted) { return make_instruments(wanted); });
    parts.sync_each_commit = false;
    parts.true_clock = &wall_;
    app_ = std::make_unique<App>(io_, clock_, std::move(config), std::move(parts));
    if (auto opened = app_->open_with_queue(); !opened) return opened;
    return empty_queue();
  }

  // Makes the bench with the specimen of the run, and with other noise for each run.
  Result<std::unique_ptr<Instruments>> make_instruments(const InstrumentsRequest& wanted) {
    auto sim = sim_request(request_, wanted);
    if (!sim) return fail(sim.error());
    sim->bench.operator_reaction = from_seconds(PlannedRig::kByHand_s);  // as plans assume
    if (wanted.why == LearnedBy::start) sim->seed += starts_++;
    return make_sim_instruments(io_.get_executor(), clock_, *sim);
  }

  // Removes entries of an earlier rehearsal that was broken off. Errors when there are any others,
  // because they belong to people.
  Result<> empty_queue() {
    auto db = open_read_write(request_.db_path);
    if (!db) return fail(db.error());
    auto entries = list_queue(*db, 0, -1);
    if (!entries) return fail(entries.error());
    for (const QueueListing& entry : *entries) {
      if (entry.added_by == kRehearser) continue;
      return fail(Errc::invalid_request,
                  "{}: {} entries wait in its queue, of {}: a rehearsal would run them; give "
                  "another --db",
                  request_.db_path, entries->size(), entry.added_by);
    }
    QueueActor who = QueueActor::itself(clock_.unix_ns());
    who.user = kRehearser;
    auto cleared = clear_queue(*db, who);
    if (!cleared) return fail(cleared.error());
    return free_name(*db);
  }

  // Finds a free name, because the same day may be rehearsed again and again.
  Result<> free_name(const Database& db) {
    out_.name = request_.batch.name;
    for (int again = 2;; ++again) {
      auto known = find_batch(db, out_.name);
      if (!known) return fail(known.error());
      if (!*known) return {};
      out_.name = fmt::format("{}-{}", request_.batch.name, again);
    }
  }

  Task<> act() override {
    BatchAdd batch = request_.batch;
    batch.name = out_.name;
    QueueHandler& queue = *app_->queue();
    auto added = co_await queue.add_batch(std::move(batch), person_);
    if (added) {
      co_await tend(queue, added->entries);
    } else {
      failure_ = added.error();
    }
  }

  Task<> tend(QueueHandler& queue, std::int64_t entries) {
    begin_ = clock_.now();
    std::int64_t starts_left = 2 * entries + 10;  // ends the rehearsal of a queue that makes no
                                                  // progress
    auto started = co_await queue.start(HeadChoice::none, person_);
    if (!started) failure_ = started.error();
    while (!failure_) {
      const QueueStatus status = app_->status().queue.value_or(QueueStatus());
      if (!status.going && status.cause == HoldCause::empty) break;
      if (!status.going) {
        if (--starts_left == 0) break;
        co_await go_on(queue, status);
      } else if (status.gate && status.gate != QueueGate::time && status.entry) {
        co_await open_gate(queue, status);
      } else {
        co_await clock_.wait_for(1s);  // a person's look: acts at other times give other rows
      }
    }
    out_.length_s = to_seconds(clock_.now() - begin_);
    auto cleared = co_await queue.clear(person_);
    if (!cleared) failure_ = cleared.error();
  }

  Task<> use_hands(const QueueStatus& status, std::string prompt) {
    HandTime hand;
    hand.at_s = to_seconds(clock_.now() - begin_);
    hand.entry = status.entry.value_or(0);
    hand.gate = status.gate;
    hand.prompt = std::move(prompt);
    out_.hands.push_back(std::move(hand));
    const Duration takes = from_seconds(request_.hand_s);
    co_await clock_.wait_for(takes);
  }

  // Types what the gate expects.
  Task<> open_gate(QueueHandler& queue, const QueueStatus& status) {
    co_await use_hands(status, status.prompt);
    auto entry = co_await queue.show(*status.entry);
    if (!entry) {
      failure_ = entry.error();
      co_return;
    }
    const auto terms = parse_terms(entry->listing.terms_json);
    std::string word = entry->listing.specimen_name;
    if (status.gate == QueueGate::person) word = "yes";
    if (terms && status.gate == QueueGate::probe) word = terms->probe;
    if (terms && status.gate == QueueGate::fixture) word = terms->fixture;
    auto answered = co_await queue.answer(std::move(word), status.entry, person_);
    if (!answered) failure_ = answered.error();
  }

  // Goes on after a failure: skips the entry, or repeats it if its terms ask for that after a look.
  Task<> go_on(QueueHandler& queue, const QueueStatus& status) {
    co_await use_hands(status, status.why);
    HeadChoice choice = HeadChoice::none;
    std::string about;
    if (status.entry) {
      auto entry = co_await queue.show(*status.entry);
      if (entry) {
        const bool waits = entry->listing.state == EntryState::waiting;
        if (!waits && status.cause != HoldCause::look) choice = HeadChoice::skip;
        about = fmt::format("entry {} ({} on {}): ", entry->listing.entry,
                            entry->listing.protocol_name, entry->listing.specimen_name);
      }
    }
    out_.troubles.push_back(fmt::format("{}the queue held ({}): {}", about,
                                        status.cause ? to_string(*status.cause) : "", status.why));
    auto started = co_await queue.start(choice, person_);
    if (!started && status.count > 0) failure_ = started.error();
  }

  // Reads the result from the stored rows.
  Result<> sum_up() {
    auto db = open_read_only(request_.db_path);
    if (!db) return fail(db.error());
    auto batch = find_batch(*db, out_.name);
    if (!batch) return fail(batch.error());
    if (!*batch) return fail(Errc::bug, "the batch was not stored");
    auto entries = batch_entries(*db, (*batch)->batch);
    if (!entries) return fail(entries.error());
    for (const BatchListing& listing : *entries) {
      if (auto good = add_entry(*db, listing); !good) return good;
    }
    out_.hands_s = static_cast<double>(out_.hands.size()) * request_.hand_s;
    return {};
  }

  Result<> add_entry(const Database& db, const BatchListing& listing) {
    RehearsedEntry out;
    static_cast<BatchListing&>(out) = listing;
    for (const std::int64_t run : listing.runs) {
      auto summary = summarise_run(db, run);
      if (!summary) return fail(summary.error());
      auto stored = get_run_listing(db, run);
      if (!stored) return fail(stored.error());
      out.run = run;
      out.exit_status = stored->exit_status;
      out.reason = stored->reason;
      out.measure_readings += summary->measure_readings;
      out.duration_s += summary->duration_s.value_or(0);
      auto acts = db.integer("SELECT count(*) FROM event WHERE run_id = ? AND kind IN (?, ?)", run,
                             EventKind::confirm, EventKind::answer);
      if (!acts) return fail(acts.error());
      out.acts += *acts;
    }
    out_.machine_s += out.duration_s;
    out_.measure_readings += out.measure_readings;
    out_.entries.push_back(std::move(out));
    return {};
  }

  const RehearseBatchRequest& request_;
  std::int64_t starts_ = 0;
  PeerCredentials person_;
  RehearseBatchResult out_;
  std::optional<Error> failure_;
  MonoTime begin_{};
};

}  // namespace

Result<RehearseBatchResult> rehearse_batch(const RehearseBatchRequest& request) {
  BatchRehearsal rehearsal(request);
  return rehearsal.run();
}

}  // namespace lcrig
