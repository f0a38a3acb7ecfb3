// SPDX-License-Identifier: Apache-2.0
// A question that a protocol asks a person, and the answers that it accepts. The step `ask` asks;
// the control socket, the command line and a rehearsal answer. All of them check answers here.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/result.hpp"
#include "base/time.hpp"

namespace lcrig {

enum class AnswerType { confirmation, choice, number, line };
template <>
inline constexpr EnumWords<4> kWordsOf<AnswerType>{"confirmation", "choice", "number", "line"};

// An answer, as typed or as a value: true for a confirmation, a number in the unit of the question,
// one of its choices, or a line of text.
using AnswerValue = std::variant<bool, double, std::string>;

// What happens when nobody answers a question in time.
enum class OnTimeout { abort, wait, use_default };
template <>
inline constexpr EnumWords<3> kWordsOf<OnTimeout>{"abort", "wait", "default"};

struct Question {
  std::string step_id, text;
  AnswerType type = AnswerType::confirmation;
  std::vector<std::string> choices;
  double min = 0, max = 0;  // for a number, in `unit`
  std::string unit;  // for a number, the suffix of a key; empty: a pure number
  std::optional<AnswerValue> fallback;  // the protocol's default
  OnTimeout on_timeout = OnTimeout::abort;
};

inline constexpr std::size_t kAnswerMax = 1'000;  // bytes of a line

// "a number from 20 to 400 um", "one of: clean, dusty".
std::string expected_words(const Question& question);
// The text of a question for a person, and the answers that it accepts.
std::string prompt_words(const Question& question);
// "125.5 um", "clean", "confirmed".
std::string answer_words(const AnswerValue& value, const std::string& unit);
// Converts a given answer to a value; a text is read as the question's type. Errors:
// invalid_request, with what was found and what is expected.
Result<AnswerValue> read_answer(const Question& question, const AnswerValue& given);

// Who or what gave an answer.
enum class AnswerSource {
  person,
  fallback,  // the protocol's default
  file,  // a file of answers for a rehearsal
  made_up  // invented by a rehearsal without default and file
};
template <>
inline constexpr EnumWords<4> kWordsOf<AnswerSource>{"person", "default", "file", "made_up"};

struct GivenAnswer {
  AnswerValue value;
  AnswerSource source = AnswerSource::person;
  std::string by;  // the person; empty: no person answered
};

// An answer that was accepted.
struct Answered {
  std::int64_t run = 0;
  Question question;
  AnswerValue value;
};

// A question that waits for its answer.
struct OpenQuestion {
  Question question;
  std::int64_t number = 0;  // counts the run's questions, from 1; an answer may name it
  std::optional<MonoTime> until;  // its time-out; absent: passed, and it still waits
};

}  // namespace lcrig
