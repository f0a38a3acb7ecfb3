// SPDX-License-Identifier: Apache-2.0
#include "protocols/run/answer_event.hpp"

namespace lcrig {

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
