// SPDX-License-Identifier: Apache-2.0
// Reads CSV as spreadsheets write it: RFC 4180, but also semicolons or tabs, any line end, a byte
// order mark, blanks around a cell, and empty rows.
#include <algorithm>
#include <map>

#include "base/text.hpp"
#include "protocols/batch/table.hpp"

namespace lcrig {

namespace {

// The separator of the cells: the candidate that occurs most often in the header.
char separator_of(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of("\r\n"), text.size()));
  const auto header = text.substr(0, text.find_first_of("\r\n"));
  char best = ',';
  std::ptrdiff_t most = 0;
  for (const char candidate : {',', ';', '\t'}) {
    const auto count = std::ranges::count(header, candidate);
    if (count <= most) continue;
    most = count;
    best = candidate;
  }
  return best;
}

class CsvScanner {
 public:
  CsvScanner(std::string_view text, char separator, BatchMistakes& wrong)
      : rest_(text), separator_(separator), wrong_(wrong) {}

  bool at_end() const { return rest_.empty(); }
  TextPosition at() const { return at_; }

  // One row of cells. It spans several lines when a quoted cell contains line ends.
  std::vector<BatchCell> record() {
    std::vector<BatchCell> cells;
    do {
      cells.push_back(cell());
    } while (take_if(separator_));
    end_line();
    return cells;
  }

 private:
  bool ends_cell() const {
    return rest_.empty() || rest_[0] == separator_ || rest_[0] == '\n' || rest_[0] == '\r';
  }
  bool take_if(char c) {
    if (rest_.empty() || rest_[0] != c) return false;
    take();
    return true;
  }
  char32_t take() {
    const bool line_ends = ends_line(rest_, 0);
    const char32_t c = take_character(rest_);
    ++at_.column;
    if (line_ends) {
      ++at_.line;
      at_.column = 1;
    }
    return c;
  }
  void end_line() {
    if (take_if('\r')) {
      if (!rest_.empty() && rest_[0] == '\n') take();
      return;
    }
    take_if('\n');
  }
  void skip_blanks() {
    while (!ends_cell() && (rest_[0] == ' ' || rest_[0] == '\t')) take();
  }

  BatchCell cell() {
    skip_blanks();
    BatchCell out;
    out.at = at_;
    if (take_if('"')) {
      quoted(out);
    } else {
      bare(out);
    }
    return out;
  }

  void bare(BatchCell& out) {
    while (!ends_cell()) {
      if (rest_[0] == '"') {
        wrong_.add(at_, "",
                   "a quote inside a cell: put the whole cell into quotes, and write the quote "
                   "twice");
        skip_cell();
        return;
      }
      append(out);
    }
    out.text = std::string(trimmed(out.text));
  }

  void quoted(BatchCell& out) {
    while (!rest_.empty()) {
      if (rest_[0] != '"') {
        append(out);
        continue;
      }
      take();
      if (take_if('"')) {
        out.text += '"';
        continue;
      }
      skip_blanks();
      if (ends_cell()) return;
      wrong_.add(at_, "", "text behind the quote that ends a cell: write a quote in a cell twice");
      skip_cell();
      return;
    }
    wrong_.add(out.at, "", "the quote that begins here has no end");
  }

  void append(BatchCell& out) {
    const TextPosition at = at_;
    const char32_t c = take();
    const bool blank = c == '\t' || c == '\n' || c == '\r';
    if (is_steering(c) && !blank) {
      wrong_.add(at, "", fmt::format("the character U+{:04X}, expected text", std::uint32_t{c}));
    }
    append_utf8(out.text, c);
  }
  void skip_cell() {
    while (!ends_cell()) take();
  }

  std::string_view rest_;
  char separator_;
  BatchMistakes& wrong_;
  TextPosition at_;
};

bool is_blank_record(const std::vector<BatchCell>& cells) {
  return std::ranges::all_of(cells, [](const BatchCell& c) { return c.text.empty(); });
}

void read_header(const std::vector<BatchCell>& cells, BatchTable& out, BatchMistakes& wrong) {
  std::map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const BatchCell& cell = cells[i];
    if (cell.text.empty()) {
      wrong.add(cell.at, "", fmt::format("column {} of the header has no name", i + 1));
    } else if (const auto [first, is_new] = seen.emplace(cell.text, i); !is_new) {
      wrong.add(cell.at, cell.text,
                fmt::format("columns {} and {} have the same name", first->second + 1, i + 1));
    }
    out.columns.push_back({.name = cell.text, .at = cell.at});
  }
}

void check_width(const std::vector<BatchCell>& cells, const BatchTable& table, char separator,
                 BatchMistakes& wrong) {
  const std::size_t heads = table.columns.size();
  if (cells.size() == heads) return;
  const bool less = cells.size() < heads;
  const char* comma = separator == ',' && !less
                          ? "; a comma separates cells: decimal numbers are written with a point"
                          : "";
  wrong.add(less ? cells.back().at : cells[heads].at, "",
            fmt::format("the row has {} cells, the header has {}{}", cells.size(), heads, comma));
}

}  // namespace

Result<BatchTable> read_batch_csv(std::string_view text, const std::string& source) {
  BatchTable out;
  BatchMistakes wrong;
  std::string_view body = text;
  if (body.starts_with(kByteOrderMark)) body.remove_prefix(kByteOrderMark.size());
  const char separator = separator_of(body);
  CsvScanner scanner(body, separator, wrong);
  while (!scanner.at_end()) {
    auto cells = scanner.record();
    if (is_blank_record(cells)) continue;
    if (out.columns.empty()) {
      read_header(cells, out, wrong);
      continue;
    }
    check_width(cells, out, separator, wrong);
    if (out.rows.size() == kBatchRowsMax) {
      wrong.add(cells.front().at, "", fmt::format("more than {} rows", kBatchRowsMax));
      break;
    }
    cells.resize(out.columns.size());
    const TextPosition begin = cells.front().at;
    out.rows.push_back({.at = begin, .cells = std::move(cells)});
  }
  if (out.columns.empty()) {
    wrong.add(TextPosition(), "",
              "the file is empty, expected a header: specimen,protocol,repeats");
  } else if (out.rows.empty() && wrong.empty()) {
    wrong.add(TextPosition(), "", "a header and no row: there is nothing to queue");
  }
  if (auto good = wrong.result(source, text); !good) return fail(good.error());
  return out;
}

}  // namespace lcrig
