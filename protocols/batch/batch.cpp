// SPDX-License-Identifier: Apache-2.0
#include "protocols/batch/batch.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/enum_words.hpp"
#include "base/near_word.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "protocols/file/meter_text.hpp"

namespace lcrig {

namespace {

constexpr std::array<std::string_view, 2> kMeterColumns{"frequency_Hz", "aperture"};

// Splits "a=1 b=2" at blanks, commas and semicolons.
std::vector<std::string> assignments_in(std::string_view text) {
  std::vector<std::string> out;
  while (!(text = trimmed(text)).empty()) {
    const auto end = std::min(text.find_first_of(" \t\r\n,;"), text.size());
    if (end > 0) out.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

std::string quoted_cell(const BatchCell& cell) {
  return fmt::format("\"{}\"", printable(cell.text, 60));
}

void take_whole_number(const BatchCell& cell, std::string_view column, std::int64_t most,
                       std::int64_t& out, BatchMistakes& wrong) {
  const auto number = number_from<std::int64_t>(cell.text);
  if (number && *number >= 1 && *number <= most) {
    out = *number;
    return;
  }
  wrong.add(cell.at, column,
            fmt::format("{}, expected a whole number from 1 to {}", quoted_cell(cell), most));
}

void take_word(const BatchCell& cell, std::string_view column, std::optional<std::string>& out,
               BatchMistakes& wrong) {
  if (auto good = check_text(column, cell.text, kNameMax); !good) {
    wrong.add(cell.at, column, good.error().what);
  }
  out = cell.text;
}

void take_term(const BatchCell& cell, std::string_view column, BatchTerms& out,
               BatchMistakes& wrong) {
  if (column == "on_failure") {
    out.on_failure = parse_word<OnFailure>(cell.text);
    if (out.on_failure) return;
    wrong.add(cell.at, column,
              fmt::format("{}, expected {}", quoted_cell(cell), either_of(all_words<OnFailure>())));
  } else if (column == "failures_max") {
    take_whole_number(cell, column, kMostFailuresInRow, out.failures_max.emplace(1), wrong);
  } else if (column == "unattended") {
    out.unattended = cell.text == "yes";
    if (cell.text == "yes" || cell.text == "no") return;
    wrong.add(cell.at, column, fmt::format("{}, expected yes or no", quoted_cell(cell)));
  } else if (column == "rest_s") {
    out.rest_s = number_from<double>(cell.text);
    if (out.rest_s && *out.rest_s >= 0 && *out.rest_s <= kLongestRest_s) return;
    const auto comma = comma_words(cell.text);
    wrong.add(cell.at, column,
              comma.empty() ? fmt::format("{}, expected seconds from 0 to {:.0f}",
                                          quoted_cell(cell), kLongestRest_s)
                            : comma);
  } else {
    take_word(cell, column, column == "probe" ? out.probe : out.fixture, wrong);
  }
}

// A protocol that rows name, parsed once for each setting of the meter.
struct KnownProtocol {
  std::string name, text, path;
  Protocol protocol;
};

class BatchChecker {
 public:
  BatchChecker(const BatchTable& table, const BatchLookup& lookup)
      : table_(table), lookup_(lookup) {}

  Result<std::vector<BatchEntry>> check() {
    find_columns();
    std::vector<BatchEntry> out;
    if (wrong_.empty()) {
      out.reserve(table_.rows.size());
      for (const BatchRow& row : table_.rows) out.push_back(entry_of(row));
      check_values();
      check_count(out);
    }
    if (auto good = wrong_.result(table_.source, table_.text); !good) return fail(good.error());
    return out;
  }

 private:
  static bool is_own(std::string_view name) {
    const bool term = std::ranges::find(kBatchTermColumns, name) != kBatchTermColumns.end();
    return term || name == "specimen" || name == "protocol" || name == "repeats" ||
           name == "note" || name == "parameters";
  }

  void find_columns() {
    for (std::size_t i = 0; i < table_.columns.size(); ++i) {
      const BatchColumn& column = table_.columns[i];
      if (!column.is_parameter && is_own(column.name)) {
        own_[column.name] = i;
      } else {
        parameters_.push_back(i);
      }
    }
    std::vector<std::string> heads;
    for (const BatchColumn& column : table_.columns) heads.push_back(column.name);
    for (const char* name : {"specimen", "protocol"}) {
      if (own_.contains(name)) continue;
      const auto near = nearest_word(name, heads);
      wrong_.add(table_.columns.front().at, "",
                 near ? fmt::format("no column `{}`; is it `{}`?", name, printable(*near, 60))
                      : fmt::format("no column `{}`; a table has at least the columns specimen "
                                    "and protocol",
                                    name));
    }
  }

  const BatchCell* cell_of(const BatchRow& row, const char* column) const {
    const auto found = own_.find(column);
    if (found == own_.end() || row.cells[found->second].text.empty()) return nullptr;
    return &row.cells[found->second];
  }
  // Where a missing value of a row belongs.
  TextPosition place_of(const BatchRow& row, const char* column) const {
    const auto found = own_.find(column);
    if (found == own_.end()) return row.at;
    const BatchCell& cell = row.cells[found->second];
    return cell.at.line >= row.at.line ? cell.at : row.at;
  }

  BatchEntry entry_of(const BatchRow& row) {
    BatchEntry out;
    out.at = row.at;
    take_specimen(row, out);
    if (const BatchCell* cell = cell_of(row, "repeats")) {
      take_whole_number(*cell, "repeats", kBatchRunsMax, out.repeats, wrong_);
    }
    if (const BatchCell* cell = cell_of(row, "note")) {
      out.note = cell->text;
      if (auto good = check_text("note", cell->text, kNoteMax); !good) {
        wrong_.add(cell->at, "note", good.error().what);
      }
    }
    for (const std::string_view term : kBatchTermColumns) {
      if (const BatchCell* cell = cell_of(row, term.data())) {
        take_term(*cell, term, out.terms, wrong_);
      }
    }
    take_protocol(row, out);
    return out;
  }

  void take_specimen(const BatchRow& row, BatchEntry& out) {
    const BatchCell* cell = cell_of(row, "specimen");
    if (cell == nullptr) {
      wrong_.add(place_of(row, "specimen"), "specimen", "is empty, expected a name or a file");
      return;
    }
    auto known = specimens_.find(cell->text);
    if (known == specimens_.end()) {
      known = specimens_.emplace(cell->text, lookup_.specimen(cell->text)).first;
    }
    if (known->second) {
      out.specimen_name = known->second->name;
      out.specimen_text = known->second->text;
    } else {
      wrong_.add(cell->at, "specimen", known->second.error().what);
    }
  }

  // All values of a row, and the cells that they come from.
  struct Given {
    ParameterValues values;
    std::map<std::string, std::pair<TextPosition, std::string>> from;  // position and column
  };
  void give(Given& given, const std::string& name, const std::string& value, const BatchCell& cell,
            const std::string& column) {
    if (given.values.emplace(name, value).second) {
      given.from.emplace(name, std::pair(cell.at, column));
      return;
    }
    wrong_.add(cell.at, column, fmt::format("`{}` has two values in this row", name));
  }
  Given values_of(const BatchRow& row) {
    Given out;
    for (const std::size_t i : parameters_) {
      if (row.cells[i].text.empty()) continue;
      give(out, table_.columns[i].name, row.cells[i].text, row.cells[i], table_.columns[i].name);
    }
    const BatchCell* cell = cell_of(row, "parameters");
    if (cell == nullptr) return out;
    for (const std::string& word : assignments_in(cell->text)) {
      const auto equals = word.find('=');
      if (equals == word.npos || equals == 0 || equals + 1 == word.size()) {
        wrong_.add(cell->at, "parameters",
                   fmt::format("\"{}\", expected NAME=VALUE, several with blanks between",
                               printable(word, 60)));
        continue;
      }
      give(out, word.substr(0, equals), word.substr(equals + 1), *cell, "parameters");
    }
    return out;
  }

  void take_protocol(const BatchRow& row, BatchEntry& out) {
    const BatchCell* cell = cell_of(row, "protocol");
    if (cell == nullptr) {
      wrong_.add(place_of(row, "protocol"), "protocol", "is empty, expected a name or a file");
      return;
    }
    const Given given = values_of(row);
    const auto known = protocol_of(*cell, given);
    if (known == nullptr) return;
    out.protocol = cell->text;
    out.protocol_name = known->name;
    out.protocol_text = known->text;
    for (const auto& [name, value] : given.values) {
      const bool of_meter = std::ranges::find(kMeterColumns, name) != kMeterColumns.end() &&
                            !known->protocol.parameters.contains(name);
      if (of_meter) continue;
      out.parameters.emplace(name, value);
      ParameterValues alone;
      alone.emplace(name, value);
      if (const auto bound = bind_parameters(known->protocol, alone); !bound) {
        const auto& [at, column] = given.from.at(name);
        refused_.push_back({at, column, bound.error().what});
      }
    }
  }

  // nullptr: the file is wrong, and this was reported.
  const KnownProtocol* protocol_of(const BatchCell& cell, const Given& given) {
    auto file = files_.find(cell.text);
    if (file == files_.end()) {
      file = files_.emplace(cell.text, lookup_.protocol(cell.text)).first;
    }
    if (!file->second) {
      wrong_.add(cell.at, "protocol", file->second.error().what);
      return nullptr;
    }
    ParameterValues meter;
    std::string key = cell.text;
    for (const std::string_view name : kMeterColumns) {
      const auto value = given.values.find(std::string(name));
      if (value == given.values.end()) continue;
      meter.insert(*value);
      key += '\n' + std::get<std::string>(value->second);
    }
    const Result<KnownProtocol>& plain = known_protocol(cell.text, *file->second, {});
    if (!plain) {
      wrong_.add(cell.at, "protocol", plain.error().what);
      return nullptr;
    }
    const Result<KnownProtocol>& known = known_protocol(key, *file->second, meter);
    if (known) return &*known;
    refuse_settings(*file->second, meter, given, known.error());
    return &*plain;  // lets the other cells of the row be checked
  }

  const Result<KnownProtocol>& known_protocol(const std::string& key, const BatchFile& file,
                                              const ParameterValues& meter) {
    auto known = protocols_.find(key);
    if (known == protocols_.end()) {
      known = protocols_.emplace(key, parsed(file, meter)).first;
    }
    return known->second;
  }

  // Reports each setting that is wrong by itself. `together` is the error for all of them, reported
  // if none is wrong alone.
  void refuse_settings(const BatchFile& file, const ParameterValues& meter, const Given& given,
                       const Error& together) {
    bool said = false;
    for (const auto& setting : meter) {
      ParameterValues alone;
      alone.insert(setting);
      const auto one = parsed(file, std::move(alone));
      if (one) continue;
      const auto& [at, column] = given.from.at(setting.first);
      wrong_.add(at, column, one.error().what);
      said = true;
    }
    if (said) return;
    const auto& [at, column] = given.from.at(meter.begin()->first);
    wrong_.add(at, column, together.what);
  }

  static Result<KnownProtocol> parsed(const BatchFile& file, ParameterValues meter) {
    KnownProtocol out;
    out.path = file.path.empty() ? file.name : file.path;
    auto text = with_meter_values(file.text, out.path, meter);
    if (!text) return fail(text.error());
    auto protocol = parse_protocol(*text, out.path);
    if (!protocol) return fail(protocol.error());
    out.name = protocol->name;
    out.text = std::move(*text);
    out.protocol = std::move(*protocol);
    return out;
  }

  // A column that is unknown to every protocol of the table is reported once, in the header.
  void check_values() {
    std::set<std::string> said;
    if (const auto known = all_parameters()) {
      for (const std::size_t i : parameters_) {
        const BatchColumn& column = table_.columns[i];
        if (column.is_parameter || known->contains(column.name) || !is_used(i)) continue;
        said.insert(column.name);
        std::vector<std::string> words(known->begin(), known->end());
        words.insert(words.end(), {"specimen", "protocol", "repeats", "note", "parameters"});
        words.insert(words.end(), kBatchTermColumns.begin(), kBatchTermColumns.end());
        wrong_.add(column.at, column.name,
                   fmt::format("neither a column of a batch nor a parameter of its protocols{}",
                               did_you_mean(column.name, words)));
      }
    }
    for (const RefusedValue& value : refused_) {
      if (!said.contains(value.column)) wrong_.add(value.at, value.column, value.what);
    }
  }

  bool is_used(std::size_t column) const {
    return std::ranges::any_of(
        table_.rows, [column](const BatchRow& row) { return !row.cells[column].text.empty(); });
  }

  // nullopt: some protocol is wrong, so its parameters are unknown.
  std::optional<std::set<std::string>> all_parameters() const {
    std::set<std::string> out(kMeterColumns.begin(), kMeterColumns.end());
    for (const auto& [word, file] : files_) {
      if (!file) return std::nullopt;
    }
    for (const auto& [key, protocol] : protocols_) {
      const bool of_file = files_.contains(key);  // the file as it is, with the meter's settings
                                                  // unchanged
      if (!protocol && of_file) return std::nullopt;
      if (!protocol) continue;
      for (const auto& [name, p] : protocol->protocol.parameters) out.insert(name);
    }
    return out;
  }

  void check_count(const std::vector<BatchEntry>& entries) {
    std::int64_t runs = 0;
    for (const BatchEntry& entry : entries) {
      runs += entry.repeats;
      if (runs <= kBatchRunsMax) continue;
      wrong_.add(entry.at, "repeats",
                 fmt::format("more than {} runs up to here: split the table", kBatchRunsMax));
      return;
    }
  }

  struct RefusedValue {
    TextPosition at;
    std::string column, what;
  };

  const BatchTable& table_;
  const BatchLookup& lookup_;
  BatchMistakes wrong_;
  std::vector<RefusedValue> refused_;
  std::map<std::string, std::size_t> own_;
  std::vector<std::size_t> parameters_;  // indexes of the columns with parameters
  std::map<std::string, Result<BatchFile>> specimens_, files_;
  std::map<std::string, Result<KnownProtocol>> protocols_;
};

}  // namespace

Result<std::vector<BatchEntry>> check_batch(const BatchTable& table, const BatchLookup& lookup) {
  return BatchChecker(table, lookup).check();
}

Result<BatchTerms> check_batch_terms(const BatchTable& table) {
  BatchTerms out;
  BatchMistakes wrong;
  for (const auto& [name, cell] : table.terms) take_term(cell, name, out, wrong);
  if (auto good = wrong.result(table.source, table.text); !good) return fail(good.error());
  return out;
}

}  // namespace lcrig
