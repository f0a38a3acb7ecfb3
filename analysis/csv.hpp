// SPDX-License-Identifier: Apache-2.0
// Writes CSV as in RFC 4180: comma, CRLF, quotes doubled. Goes to a file descriptor in big pieces,
// or to memory. The export and the tables of the report use it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.hpp"

namespace lcrig {

// Appends a text cell. One that begins with = + - @ (also full-width, or behind blanks), TAB, CR or
// LF would be a formula to a spreadsheet. It gets a leading apostrophe, which spreadsheets do not
// show. Cells with comma, semicolon, quote, tab or line end are quoted. Other control characters,
// characters that reorder text and bytes that are not UTF-8 become \xNN or \uNNNN.
void append_text_cell(std::string& out, std::string_view text);

class CsvWriter {
 public:
  // Writes to `fd`, which the caller keeps and closes; messages call it `name`.
  CsvWriter(int fd, std::string name) : fd_(fd), name_(std::move(name)) { out_.reserve(kBuffer); }
  // Keeps everything in memory until `take`.
  CsvWriter() = default;

  void text(std::string_view cell) { append_text_cell(separate(), cell); }
  // For words that the program itself chose; they never need quotes.
  void word(std::string_view cell) { separate().append(cell); }
  void integer(std::int64_t value);
  void integer(std::optional<std::int64_t> value);
  void number(std::optional<double> value, int power = 0);  // times 10^power, with unchanged digits
  // For computed values: rounded to a multiple of 10^place, or to `digits`; `power` as above.
  void rounded(std::optional<double> value, int place, int power = 0);
  void significant(std::optional<double> value, int digits);
  void decimal(std::int64_t value, int power);
  void empty() { separate(); }
  void rows(std::string_view complete) { out_.append(complete); }  // made by another writer
  Result<> end_row();
  Result<> flush();
  std::string take() { return std::exchange(out_, {}); }

 private:
  static constexpr std::size_t kBuffer = 1 << 18;
  std::string& separate();
  int fd_ = -1;
  std::string name_;
  std::string out_;
  bool row_begun_ = false;
};

}  // namespace lcrig
