// SPDX-License-Identifier: Apache-2.0
// The hash chain of a run: one link per commit, over all rows of that commit and the previous link.
// The recorder appends links; `lcrig verify` and the report check them. The chain shows that rows
// were changed, removed or added outside the program. Only a copy of its last hash (`lcrig verify`
// prints it) protects against somebody who rewrites the whole chain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "storage/row_hash.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// Tables of numbered rows, in the order in which a link covers them.
enum class RunTable { level, event, lcr_reading, frame_sample, run_note };
constexpr std::size_t kRunTables = 5;

// The last link of a run.
struct ChainHead {
  std::int64_t run = 0;
  std::int64_t seq = 0;  // 0: no link yet
  std::int64_t last[kRunTables] = {};  // seq of the last row of each table
  bool ended = false;
  Sha256 hash{};
  std::int64_t& last_of(RunTable t) { return last[static_cast<std::size_t>(t)]; }
};

// Inserts rows into one table and hashes them. Add the values in the order of the table's columns.
class RowWriter {
 public:
  static Result<RowWriter> prepare(const Database& db, std::string_view table);
  RowWriter& begin(RowHash& hash);
  RowWriter& add(std::int64_t value);
  RowWriter& add(double value);
  RowWriter& add(std::string_view text);  // must live until `insert`
  RowWriter& add(std::optional<double> value);
  RowWriter& add(std::optional<std::int64_t> value);
  Result<> insert() { return statement_.run(); }

 private:
  RowWriter& null();
  Statement statement_;
  char tag_ = 0;
  int next_ = 0;
  RowHash* hash_ = nullptr;
};

// Reads and appends links. Use inside the transaction that holds the rows.
class ChainWriter {
 public:
  static Result<ChainWriter> prepare(const Database& db);
  Result<ChainHead> head(std::int64_t run);
  // The caller sets `last` and `ended` in `head`; this advances its seq and hash.
  Result<> append(ChainHead& head, RowHash& rows);

 private:
  Statement head_, append_;
};

struct ChainReport {
  bool intact = false;
  std::int64_t links = 0, rows = 0;
  bool ended = false;
  std::string last_hash;  // hex
  std::string finding;  // what is wrong, empty when intact
};
// Errors: no such run, an unreadable database. A broken chain is a report, not an error.
Result<ChainReport> verify_chain(const Database& db, std::int64_t run);

}  // namespace lcrig
