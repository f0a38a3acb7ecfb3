// SPDX-License-Identifier: Apache-2.0
// The part of App that serves the queue.
#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "daemon/app.hpp"
#include "daemon/continuation.hpp"
#include "daemon/queue/at_rest.hpp"
#include "protocols/expand.hpp"
#include "storage/database.hpp"

namespace lcrig {

using namespace std::chrono_literals;

// Nothing starts by itself after a crash, or after any other end of the daemon.
Result<> App::open_queue() {
  auto db = open_read_write(config_.database, vfs_);
  if (!db) return fail(db.error());
  queue_ = std::make_unique<QueueRunner>(io_.get_executor(), clock_, *this, config_.database, vfs_);
  auto was_going = queue_->open(*db);
  if (!was_going) return fail(was_going.error());
  if (*was_going) {
    spdlog::warn(
        "the queue was going when the last daemon ended: it is held; look at the rig, then "
        "lcrig queue list");
  }
  return {};
}

Task<> App::run_queue() {
  co_await queue_->run();
  changed_.notify_all();
}

Result<> App::leaves_to_queue() const {
  if (!queue_ || !queue_->goes()) return {};
  return fail(Errc::busy,
              "the queue goes, and runs what is next in it: `lcrig run --next` puts a run at its "
              "front, `lcrig queue hold` holds it");
}

// While a run goes on nothing is asked of the instruments: the rig is as it was seen last.
Task<Result<Plan>> App::plan_on_rig(const RunRequest& run, const PreparedRun& prepared, PlanOn on) {
  const auto& seen = plans_.last_rig(prepared.places_weights);
  if (seen && (use_ != Use::idle || on == PlanOn::as_seen)) {
    Rig rig = *seen;
    const auto job = [&rig, &prepared] {
      lcrig::add_specimen(rig, prepared);
      return make_plan(prepared.protocol, prepared.environment, rig);
    };
    co_return co_await run_aside(io_.get_executor(), clock_, job);
  }
  RunRequest copy = run;
  PeerCredentials nobody;
  co_return co_await plan_run(std::move(copy), std::move(nobody));
}

Task<Result<EntryPlan>> App::plan_entry(RunRequest& run, PlanOn on) {
  const auto read = [this, &run]() -> Result<PreparedRun> {
    if (auto found = find_texts(run); !found) return fail(found.error());
    RunRequest copy = run;
    return prepare_run(std::move(copy));
  };
  auto prepared = co_await run_aside(io_.get_executor(), clock_, read);
  if (!prepared) co_return fail(prepared.error());
  run.protocol_name = prepared->protocol.name;  // clients send the name of its file
  if (auto known = plans_.find(run)) co_return *known;
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
  plans_.keep(run, out);
  co_return out;
}

Task<Result<PreparedRun>> App::prepare_turn(TurnOfQueue turn) {
  const auto read = [this, &turn]() -> Result<PreparedRun> {
    auto db = open_read_only(config_.database);
    if (!db) return fail(db.error());
    // The specimen of an interrupted run may still be pressed.
    if (turn.resumes_run) return prepare_continuation(*db, *turn.resumes_run);
    auto prepared = prepare_run(std::move(turn.run));
    if (!prepared || !turn.compares) return prepared;
    auto at_rest = expected_at_rest(*db, *prepared);
    if (!at_rest) return fail(at_rest.error());
    prepared->at_rest = std::move(*at_rest);
    return prepared;
  };
  auto prepared = co_await run_aside(io_.get_executor(), clock_, read);
  if (!prepared) co_return prepared;
  prepared->queue_entry = turn.entry;
  if (turn.resumes_run) prepared->request.operator_name = turn.run.operator_name;
  co_return prepared;
}

Task<TurnEnd> App::take_turn(TurnOfQueue turn) {
  TurnEnd end;
  auto claimed = co_await claim(Use::starting);
  if (!claimed) {
    end.outcome = fail(claimed.error());
    co_return end;
  }
  hazards_ = HazardWatch();
  stranger_.reset();
  auto prepared = co_await prepare_turn(std::move(turn));
  auto started = co_await start_claimed(std::move(prepared));
  if (started) {
    const auto over = [this, run = started->run] { return last_run_ && last_run_->run == run; };
    co_await changed_.wait(over);
    end.outcome = *last_run_;
    if (last_run_->code) hazards_.take(hazard_of(*last_run_->code));
  } else {
    end.outcome = fail(started.error());
    hazards_.take(hazard_of(started.error().code));
  }
  end.hazard = hazards_.worst();
  end.stranger = stranger_;
  co_return end;
}

// Asked before anything is commanded, and again before the run row is written.
Result<> App::may_begin() {
  if (auto going = not_stopped(); !going) return going;
  if (!session_->is_turn_of_queue()) return {};
  auto same = identities_.compare(session_->meter_identity(), session_->frame_identity(),
                                  session_->places_weights());
  if (!same) hazards_.take(Hazard::other_instrument);
  return same;
}

double App::left_s() const {
  return live_run() != nullptr ? live_run()->progress().left_s : 0;
}

void App::forget_identities() {
  identities_.forget();
  plans_.forget();
}

Task<std::string> App::name_of(const PeerCredentials& peer) {
  co_return co_await user_name(peer, 2s);
}

void App::queue_changed(const QueueStatus& status) {
  if (control_) control_->publish_queue(status);
  if (live_run() != nullptr) return;
  notifier_.status(status.prompt.empty() ? "idle" : "the queue waits: " + status.prompt);
}

}  // namespace lcrig
