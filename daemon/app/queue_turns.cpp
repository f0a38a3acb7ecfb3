// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/queue_turns.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "daemon/app/callers.hpp"
#include "daemon/app/news.hpp"
#include "daemon/app/run_starter.hpp"
#include "daemon/continuation.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/session.hpp"
#include "protocols/expand.hpp"
#include "protocols/plan/plan.hpp"
#include "protocols/run/run.hpp"
#include "storage/database.hpp"
#include "storage/run_summary.hpp"

namespace lcrig {

namespace {

// Leads in another position than in the last run change the stray capacitance by about this much. A
// specimen file contains neither strays nor fringe field, and its permittivity is from a data
// sheet.
constexpr double kOwnPart = 0.03, kOwnStray_F = 0.1e-12;
constexpr double kFilePart = 0.30, kFileStray_F = 1e-12;

ExpectedAtRest expected(double c0_F, double part, double stray_F, std::string source) {
  ExpectedAtRest out;
  out.capacitance_F = c0_F;
  out.tolerance_F = part * c0_F + stray_F;
  out.source = std::move(source);
  return out;
}

// The capacitance that a specimen should show at rest: from its last successful run at this
// frequency, else from its file. nullopt: neither gives it. Errors: an unreadable database.
Result<std::optional<ExpectedAtRest>> expected_at_rest(const Database& db, const PreparedRun& run) {
  const double frequency_Hz = run.protocol.sample.lcr.frequency.si();
  auto last = last_c0(db, run.request.specimen_name, frequency_Hz);
  if (!last) return fail(last.error());
  if (*last) {
    return std::optional(
        expected((*last)->c0_F, kOwnPart, kOwnStray_F, fmt::format("in run {}", (*last)->run)));
  }
  if (!run.specimen || run.specimen->c0_F() <= 0) return std::optional<ExpectedAtRest>();
  return std::optional(expected(run.specimen->c0_F(), kFilePart, kFileStray_F, "by its file"));
}

}  // namespace

QueueTurns::QueueTurns(asio::any_io_executor executor, Clock& clock, const Parts& parts)
    : executor_(std::move(executor)), clock_(clock), parts_(parts) {}

QueueTurns::~QueueTurns() = default;

// The queue never starts by itself after the daemon ended, whether by a crash or not.
Result<> QueueTurns::open() {
  auto db = open_read_write(parts_.database, parts_.vfs);
  if (!db) return fail(db.error());
  runner_ = std::make_unique<QueueRunner>(executor_, clock_, *this, parts_.database, parts_.vfs);
  auto was_going = runner_->open(*db);
  if (!was_going) return fail(was_going.error());
  if (*was_going) {
    spdlog::warn(
        "the queue was going when the last daemon ended: it is held; look at the rig, then "
        "lcrig queue list");
  }
  return {};
}

Task<> QueueTurns::run() {
  co_await runner_->run();
  parts_.use.tell();
}

bool QueueTurns::goes() const {
  return runner_ && runner_->goes();
}

bool QueueTurns::over() const {
  return !runner_ || runner_->over();
}

void QueueTurns::wake() {
  if (goes()) runner_->wake();
}

void QueueTurns::note(const RunEvent& event) {
  hazards_.take(hazard_of(event.kind));
}

Task<std::string> QueueTurns::name_of(const PeerCredentials& peer) {
  return parts_.callers.name_of(peer);
}

void QueueTurns::queue_changed(const QueueStatus& status) {
  parts_.news.queue_changed(status);
}

Task<Result<>> QueueTurns::claim_for_person(RigUse::State state, std::string if_it_goes) {
  if (goes()) co_return fail(Errc::busy, "{}", if_it_goes);
  auto claimed = co_await parts_.use.claim(state);
  if (!claimed || !goes()) co_return claimed;
  parts_.use.give_back();  // the queue was started while the claim waited
  co_return fail(Errc::busy, "{}", if_it_goes);
}

// Does not ask the instruments during a run: the plan then uses the rig as last seen.
Task<Result<Plan>> QueueTurns::plan_on_rig(const RunRequest& run, const PreparedRun& prepared,
                                           PlanOn on) {
  const auto& seen = parts_.plans.last_rig(prepared.places_weights);
  if (seen && (!parts_.use.is_idle() || on == PlanOn::as_seen)) {
    Rig rig = *seen;
    const auto job = [&rig, &prepared] {
      add_specimen(rig, prepared);
      return make_plan(prepared.protocol, prepared.environment, rig);
    };
    co_return co_await run_aside(executor_, clock_, job);
  }
  RunRequest copy = run;
  co_return co_await parts_.starter.plan(std::move(copy));
}

Task<Result<EntryPlan>> QueueTurns::plan_entry(RunRequest& run, PlanOn on) {
  const auto read = [this, &run]() -> Result<PreparedRun> {
    if (auto found = parts_.starter.find_texts(run); !found) return fail(found.error());
    RunRequest copy = run;
    return prepare_run(std::move(copy));
  };
  auto prepared = co_await run_aside(executor_, clock_, read);
  if (!prepared) co_return fail(prepared.error());
  run.protocol_name = prepared->protocol.name;  // clients send the file's name instead
  if (auto known = parts_.plans.find(run)) co_return *known;
  const bool moves = commands_frame(prepared->protocol);
  EntryPlan out;
  out.moves = moves;
  if (on == PlanOn::nothing) co_return out;
  auto plan = co_await plan_on_rig(run, *prepared, on);
  if (!plan && !is_no_refusal(plan.error().code)) co_return fail(plan.error());
  if (!plan) {
    out.why_not = plan.error().what;
    co_return out;
  }
  out = entry_plan(*plan, moves);
  parts_.plans.keep(run, out);
  co_return out;
}

Task<Result<PreparedRun>> QueueTurns::prepare(TurnOfQueue turn) {
  const auto read = [this, &turn]() -> Result<PreparedRun> {
    auto db = open_read_only(parts_.database);
    if (!db) return fail(db.error());
    // no comparison: the specimen of an interrupted run may be loaded
    if (turn.resumes_run) return prepare_continuation(*db, *turn.resumes_run);
    auto prepared = prepare_run(std::move(turn.run));
    if (!prepared || !turn.compares) return prepared;
    auto known = keep(expected_at_rest(*db, *prepared), prepared->at_rest);
    if (!known) return fail(known.error());
    return prepared;
  };
  auto prepared = co_await run_aside(executor_, clock_, read);
  if (!prepared) co_return prepared;
  prepared->queue_entry = turn.entry;
  if (turn.resumes_run) prepared->request.operator_name = turn.run.operator_name;
  co_return prepared;
}

Task<TurnEnd> QueueTurns::take_turn(TurnOfQueue turn) {
  TurnEnd end;
  auto claimed = co_await parts_.use.claim(RigUse::State::starting);
  if (!claimed) {
    end.outcome = fail(claimed.error());
    co_return end;
  }
  hazards_ = HazardWatch();
  parts_.starter.forget_stranger();
  auto prepared = co_await prepare(std::move(turn));
  auto started = co_await parts_.starter.start(std::move(prepared));
  if (started) {
    const auto& last = parts_.use.last_run();
    const auto over = [&last, run = started->run] { return last && last->run == run; };
    co_await parts_.use.wait(over);
    end.outcome = *last;
    if (last->code) hazards_.take(hazard_of(*last->code));
    if (!last->stands) hazards_.take(Hazard::not_standing);  // no gate opens while it may move
  } else {
    end.outcome = fail(started.error());
    hazards_.take(hazard_of(started.error().code));
  }
  end.hazard = hazards_.worst();
  end.stranger = parts_.starter.stranger();
  co_return end;
}

Result<> QueueTurns::may_begin(const Session& session) {
  if (!session.is_turn_of_queue()) return {};
  auto same = identities_.compare(session.meter_identity(), session.frame_identity(),
                                  session.places_weights());
  if (!same) hazards_.take(Hazard::other_instrument);
  return same;
}

double QueueTurns::left_s() const {
  const Run* run = parts_.use.live_run();
  return run != nullptr ? run->progress().left_s : 0;
}

void QueueTurns::forget_identities() {
  identities_ = KnownIdentities();
  parts_.plans.forget();
}

}  // namespace lcrig
