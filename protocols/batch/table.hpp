// SPDX-License-Identifier: Apache-2.0
// A table of runs as a person wrote it (docs/batch-file.md): CSV with a header, or JSON `batch/1`.
// Every cell keeps its position, so that messages can show a mistake in it. batch.hpp turns tables
// into runs.
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
  bool is_parameter = false;  // JSON marks it; in CSV only the name shows it
};
struct BatchRow {
  TextPosition at;
  std::vector<BatchCell> cells;  // one for each column; an empty text means no value
};

struct BatchTable {
  std::string source;  // its name in messages
  std::string text;
  // Facts that a JSON batch states about itself. `terms`, by name, apply to all rows.
  std::optional<BatchCell> name, order, seed;
  std::map<std::string, BatchCell> terms;
  std::vector<BatchColumn> columns;
  std::vector<BatchRow> rows;
};

inline constexpr std::size_t kBatchRowsMax = 10'000;

// Collects the mistakes of a table, to report them all at once.
class BatchMistakes {
 public:
  // `where` is the column or another name of the place; it may be empty.
  void add(TextPosition at, std::string_view where, std::string what);
  bool empty() const { return mistakes_.empty(); }
  // As refuse_at.
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

// Read one of the two forms, which read_batch_table chooses. `text` is UTF-8. Errors:
// invalid_request.
Result<BatchTable> read_batch_csv(std::string_view text, const std::string& source);
Result<BatchTable> read_batch_json(std::string_view text, const std::string& source);

}  // namespace lcrig
