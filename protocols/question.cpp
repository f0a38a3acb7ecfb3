// SPDX-License-Identifier: Apache-2.0
#include "protocols/question.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/near_word.hpp"
#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kShown = 60;  // characters of a wrong answer in a message

std::string with_unit(std::string number, const std::string& unit) {
  return unit.empty() ? number : std::move(number) + " " + unit;
}

std::string shown(const AnswerValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return printable(*text, kShown);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  return std::get<bool>(value) ? "true" : "false";
}

// `guess`: ", did you mean `dusty`?", or "".
tl::unexpected<Error> wrong(const Question& q, const AnswerValue& given, std::string_view why,
                            std::string_view guess = "") {
  return fail(Errc::invalid_request, "step {}: \"{}\" {}{} expected {}", q.step_id, shown(given),
              why, guess.empty() ? "," : guess, expected_words(q));
}

Result<AnswerValue> read_confirmation(const Question& q, const AnswerValue& given) {
  constexpr std::array<std::string_view, 8> kYes{"", "yes", "Yes", "YES", "y", "ok", "OK", "true"};
  const auto* text = std::get_if<std::string>(&given);
  const auto* flag = std::get_if<bool>(&given);
  const bool typed = text != nullptr && std::ranges::find(kYes, trimmed(*text)) != kYes.end();
  if (typed || (flag != nullptr && *flag)) return AnswerValue(true);
  return wrong(q, given, "does not confirm (lcrig abort ends the run)");
}

Result<AnswerValue> read_choice(const Question& q, const AnswerValue& given) {
  const auto* text = std::get_if<std::string>(&given);
  if (text == nullptr) return wrong(q, given, "is no text");
  const std::string choice(trimmed(*text));
  if (std::ranges::find(q.choices, choice) != q.choices.end()) return AnswerValue(choice);
  return wrong(q, given, "is no choice", did_you_mean(choice, q.choices));
}

Result<AnswerValue> read_number(const Question& q, const AnswerValue& given) {
  const auto* text = std::get_if<std::string>(&given);
  const auto* value = std::get_if<double>(&given);
  std::optional<double> number;
  if (value != nullptr) number = *value;
  if (text != nullptr) number = number_from<double>(trimmed(*text));
  if (!number || !std::isfinite(*number)) {
    const auto words = text != nullptr ? number_words(trimmed(*text), q.unit) : std::string();
    return wrong(q, given, words.empty() ? "is no number" : "is no number: " + words);
  }
  if (*number < q.min || *number > q.max) return wrong(q, given, "is out of range");
  return AnswerValue(*number);
}

Result<AnswerValue> read_line(const Question& q, const AnswerValue& given) {
  const auto* text = std::get_if<std::string>(&given);
  if (text == nullptr) return wrong(q, given, "is no text");
  const std::string line(trimmed(*text));
  if (line.empty()) return wrong(q, given, "is empty");
  if (line.find_first_of("\r\n") != line.npos) return wrong(q, given, "has several lines");
  if (auto good = check_text("step " + q.step_id, line, kAnswerMax); !good) {
    return fail(good.error());
  }
  return AnswerValue(line);
}

}  // namespace

std::string expected_words(const Question& q) {
  switch (q.type) {
    case AnswerType::confirmation: return "a confirmation: yes";
    case AnswerType::choice: return fmt::format("one of: {}", fmt::join(q.choices, ", "));
    case AnswerType::number:
      return with_unit(fmt::format("a number from {} to {}", q.min, q.max), q.unit);
    case AnswerType::line: break;
  }
  return fmt::format("a line of at most {} bytes", kAnswerMax);
}

std::string prompt_words(const Question& q) {
  if (q.type == AnswerType::confirmation) return q.text;
  return fmt::format("{} ({})", q.text, expected_words(q));
}

std::string answer_words(const AnswerValue& value, const std::string& unit) {
  if (std::holds_alternative<bool>(value)) return "confirmed";
  return std::holds_alternative<double>(value) ? with_unit(shown(value), unit) : shown(value);
}

Result<AnswerValue> read_answer(const Question& question, const AnswerValue& given) {
  switch (question.type) {
    case AnswerType::confirmation: return read_confirmation(question, given);
    case AnswerType::choice: return read_choice(question, given);
    case AnswerType::number: return read_number(question, given);
    case AnswerType::line: break;
  }
  return read_line(question, given);
}

}  // namespace lcrig
