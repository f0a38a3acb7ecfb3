// SPDX-License-Identifier: Apache-2.0
#include "daemon/app/answer_taker.hpp"

#include <utility>

namespace lcrig {

Task<Result<>> AnswerTaker::confirm(PeerCredentials peer) {
  const Run* run = use_.live_run();
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
  peer.user = co_await callers_.name_of(peer);
  const bool confirmed = person_.confirmed();
  QueueRunner* const queue = queue_.runner();
  if (!confirmed && queue != nullptr && queue->awaits_consent()) {
    co_return co_await queue->answer("yes", std::nullopt, std::move(peer));
  }
  if (!confirmed) co_return fail(Errc::invalid_request, "nothing waits for confirmation");
  callers_.note("run.confirm", peer);
  co_return Result<>();
}

// An answer that a client is told to be taken is in the database.
Task<Result<Answered>> AnswerTaker::answer(AnswerRequest request, PeerCredentials peer) {
  peer.user = co_await callers_.name_of(peer);
  auto live = use_.running();
  if (!live) co_return fail(live.error());
  Run& run = **live;
  const std::int64_t number = run.progress().run;
  if (!run.question() && !person_.prompt().empty()) {
    co_return fail(Errc::invalid_request,
                   "run {} waits for a confirmation, not for an answer: `lcrig confirm`", number);
  }
  if (!run.question() && run.progress().state == RunState::paused) {
    co_return fail(
        Errc::invalid_request,
        "run {} is paused and waits for no answer: `lcrig resume`; what it asked it asks "
        "again then",
        number);
  }
  auto answered = run.answer(request.value, peer.user, request.question);
  if (!answered) co_return fail(answered.error());
  answered->run = number;
  callers_.note("run.answer", peer);
  auto stored = co_await recorder_->flush();
  if (!stored) co_return fail(stored.error());
  co_return answered;
}

}  // namespace lcrig
