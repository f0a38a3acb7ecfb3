// SPDX-License-Identifier: Apache-2.0
// Reads `batch/1`: the same table as JSON, with values that hold for all of its rows.
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/strict_json.hpp"
#include "protocols/batch/batch.hpp"
#include "protocols/batch/table.hpp"

namespace lcrig {

namespace {

// Refuses a value that does not fit its column.
void judge(std::string_view column, const JsonReader& value) {
  if (column == "repeats") {
    value.integer(1, kBatchRunsMax);
  } else if (column == "failures_max") {
    value.integer(1, kMostFailuresInRow);
  } else if (column == "rest_s") {
    value.number(Range{0, kLongestRest_s});
  } else if (column == "unattended") {
    value.boolean();
  } else if (column == "on_failure") {
    value.word<OnFailure>();
  } else {
    value.string();
  }
}

class BatchJson {
 public:
  explicit BatchJson(const JsonDocument& document) : document_(document), top_(document) {}

  Result<BatchTable> read() {
    top_.expect_format("batch/1");
    out_.name = text_of("name");
    if (const auto order = top_.find("order")) {
      order->word<BatchOrder>();
      out_.order = cell_of(*order);
    }
    if (const auto seed = top_.find("seed")) {
      seed->integer(0, std::numeric_limits<std::int64_t>::max());
      out_.seed = cell_of(*seed);
    }
    if (const auto terms = top_.find("terms")) {
      for (const std::string_view word : kBatchTermColumns) {
        const auto term = terms->find(word);
        if (!term) continue;
        judge(word, *term);
        out_.terms[std::string(word)] = cell_of(*term);
      }
      terms->no_other_keys();
    }
    for (const JsonReader& row : top_.at("runs").items(1, kBatchRowsMax)) read_row(row);
    top_.no_other_keys();
    if (auto good = top_.result(); !good) return fail(good.error());
    for (BatchRow& row : out_.rows) row.cells.resize(out_.columns.size());
    return std::move(out_);
  }

 private:
  std::optional<BatchCell> text_of(std::string_view key) {
    const auto found = top_.find(key);
    if (!found) return std::nullopt;
    return BatchCell{.text = found->nonempty_string(),
                     .at = document_.value_position(found->pointer())};
  }
  BatchCell cell_of(const JsonReader& value) const {
    BatchCell out;
    out.at = document_.value_position(value.pointer());
    if (value.is_number()) {
      out.text = document_.number_text(value.pointer());
    } else if (value.is_boolean()) {
      out.text = value.boolean() ? "yes" : "no";
    } else {
      out.text = value.string();
    }
    return out;
  }
  void put(BatchRow& row, const std::string& name, const JsonReader& value, bool is_parameter) {
    const auto same = [&](const BatchColumn& c) {
      return c.name == name && c.is_parameter == is_parameter;
    };
    auto found = std::ranges::find_if(out_.columns, same);
    if (found == out_.columns.end()) {
      const auto at = document_.key_position(value.pointer());
      found = out_.columns.insert(found, {.name = name, .at = at, .is_parameter = is_parameter});
    }
    if (!is_parameter) judge(name, value);
    const auto index = static_cast<std::size_t>(found - out_.columns.begin());
    if (row.cells.size() <= index) row.cells.resize(index + 1);
    row.cells[index] = cell_of(value);
  }
  void read_row(const JsonReader& reader) {
    BatchRow row;
    row.at = document_.value_position(reader.pointer());
    for (const std::string_view key : {"specimen", "protocol"}) {
      const JsonReader value = reader.at(key);  // reports a missing key
      if (reader.has(key)) put(row, std::string(key), value, false);
    }
    for (const std::string_view key : {"repeats", "note"}) {
      if (const auto value = reader.find(key)) put(row, std::string(key), *value, false);
    }
    for (const std::string_view key : kBatchTermColumns) {
      if (const auto value = reader.find(key)) put(row, std::string(key), *value, false);
    }
    if (const auto parameters = reader.find("parameters")) {
      for (const JsonReader& value : parameters->members()) {
        put(row, value.last_key(), value, true);
      }
    }
    reader.no_other_keys();
    out_.rows.push_back(std::move(row));
  }

  const JsonDocument& document_;
  JsonReader top_;
  BatchTable out_;
};

}  // namespace

Result<BatchTable> read_batch_json(std::string_view text, const std::string& source) {
  auto document = JsonDocument::parse(text, source);
  if (!document) return fail(document.error());
  return BatchJson(*document).read();
}

}  // namespace lcrig
