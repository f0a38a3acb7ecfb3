// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/questions.hpp"

#include <utility>

#include "base/as_result.hpp"
#include "base/clock.hpp"

namespace lcrig {

Questions::Wait::Wait(Questions& questions, Question question, std::int64_t repeat, MonoTime until)
    : questions_(questions) {
  while (questions.answers_.try_receive([](auto&&...) {})) {
  }
  questions.repeat_ = repeat;
  questions.open_ = {.question = std::move(question), .number = ++questions.asked_, .until = until};
}

Result<Answered> Questions::answer(const AnswerValue& given, std::string by,
                                   std::optional<std::int64_t> number) {
  if (!open_) {
    return fail(Errc::invalid_request, "no question waits for an answer{}",
                last_.empty() ? "" : ": " + last_);
  }
  if (number && *number != open_->number) {
    return fail(Errc::invalid_request, "question {} waits no more{}; step {} asks now: {}", *number,
                last_.empty() ? "" : " (" + last_ + ")", open_->question.step_id,
                prompt_words(open_->question));
  }
  auto value = read_answer(open_->question, given);
  if (!value) return fail(value.error());
  Answered taken{.question = open_->question, .value = *value};
  accept(GivenAnswer{std::move(*value), AnswerSource::person, std::move(by)});
  return taken;
}

void Questions::accept(const GivenAnswer& answer) {
  if (!open_) return;
  const Question& q = open_->question;
  last_ = fmt::format("step {} was answered {}: {}", q.step_id,
                      answer.by.empty() ? "by its default" : "by " + answer.by,
                      answer_words(answer.value, q.unit));
  log_.event(answer_event(q, answer, repeat_));
  answered_ = true;
  open_.reset();
  answers_.try_send(boost::system::error_code());
}

void Questions::wait_on() {
  if (open_) open_->until.reset();
}

void Questions::withdraw(std::string why) {
  last_ = std::move(why);
  open_.reset();
}

Task<> Questions::answered() {
  auto r = co_await answers_.async_receive(kAsResult);
  static_cast<void>(r);
}

bool Questions::take() {
  return std::exchange(answered_, false);
}

AnswerEvent answer_event(const Question& question, const GivenAnswer& answer, std::int64_t repeat) {
  AnswerEvent out;
  out.question = question.text;
  out.type = to_string(question.type);
  if (const auto* number = std::get_if<double>(&answer.value)) {
    out.number = *number;
    out.unit = question.unit;
  } else if (const auto* text = std::get_if<std::string>(&answer.value)) {
    out.text = *text;
  }
  out.source = to_string(answer.source);
  if (!answer.by.empty()) out.by = answer.by;
  out.repeat = repeat;
  return out;
}

}  // namespace lcrig
