// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/run_requests.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "base/text.hpp"
#include "daemon/app/callers.hpp"
#include "daemon/app/database_writes.hpp"
#include "daemon/app/queue_turns.hpp"
#include "daemon/app/rig_use.hpp"
#include "daemon/app/run_starter.hpp"
#include "daemon/continuation.hpp"
#include "daemon/control/audit.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/run_words.hpp"
#include "daemon/session.hpp"
#include "protocols/plan/plan.hpp"
#include "protocols/run/run.hpp"
#include "storage/database.hpp"

namespace lcrig {

namespace {

constexpr const char* kQueueGoes =
    "the queue goes, and runs what is next in it: `lcrig run --next` puts a run at its front, "
    "`lcrig queue hold` holds it";

}  // namespace

// Writes one line to the journal: who asked for what, and why it was refused.
Task<> RunRequests::tell_refusal(std::string wanted, PeerCredentials peer, Error error) {
  peer.user = co_await parts_.callers.name_for_stop(peer);
  spdlog::warn("no run begins: {} asked for {}: {}", peer_words(peer), printable(wanted),
               printable(error.what, kLongestReason));
}

Task<Result<RunStarted>> RunRequests::start_run(RunRequest request, PeerCredentials peer) {
  auto wanted = fmt::format("{} on {}", request.protocol_name, request.specimen_name);
  auto started = co_await begin(std::move(request), peer);
  if (!started) co_await tell_refusal(std::move(wanted), std::move(peer), started.error());
  co_return started;
}

Task<Result<RunStarted>> RunRequests::begin(RunRequest request, PeerCredentials& peer) {
  auto claimed = co_await parts_.queue.claim_for_person(RigUse::State::starting, kQueueGoes);
  if (!claimed) co_return fail(claimed.error());
  peer.user = co_await parts_.callers.name_of(peer);
  if (request.operator_name.empty()) request.operator_name = peer.user;
  auto prepared = co_await parts_.starter.read(std::move(request));
  auto started = co_await parts_.starter.start(std::move(prepared));
  if (started) parts_.callers.note("run.start", peer);
  co_return started;
}

Task<Result<RunStarted>> RunRequests::resume(std::optional<std::int64_t> run, bool confirmed,
                                             PeerCredentials peer) {
  if (parts_.use.live_run() == nullptr && run) {
    co_return co_await continue_run(*run, confirmed, std::move(peer));
  }
  peer.user = co_await parts_.callers.name_of(peer);
  Run* live = parts_.use.live_run();
  if (live == nullptr || (run && *run != live->progress().run)) {
    co_return fail(Errc::invalid_request, "no such run is paused");
  }
  if (!live->resume()) {
    co_return fail(Errc::invalid_request, "run {} is not paused", live->progress().run);
  }
  parts_.callers.note("run.resume", peer);
  RunStarted going;
  going.run = live->progress().run;
  co_return going;
}

Task<Result<RunStarted>> RunRequests::continue_run(std::int64_t run, bool confirmed,
                                                   PeerCredentials peer) {
  auto started = co_await begin_continuation(run, confirmed, peer);
  auto wanted = fmt::format("the continuation of run {}", run);
  if (!started) co_await tell_refusal(std::move(wanted), std::move(peer), started.error());
  co_return started;
}

Task<Result<RunStarted>> RunRequests::begin_continuation(std::int64_t run, bool confirmed,
                                                         PeerCredentials& peer) {
  auto claimed = co_await parts_.queue.claim_for_person(RigUse::State::starting, kQueueGoes);
  if (!claimed) co_return fail(claimed.error());
  peer.user = co_await parts_.callers.name_of(peer);
  const auto read = [this, run, confirmed, &peer]() -> Result<PreparedRun> {
    auto db = open_read_write(parts_.database);
    if (!db) return fail(db.error());
    auto prepared = prepare_continuation(*db, run);
    if (!prepared) return prepared;
    prepared->continues->confirmed = confirmed;
    prepared->request.operator_name = peer.user;
    return prepared;
  };
  auto prepared = co_await run_aside(executor_, clock_, read);
  auto started = co_await parts_.starter.start(std::move(prepared));
  if (!started) co_return started;
  parts_.callers.note("run.resume", peer);
  std::vector<std::int64_t> before;
  before.push_back(run);
  auto text = fmt::format("continued by run {}", started->run);
  co_await parts_.writes.note(std::move(before), std::move(text));
  co_return started;
}

Task<Result<Plan>> RunRequests::plan_run(RunRequest request, PeerCredentials /*peer*/) {
  return parts_.starter.plan(std::move(request));
}

Task<Result<>> RunRequests::ask_instruments(PeerCredentials /*peer*/) {
  auto claimed = co_await parts_.use.claim(RigUse::State::asking);
  if (!claimed) co_return claimed;
  co_await parts_.rig.ask();
  parts_.use.give_back();
  co_return Result<>();
}

}  // namespace lcrig
