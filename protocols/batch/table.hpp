// SPDX-License-Identifier: Apache-2.0
// A table of runs as somebody wrote it (docs/batch-file.md): CSV with a header, or JSON `batch/1`.
// Every cell keeps its place, so that a mistake in it can be shown. batch.hpp makes runs from it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "base/text_place.hpp"

namespace lcrig {

struct BatchCell {
  std::string text;
  TextPosition at;
};
struct BatchColumn {
  std::string name;
  TextPosition at;
  bool is_parameter = false;  // JSON says so; of a CSV column only its name tells
};
struct BatchRow {
  TextPosition at;
  std::vector<BatchCell> cells;  // one a column; an empty text says nothing
};

struct BatchTable {
  std::string source;  // what messages call it
  std::string text;
  // Facts that a JSON batch states about itself. `terms`: by their names, for all rows.
  std::optional<BatchCell> name, order, seed;
  std::map<std::string, BatchCell> terms;
  std::vector<BatchColumn> columns;
  std::vector<BatchRow> rows;
};

inline constexpr std::size_t kBatchRowsMax = 10'000;

// Collects what is wrong with a table, to be said at once.
class BatchMistakes {
 public:
  // `where`: the column, or another name for the place; may be empty.
  void add(TextPosition at, std::string_view where, std::string what);
  bool empty() const { return mistakes_.empty(); }
  // In the order of the file, in the form of base/strict_json.hpp: the first is the message, its
  // `detail` shows the line with a caret and lists the others.
  Result<> result(const std::string& source, std::string_view text) const;

 private:
  struct Mistake {
    TextPosition at;
    std::string where, what;
  };
  std::vector<Mistake> mistakes_;
};

// Reads CSV, or JSON when the first character is `{`. Errors: invalid_request.
Result<BatchTable> read_batch_table(std::string_view text, const std::string& source);

// The two forms; read_batch_table chooses. `text` is UTF-8. Errors: invalid_request.
Result<BatchTable> read_batch_csv(std::string_view text, const std::string& source);
Result<BatchTable> read_batch_json(std::string_view text, const std::string& source);

}  // namespace lcrig
