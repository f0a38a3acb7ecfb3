// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/sim_respondent.hpp"

#include "base/clock.hpp"

namespace lcrig {

namespace {

AnswerValue made_up(const Question& question) {
  switch (question.type) {
    case AnswerType::confirmation: return true;
    case AnswerType::choice: return question.choices.front();
    case AnswerType::number: return 0.5 * (question.min + question.max);
    case AnswerType::line: break;
  }
  return std::string("rehearsed");
}

}  // namespace

Result<GivenAnswer> SimRespondent::choose(const Question& question) const {
  GivenAnswer out;
  const auto given = answers_.find(question.step_id);
  if (given != answers_.end()) {
    auto fits = keep(read_answer(question, given->second), out.value);
    if (!fits) return fail(fits.error());
    out.source = AnswerSource::file;
  } else if (question.fallback) {
    out.value = *question.fallback;
    out.source = AnswerSource::fallback;
  } else {
    out.value = made_up(question);
    out.source = AnswerSource::made_up;
  }
  return out;
}

Task<Result<GivenAnswer>> SimRespondent::answer(Question question) {
  bool came = co_await clock_.wait_for(delay_);
  // Looks once a second, like SimOperator: a script sends the person away and back.
  while (came && is_absent_()) came = co_await clock_.wait_for(std::chrono::seconds(1));
  if (!came) co_return fail(Errc::aborted, "the question was withdrawn: {}", question.text);
  co_return choose(question);
}

}  // namespace lcrig
