// SPDX-License-Identifier: Apache-2.0
// The terms of an entry of the queue: when it may begin, what has to be on the rig, what is done
// after a failure, and whether it may move the frame while nobody is there. The queue's decisions
// and the control socket use them.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/day_time.hpp"
#include "base/queue_words.hpp"
#include "base/result.hpp"
#include "protocols/batch/batch.hpp"

namespace lcrig {

class ParamsReader;

struct QueueTerms {
  OnFailure on_failure = OnFailure::hold;
  std::int64_t failures_max = 3;  // in a row, of whatever entries; then the queue holds
  bool unattended = false;  // may move the frame without a person
  double rest_s = 0;  // since the last run ended
  std::optional<std::int64_t> not_before_unix_s, not_after_unix_s;  // when it may begin
  std::optional<DayWindow> between;
  std::string probe, fixture;  // as people call them; empty: whichever is there
};

// The members of an object that are terms. What is missing has its default.
void read_terms(ParamsReader& in, QueueTerms& out);
// A term in a row of a batch replaces the one for all rows.
QueueTerms with_row_terms(QueueTerms all, const BatchTerms& row);
nlohmann::json to_json(const QueueTerms& terms);
// As stored. Errors: garbled.
Result<QueueTerms> parse_terms(std::string_view json_text);

}  // namespace lcrig
