// SPDX-License-Identifier: Apache-2.0
#include "analysis/csv.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "base/decimal.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

// = + - @ and their full-width forms; a spreadsheet skips what is blank before them.
bool is_formula(std::string_view text) {
  while (!text.empty()) {
    const char32_t c = take_character(text);
    if (std::u32string_view(U"=+-@\t\r\n\uFF1D\uFF0B\uFF0D\uFF20").find(c) !=
        std::u32string_view::npos) {
      return true;
    }
    if (c != ' ') return false;
  }
  return false;
}

// True for nearly every cell, such as the id of a step or a status. Such a cell is copied as it is.
bool is_plain(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= 0x20 && c < 0x7f && c != '"'; });
}

// RFC 4180 text has no control characters except CR and LF; a tab is kept, too.
void append_character(std::string& out, char32_t c, std::string_view bytes) {
  if (c == '"') out += '"';
  if (c == '\n' || c == '\r' || c == '\t') {
    out += bytes;
  } else {
    out += printable(bytes);
  }
}

}  // namespace

void append_text_cell(std::string& out, std::string_view text) {
  const bool quote = text.find_first_of(",;\"\r\n\t") != std::string_view::npos;
  if (quote) out += '"';
  if (is_formula(text)) out += '\'';
  if (is_plain(text)) {
    out += text;
    text = {};
  }
  while (!text.empty()) {
    const std::string_view before = text;
    const char32_t c = take_character(text);
    append_character(out, c, before.substr(0, before.size() - text.size()));
  }
  if (quote) out += '"';
}

std::string& CsvWriter::separate() {
  if (row_begun_) out_ += ',';
  row_begun_ = true;
  return out_;
}

void CsvWriter::integer(std::int64_t value) {
  char text[24];
  separate().append(text, std::to_chars(text, text + sizeof text, value).ptr);
}
void CsvWriter::integer(std::optional<std::int64_t> value) {
  if (value) return integer(*value);
  empty();
}
void CsvWriter::number(std::optional<double> value, int power) {
  separate();
  if (value) append_decimal_shift(out_, *value, power);
}
void CsvWriter::rounded(std::optional<double> value, int place, int power) {
  separate();
  if (value) append_rounded(out_, *value, place, power);
}
void CsvWriter::significant(std::optional<double> value, int digits) {
  const auto places = value ? decimal_places(*value) : std::nullopt;
  if (!places) return number(value);
  rounded(value, places->first - digits + 1);
}
void CsvWriter::decimal(std::int64_t value, int power) {
  append_decimal_shift(separate(), value, power);
}

Result<> CsvWriter::end_row() {
  out_ += "\r\n";
  row_begun_ = false;
  constexpr std::size_t kRoom = 4096;  // for the next row, so that the buffer seldom grows
  return out_.size() + kRoom > kBuffer ? flush() : Result<>();
}

Result<> CsvWriter::flush() {
  if (fd_ < 0) return {};
  std::string_view rest = out_;
  while (!rest.empty()) {
    const ssize_t n = ::write(fd_, rest.data(), rest.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(Errc::io, "{}: {}", name_, std::strerror(errno));
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  out_.clear();
  return {};
}

}  // namespace lcrig
