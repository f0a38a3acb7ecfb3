// SPDX-License-Identifier: Apache-2.0
// Requests of people about a run: a confirmation or an answer that it waits for, and tags.
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "base/aside.hpp"
#include "daemon/app.hpp"
#include "daemon/control/audit.hpp"
#include "storage/database.hpp"
#include "storage/tags.hpp"

namespace lcrig {

Task<Result<>> App::confirm(PeerCredentials peer) {
  Run* run = live_run();
  if (run != nullptr && run->question()) {
    const Question& question = run->question()->question;
    if (question.type != AnswerType::confirmation) {
      co_return fail(Errc::invalid_request, "step {} asks for {}: `lcrig answer VALUE`",
                     question.step_id, expected_words(question));
    }
    auto answered = co_await answer(AnswerRequest(), std::move(peer));
    if (!answered) co_return fail(answered.error());
    co_return Result<>();
  }
  peer.user = co_await user_name(peer, kNamePatience);
  const bool confirmed = person_.confirmed();
  if (!confirmed && queue_ && queue_->awaits_consent()) {
    co_return co_await queue_->answer("yes", std::nullopt, std::move(peer));
  }
  if (!confirmed) co_return fail(Errc::invalid_request, "nothing waits for confirmation");
  recorder_->event(request_event(clock_.now(), "run.confirm", peer));
  co_return Result<>();
}

// An answer that a client is told to be taken is in the database.
Task<Result<Answered>> App::answer(AnswerRequest request, PeerCredentials peer) {
  peer.user = co_await user_name(peer, kNamePatience);
  Run* run = live_run();
  if (run == nullptr) co_return fail(Errc::invalid_request, "no run is going on");
  if (!run->question() && !person_.prompt().empty()) {
    co_return fail(Errc::invalid_request,
                   "run {} waits for a confirmation, not for an answer: `lcrig confirm`",
                   run->progress().run);
  }
  if (!run->question() && run->progress().state == RunState::paused) {
    co_return fail(
        Errc::invalid_request,
        "run {} is paused and waits for no answer: `lcrig resume`; what it asked it asks "
        "again then",
        run->progress().run);
  }
  const std::int64_t number = run->progress().run;
  auto answered = run->answer(request.value, peer.user, request.question);
  if (!answered) co_return fail(answered.error());
  answered->run = number;
  recorder_->event(request_event(clock_.now(), "run.answer", peer));
  auto stored = co_await recorder_->flush();
  if (!stored) co_return fail(stored.error());
  co_return answered;
}

// Not on the thread of the instruments: another program may hold the database for seconds.
Task<Result<std::vector<std::string>>> App::tag_run(TagRequest request, PeerCredentials peer) {
  if (storing_) co_return fail(Errc::busy, "another note or specimen is being stored: try again");
  storing_ = true;
  peer.user = co_await user_name(peer, kNamePatience);
  TagChange change;
  change.run = request.run;
  change.tags = std::move(request.tags);
  change.remove = request.remove;
  const std::int64_t now = clock_.unix_ns();
  const auto store = [this, &change, &peer, now]() -> Result<std::vector<std::string>> {
    auto db = open_read_write(config_.database);
    if (!db) return fail(db.error());
    return change_tags(*db, change, peer.user, now);
  };
  auto tags = co_await run_aside(io_.get_executor(), clock_, store);
  storing_ = false;
  if (tags) {
    spdlog::info("run {}: {} {} for {}", change.run, fmt::join(change.tags, ", "),
                 change.remove ? "was taken off" : "was put on it", peer_words(peer));
  }
  co_return tags;
}

}  // namespace lcrig
