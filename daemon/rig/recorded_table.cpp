// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/recorded_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/number.hpp"
#include "base/text.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kLongest = 200;  // characters of a header in a message

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const auto comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// Without the mark that some programs write before UTF-8.
void drop_byte_order_mark(std::string& text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.erase(0, kMark.size());
}

// Why this text is not a whole number; "": no such reason is known.
std::string_view reason_of(std::string_view text) {
  if (text.empty()) {
    return "; leave the row out, or (Rp_ohm of an overload) write 1e20";
  }
  if (text.ends_with('.')) return ", with digits behind the point; it may be cut off";
  return "; a missing value is a row that is left out";
}

}  // namespace

std::string RecordedTable::place() const {
  return fmt::format("{}:{}", path_, line_);
}

// A last line without its end may have been cut off anywhere, also inside of a number.
Result<bool> RecordedTable::next_line() {
  if (!std::getline(file_, text_)) return false;
  ++line_;
  if (!file_.eof()) return true;
  return fail(Errc::invalid_request,
              "{}: the last line has no line end, so it may be cut off: remove the line, or end it "
              "if it is whole",
              place());
}

Result<> RecordedTable::open() {
  file_.open(path_);
  auto first = file_ ? next_line() : Result<bool>(false);
  if (!first) return fail(first.error());
  if (!*first) {
    return fail(Errc::io,
                "{}: cannot be read, or is empty; a replay bench needs lcr.csv and frame.csv",
                path_);
  }
  drop_byte_order_mark(text_);
  if (auto good = check_header(); !good) return good;
  for (const std::string_view cell : split(text_)) header_.emplace_back(cell);
  return {};
}

Result<> RecordedTable::check_header() const {
  const auto refuse = [this](std::string_view what) {
    return fail(Errc::invalid_request, "{}: {}; expected the columns {}", place(), what, expected_);
  };
  if (text_.find('\0') != text_.npos || !is_utf8(text_)) {
    return refuse("the header is not UTF-8 text (UTF-16?): save the file as UTF-8");
  }
  if (trimmed(text_).find('\r') != std::string_view::npos) {
    return refuse("the lines end in CR alone: save the file with LF or CRLF");
  }
  return {};
}

Result<bool> RecordedTable::has(std::string_view name) const {
  const auto count = std::ranges::count(header_, name);
  if (count <= 1) return count == 1;
  const auto first = std::ranges::find(header_, name);
  const auto second = std::find(first + 1, header_.end(), name);
  return fail(Errc::invalid_request,
              "{}: the column `{}` stands twice (columns {} and {}): remove or rename one of them",
              place(), name, first - header_.begin() + 1, second - header_.begin() + 1);
}

Result<> RecordedTable::select(std::span<const std::string_view> names) {
  for (const std::string_view name : names) {
    auto there = has(name);
    if (!there) return fail(there.error());
    if (!*there) {
      return fail(Errc::invalid_request,
                  "{}: no column `{}`; expected the columns {}, between commas; the header is `{}`",
                  place(), name, expected_,
                  printable(fmt::format("{}", fmt::join(header_, ",")), kLongest));
    }
    const auto at = std::ranges::find(header_, name) - header_.begin();
    columns_.push_back(static_cast<std::size_t>(at));
  }
  names_.assign(names.begin(), names.end());
  values_.resize(names.size());
  return {};
}

Result<> RecordedTable::read(std::span<const std::string_view> names,
                             const std::function<void(std::span<const double>)>& row) {
  if (auto good = select(names); !good) return good;
  double last = -INFINITY;
  while (true) {
    auto there = next_line();
    if (!there) return fail(there.error());
    if (!*there) return {};
    if (trimmed(text_).empty()) continue;
    if (auto good = parse_row(); !good) return good;
    if (!(values_[0] > last)) {
      return fail(Errc::invalid_request,
                  "{}: `{}` is {} after {}; expected times that grow from row to row: sort the "
                  "rows, and give times with enough digits",
                  place(), names_[0], values_[0], last);
    }
    last = values_[0];
    row(values_);
  }
}

Result<> RecordedTable::parse_row() {
  const auto cells = split(text_);
  if (cells.size() != header_.size()) {
    return fail(Errc::invalid_request,
                "{}: {} cells, but the header has {}; expected a number with a decimal point in "
                "each cell, and a row that is not cut off",
                place(), cells.size(), header_.size());
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    auto value = parse_cell(cells[columns_[i]], names_[i]);
    if (!value) return fail(value.error());
    values_[i] = *value;
  }
  return {};
}

Result<double> RecordedTable::parse_cell(std::string_view text, std::string_view name) const {
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);  // meters write it
  const auto value = number_from<double>(digits);
  if (value && !digits.ends_with('.')) return *value;
  return fail(Errc::invalid_request, "{}: column `{}` holds `{}`, expected a number{}", place(),
              name, printable(text, kLongest), reason_of(text));
}

}  // namespace lcrig
