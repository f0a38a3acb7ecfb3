// SPDX-License-Identifier: Apache-2.0
// The question of a run that waits for a person, and its answer: the first that fits. The step
// `ask` opens it; people answer over the control socket, or a simulated person does.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <optional>
#include <string>

#include "protocols/question.hpp"
#include "protocols/run/event_log.hpp"

namespace lcrig {

// Answers in the place of a person, after as long as a person takes.
class Respondent {
 public:
  virtual ~Respondent() = default;
  // Errors: an answer that does not fit; aborted, when the question was withdrawn.
  virtual Task<Result<GivenAnswer>> answer(Question question) = 0;
};

class Questions {
 public:
  // `log` outlives it.
  Questions(asio::any_io_executor executor, const EventLog& log)
      : log_(log), answers_(executor, 1) {}

  // A question waits as long as this lives, or until it is answered.
  class Wait {
   public:
    Wait(Questions& questions, Question question, std::int64_t repeat, MonoTime until);
    ~Wait() { questions_.open_.reset(); }
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;

   private:
    Questions& questions_;
  };

  const std::optional<OpenQuestion>& open() const { return open_; }
  // From the io thread, at any time; `number` names the question that is meant. The event row of
  // the answer is queued when this returns. Errors: invalid_request, and nothing is changed.
  Result<Answered> answer(const AnswerValue& given, std::string by,
                          std::optional<std::int64_t> number);
  // Takes an answer that no person gave: a default, or that of a simulated person.
  void accept(const GivenAnswer& answer);
  // Its time is over: it waits on, or nobody can answer any more, and why.
  void wait_on();
  void withdraw(std::string why);

  Task<> answered();  // returns when the open question was answered
  bool take();  // it was, and nobody has taken notice yet

 private:
  const EventLog& log_;
  asio::experimental::channel<void(boost::system::error_code)> answers_;
  std::optional<OpenQuestion> open_;
  std::int64_t asked_ = 0;  // questions so far
  std::int64_t repeat_ = 0;  // of the outermost loop around the open one
  bool answered_ = false;
  std::string last_;  // what became of the last question, in words
};

// The row that an answer is stored in. `repeat`: of the outermost loop around the question; 0:
// none.
AnswerEvent answer_event(const Question& question, const GivenAnswer& answer, std::int64_t repeat);

}  // namespace lcrig
