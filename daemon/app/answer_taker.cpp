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
  const std::string asked = person_.prompt();
  QueueRunner* const queue = queue_.runner();
  const bool at_gate = queue != nullptr && queue->awaits_consent();
  const auto entry = at_gate ? queue->status().entry : std::nullopt;
  peer.user = co_await callers_.name_of(peer);
  const bool confirmed = person_.prompt() == asked && person_.confirmed();
  if (!confirmed && at_gate) {
    co_return co_await queue->answer("yes", entry, std::move(peer));
  }
  if (!confirmed) co_return fail(Errc::invalid_request, "nothing waits for confirmation");
  callers_.note("run.confirm", peer);
  co_return Result<>();
}

// An answer that a client is told to be taken is in the database. It is for the question that was
// asked when it came: another one may be asked once the name of the peer is known.
Task<Result<Answered>> AnswerTaker::answer(AnswerRequest request, PeerCredentials peer) {
  const Run* asking = use_.live_run();
  if (!request.question && asking != nullptr && asking->question()) {
    request.question = asking->question()->number;
  }
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
