// SPDX-License-Identifier: Apache-2.0
// The hash chain of a run: one link per commit, over all rows of that commit and the previous link.
// The recorder appends links; `lcrig verify` and the report check them. The chain shows that rows
// were changed, removed or added outside the program. A person who may write the file can cut or
// rewrite rows and links alike; only an anchor that is kept elsewhere reveals that
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
  // Adds the values of the next columns, in order. Texts must live until `insert`.
  template <class... Values>
  RowWriter& add(const Values&... values) {
    (put(values), ...);
    return *this;
  }
  // Adds two numbers for a copied run: the one stored here, and the one that its chain covers.
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

// Reads and appends links. Use it inside the transaction that writes the rows.
class ChainWriter {
 public:
  static Result<ChainWriter> prepare(const Database& db);
  Result<ChainHead> head(std::int64_t run);
  // The caller sets `last` and `ended` in `head`; this function advances its seq and hash.
  Result<> append(ChainHead& head, RowHash& rows);
  // Stores the link at the end of the run, which was just appended, as its anchor. An existing
  // anchor is kept: it shows that somebody removed the end that belongs to it.
  Result<> anchor(const ChainHead& head);

 private:
  Statement head_, append_, anchor_;
};

struct ChainReport {
  bool intact = false;
  Anchor head;  // the last link that was checked; not to be kept from a broken chain
  std::int64_t rows = 0;
  bool ended = false;
  bool goes_on = false;  // without an end, but its writer is still recording it
  std::string finding;  // what is wrong, empty when intact
  bool other_anchor = false;  // the finding is about the given anchor, which may be another run's
  bool not_closed = false;  // the finding is the missing end: the next start of a daemon closes the
                            // run
};
// Checks the chain of `run`. A run without an end is intact only while it is being recorded.
// `anchor`: this run's, kept elsewhere. Reads in the caller's transaction, or in one of its own.
// Errors: no such run, an unreadable database. A broken chain is a report, not an error.
Result<ChainReport> verify_chain(const Database& db, std::int64_t run,
                                 const std::optional<Anchor>& anchor = std::nullopt);
// The same on a thread and a connection of its own, while the caller reads.
std::future<Result<ChainReport>> verify_aside(const Database& db, std::int64_t run);
// The anchor for people to keep. nullopt for a broken chain, because its hashes cover changed rows.
std::optional<Anchor> anchor_of(const ChainReport& chain);
// "not as it was recorded: link 3 ..."; empty when the chain is intact.
std::string remark_on(const ChainReport& chain);

}  // namespace lcrig
