// SPDX-License-Identifier: Apache-2.0
// Reads named columns of numbers from a CSV file that another program wrote. Used for recordings.
#pragma once

#include <cstddef>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace lcrig {

// UTF-8, with or without a byte order mark; one header line, cells between commas and without
// quotes, every line with its end. Anything else is refused by name.
class RecordedTable {
 public:
  // `expected`: the columns that the header must have, for messages.
  RecordedTable(std::string path, std::string_view expected)
      : path_(std::move(path)), expected_(expected) {}

  // Reads the header. Call it first.
  Result<> open();
  // Whether the header has this column. Error: it has it twice.
  Result<bool> has(std::string_view name) const;
  // Calls `row` with the values of these columns, the first of which must grow from row to row.
  Result<> read(std::span<const std::string_view> names,
                const std::function<void(std::span<const double>)>& row);

 private:
  Result<bool> next_line();  // false: there is none
  Result<> check_header() const;
  Result<> select(std::span<const std::string_view> names);
  Result<> parse_row();
  Result<double> parse_cell(std::string_view text, std::string_view name) const;
  std::string place() const;  // "dir/lcr.csv:3"

  std::string path_;
  std::string_view expected_;
  std::ifstream file_;
  std::string text_;  // the current line
  int line_ = 0;
  std::vector<std::string> header_;
  std::vector<std::string_view> names_;
  std::vector<std::size_t> columns_;  // of names_
  std::vector<double> values_;
};

}  // namespace lcrig
