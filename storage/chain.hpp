// SPDX-License-Identifier: Apache-2.0
// The hash chain of a run: one link per commit, over all rows of that commit and the previous link.
// The recorder appends links; `lcrig verify` and the report check them. The chain shows that rows
// were changed, removed or added outside the program. A person who may write the file can cut or
// rewrite rows and links alike; only an anchor that is kept elsewhere finds that
// (docs/database.md).
#pragma once

#include <concepts>
#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "base/time.hpp"
#include "storage/anchor.hpp"
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

// Inserts rows into one table and hashes them.
class RowWriter {
 public:
  static Result<RowWriter> prepare(const Database& db, std::string_view table);
  RowWriter& begin(RowHash& hash);
  // The values of the next columns, in their order. Texts must live until `insert`.
  template <class... Values>
  RowWriter& add(const Values&... values) {
    (put(values), ...);
    return *this;
  }
  // For a run that was copied: its number here, and the one that its chain covers.
  RowWriter& add_number(std::int64_t stored, std::int64_t hashed);
  Result<> insert() { return statement_.run(); }

 private:
  void put(std::integral auto value) { add_number(value, value); }
  void put(double value);
  void put(std::string_view text);
  void put(MonoTime t) { put(t.time_since_epoch().count()); }
  template <class T>
  void put(const std::optional<T>& value) {
    if (value) return put(*value);
    put_null();
  }
  void put_null();
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
  // Stores the link at the end of the run, which was just appended, as its anchor. An anchor that
  // is there already stays: then somebody has removed the end that belongs to it.
  Result<> anchor(const ChainHead& head);

 private:
  Statement head_, append_, anchor_;
};

struct ChainReport {
  bool intact = false;
  Anchor head;  // the last link that was checked; of a broken chain nothing to be kept
  std::int64_t rows = 0;
  bool ended = false;
  bool goes_on = false;  // without an end, but its writer is recording it
  std::string finding;  // what is wrong, empty when intact
  bool other_anchor = false;  // of the anchor that was given: it may be another run's
  bool not_closed = false;  // that it has no end: a daemon that starts closes it
};
// A run without an end is intact only while it goes on. `anchor`: of this run, kept elsewhere.
// Reads in the caller's transaction, or in one of its own. Errors: no such run, an unreadable
// database. A broken chain is a report, not an error.
Result<ChainReport> verify_chain(const Database& db, std::int64_t run,
                                 const std::optional<Anchor>& anchor = std::nullopt);
// The same with a connection and a thread of its own, beside what the caller reads.
std::future<Result<ChainReport>> verify_aside(const Database& db, std::int64_t run);
// The anchor that people may keep. nullopt for a broken chain, whose hashes are those of changed
// rows.
std::optional<Anchor> anchor_of(const ChainReport& chain);
// "not as it was recorded: link 3 ..."; empty when it is intact.
std::string remark_on(const ChainReport& chain);

}  // namespace lcrig
