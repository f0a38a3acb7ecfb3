// SPDX-License-Identifier: Apache-2.0
#include "analysis/csv.hpp"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

#include "base/decimal.hpp"

namespace lcrig {

void append_text_cell(std::string& out, std::string_view text) {
  const bool formula =
      !text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos;
  const bool quote = text.find_first_of(",\"\r\n") != std::string_view::npos;
  if (quote) out += '"';
  if (formula) out += '\'';
  if (!quote) {
    out += text;
    return;
  }
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
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
