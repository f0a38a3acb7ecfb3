// SPDX-License-Identifier: Apache-2.0
// Building blocks of HTML. Private to the report. Text from a person, an instrument or a file must
// pass through `text` before it gets here.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/analysis.hpp"

namespace lcrig::report {

std::string text(std::string_view words);  // escaped

// Markup of a table's cell. Numbers are aligned to the right. Otherwise it is an ordinary string.
class Cell : public std::string {
 public:
  enum class Kind { words, number };
  Cell(std::string markup, Kind kind = Kind::words) : std::string(std::move(markup)), kind_(kind) {}
  Cell(const char* markup) : std::string(markup) {}
  bool is_number() const { return kind_ == Kind::number; }

 private:
  Kind kind_ = Kind::words;
};

Cell no_number();  // a dash in place of a number
// A number as people read it, with the full value for programs: <data value="5.7512">5.75</data>.
// It shows digits up to the second of the standard error, or four digits of the value.
Cell number(double value, std::optional<double> standard_error = std::nullopt);
Cell number(const std::optional<double>& value);
Cell number(std::int64_t value);
// "5.751 ± 0.012".
Cell measured(double value, std::optional<double> standard_error);
Cell measured(const Metric& metric);  // if there is no estimate: the reason
Cell interval(const std::optional<std::array<double, 2>>& ends,
              std::optional<double> standard_error);
// "95 % interval", followed by what the interval is for.
std::string interval_head(double confidence);
// A line with the branch and time that a result refers to; empty if there is none.
std::string estimand_line(const std::string& estimand);
// Explains what intervals and expanded uncertainties promise. A page with results has it once.
std::string two_truths();
Cell percent(double fraction_percent);  // with its sign: "+235.7 %"
// The same as `number` without markup, for the labels of pictures.
std::string plain_number(double value, std::optional<double> standard_error = std::nullopt);

std::string range_numbers(const PressureRange& range);  // "0–30"
std::string range_name(const PressureRange& range);  // "0–30 kPa"

class Table {
 public:
  // The heads are words of the program and may contain markup.
  explicit Table(std::initializer_list<std::string> heads);
  explicit Table(const std::vector<std::string>& heads);
  static Table of_facts();  // two columns without heads; long words wrap
  Table& row(const std::vector<Cell>& cells);  // the first cell is the head of the row
  bool empty() const { return rows_ == 0; }
  std::string html() const;

 private:
  std::string head_, body_;
  int rows_ = 0;
};

std::string section(std::string_view id, std::string_view title, std::string_view body);
std::string paragraph(std::string_view markup, std::string_view kind = "");
// A whole page around the body; `title` is plain text.
std::string page(std::string_view title, std::string_view body);

}  // namespace lcrig::report
