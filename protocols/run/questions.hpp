// SPDX-License-Identifier: Apache-2.0
// The question of a run that waits for a person, and its answer: the first one that fits. The step
// `ask` opens the question. People answer over the control socket, or a simulated person does.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <optional>
#include <string>

#include "protocols/question.hpp"
#include "protocols/run/event_log.hpp"

namespace lcrig {

// Answers instead of a person, after a time that a person would need.
class Respondent {
 public:
  virtual ~Respondent() = default;
  // Errors: an answer that does not fit; aborted, when the question was withdrawn.
  virtual Task<Result<GivenAnswer>> answer(Question question) = 0;
};

class Questions {
 public:
  // `log` must outlive it.
  Questions(asio::any_io_executor executor, const EventLog& log)
      : log_(log), answers_(executor, 1) {}

  // Keeps a question open while it lives, or until it is answered.
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
  // Call from the io thread, at any time. `number` says which question is meant. The event of the
  // answer is queued on return. Errors: invalid_request, and nothing is changed.
  Result<Answered> answer(const AnswerValue& given, std::string by,
                          std::optional<std::int64_t> number);
  // Takes an answer from a default or a simulated person.
  void accept(const GivenAnswer& answer);
  // Its time-out has passed: wait_on keeps it open; withdraw closes it, with the reason.
  void wait_on();
  void withdraw(std::string why);

  Task<> answered();  // returns when the open question was answered
  bool take();  // true once after an answer

 private:
  const EventLog& log_;
  asio::experimental::channel<void(boost::system::error_code)> answers_;
  std::optional<OpenQuestion> open_;
  std::int64_t asked_ = 0;  // number of questions so far
  std::int64_t repeat_ = 0;  // pass of the outermost loop around the open question
  bool answered_ = false;
  std::string last_;  // the end of the last question in words
};

// The row of an answer. `repeat`: the pass of the outermost loop around the question; 0: none.
AnswerEvent answer_event(const Question& question, const GivenAnswer& answer, std::int64_t repeat);

}  // namespace lcrig
