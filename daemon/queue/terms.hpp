// SPDX-License-Identifier: Apache-2.0
// The terms of an entry of the queue: when it may begin, what has to be on the rig, what follows a
// failure, and whether it may move the frame with nobody present. Used by the queue's decisions and
// the control socket.
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
  std::int64_t failures_max = 3;  // in a row, of any entries; then the queue is held
  bool unattended = false;  // it may move the frame with nobody present
  double rest_s = 0;  // after the end of the last run
  std::optional<std::int64_t> not_before_unix_s, not_after_unix_s;  // earliest and latest begin
  std::optional<DayWindow> between;
  std::string probe, fixture;  // as people name them; empty: any
};

// Reads the members of an object that are terms. Missing ones have their defaults.
void read_terms(ParamsReader& in, QueueTerms& out);
// Terms of a row replace those for all rows.
QueueTerms with_row_terms(QueueTerms all, const BatchTerms& row);
nlohmann::json to_json(const QueueTerms& terms);
// Reads stored terms. Errors: garbled.
Result<QueueTerms> parse_terms(std::string_view json_text);

}  // namespace lcrig
