// SPDX-License-Identifier: Apache-2.0
// On what terms an entry waits in the queue: what is done after a failure, and whether it may move
// the frame while nobody is there.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace lcrig {

enum class OnFailure {
  hold,  // the queue, until a person says what is to be done
  skip,
  look,  // hold; once a person has looked, `queue start` repeats the entry, once
  repeat  // at once, and only after what did not touch the specimen
};
std::string_view to_string(OnFailure policy);
std::optional<OnFailure> parse_on_failure(std::string_view word);

struct QueueTerms {
  OnFailure on_failure = OnFailure::hold;
  std::int64_t failures_max = 3;  // in a row, of whatever entries; then the queue holds
  bool unattended = false;  // may move the frame without a person
};
inline constexpr std::int64_t kMostFailuresInRow = 100;

std::string to_json_text(const QueueTerms& terms);
// Errors: garbled. What is missing has its default.
Result<QueueTerms> parse_terms(std::string_view json_text);

}  // namespace lcrig
