// SPDX-License-Identifier: Apache-2.0
// Turns a table of runs into runs: checks every cell, then orders the runs for the queue. Used by
// `lcrig queue add --batch` and `lcrig rehearse --batch`.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/queue_words.hpp"
#include "base/time.hpp"
#include "protocols/batch/table.hpp"
#include "protocols/file/parse.hpp"

namespace lcrig {

// Columns for the terms of a row in the queue (docs/queue.md).
inline constexpr std::array<std::string_view, 6> kBatchTermColumns{
    "on_failure", "failures_max", "unattended", "rest_s", "probe", "fixture"};
inline constexpr std::int64_t kMostFailuresInRow = 100;
inline constexpr double kLongestRest_s = kLongestTime_s;
inline constexpr std::int64_t kBatchRunsMax = 10'000;

struct BatchTerms {
  std::optional<OnFailure> on_failure;
  std::optional<std::string> probe, fixture;
  std::optional<std::int64_t> failures_max;
  std::optional<bool> unattended;
  std::optional<double> rest_s;
};

// One row; it becomes `repeats` runs.
struct BatchEntry {
  TextPosition at;
  std::string protocol;  // as the cell names it
  std::string protocol_name, protocol_text;  // the text contains the meter's settings of the row
  std::string specimen_name, specimen_text;  // without a text, the daemon knows the name
  ParameterValues parameters;
  std::int64_t repeats = 1;
  std::string note;
  BatchTerms terms;
};

struct BatchFile {
  std::string name, path, text;
};
// Finds the file that a cell names. Errors: one line for people that ends with what to do.
struct BatchLookup {
  std::function<Result<BatchFile>(const std::string&)> protocol, specimen;
};
// Checks a table. Errors: invalid_request, with all mistakes at once.
Result<std::vector<BatchEntry>> check_batch(const BatchTable& table, const BatchLookup& lookup);
// Checks the terms that a JSON batch states for all of its rows.
Result<BatchTerms> check_batch_terms(const BatchTable& table);

struct BatchTurn {
  std::size_t row = 0;  // index of the entry
  std::int64_t repeat = 1;
  bool operator==(const BatchTurn&) const = default;
};
// Orders the runs. The same seed gives the same order on every computer.
std::vector<BatchTurn> order_batch(std::span<const BatchEntry> entries, BatchOrder order,
                                   std::uint64_t seed);

}  // namespace lcrig
